"""Read masks of 255 and 0, and tell a set of them from masks that mean something else."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.arrays import read_array
from curiosight.datasets.cameras.camera_file import GROUND_TRUTH_VALUES, LabelValues
from curiosight.datasets.decoding import ColourCoded, UnreadableFile, is_lossy, read_grey
from curiosight.errors import DataError
from curiosight.frame import Label

Values = npt.NDArray[Any]

# In this order: of two files of one frame, the one that keeps its values.
MASK_ENDINGS = (".png", ".npy", ".tif", ".tiff", ".bmp", ".webp", ".jpg", ".jpeg")
CODES = (Label.NOT_SALIENT, Label.UNAVAILABLE, Label.UNKNOWN, Label.SALIENT)
# Masks to look at before a set is judged: the first one with an object usually ends it.
N_LOOKED_AT = 64
# A lossy file moves greys this far, and what lies between two codes is an outline.
MAX_SMEAR = 16
# Nobody paints "cannot say" in a grey that looks black: these are numbers of classes or objects.
MAX_NUMBER = 31
BY_CAMERA_FILE = ', or say what the values mean with "labels" in camera.json'
PAINT_GREYS = "write greys: 255 salient, 0 not salient, 125 unknown"


def read_numbers(path: Path, *, is_turned: bool = False) -> Values:
    """Read a mask or label image of any ending as (H, W) uint8 or uint16; `UnreadableFile`.

    True and False of a NumPy file become 255 and 0. is_turned: see `read_rgb`.
    """
    return _read_array(path) if path.suffix == ".npy" else read_grey(path, is_turned=is_turned)


def read_mask(path: Path, *, is_turned: bool = False) -> Values:
    """Read a mask of the codes of `Label`, (H, W) uint8 or uint16; raise `UnreadableFile`.

    In lossy files each grey becomes the code that it lies next to, or unknown. Masks of 16 bits
    that a program made of 8 come back to these.
    """
    values = read_numbers(path, is_turned=is_turned)
    if values.size and values.dtype == np.uint16 and values.max() > 255:
        # 255 * 257 is 65535: so a grey of 8 bits is written with 16.
        return (values // 257).astype(np.uint8) if not (values % 257).any() else values
    if values.size and values.max() > MAX_SMEAR and _is_lossy(path):
        return _unsmeared(values)
    return values


def find_masks(folder: Path) -> dict[str, Path]:
    """Map names without ending to the masks that lie in a folder; none if there is no folder."""
    files = list(folder.iterdir()) if folder.is_dir() else []
    return {file.stem: file for file in by_ending(file for file in files if is_mask(file))}


def is_mask(file: Path) -> bool:
    """Tell whether a file may be a mask by its name."""
    return file.suffix.lower() in MASK_ENDINGS and not file.name.startswith(".")


def by_ending(files: Iterable[Path]) -> list[Path]:
    """Sort files so that of two with the same name the better one comes last."""
    return sorted(files, key=lambda file: -MASK_ENDINGS.index(file.suffix.lower()))


def find_all_masks(folder: Path) -> Iterator[Path]:
    """Yield the masks in a folder and below it, linked folders too, in order of their names."""
    seen = set[str]()
    for place, folders, names in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        if real in seen:  # a link to a folder above
            folders.clear()
            continue
        seen.add(real)
        folders.sort()
        yield from filter(is_mask, (Path(place, name) for name in sorted(names)))


def judge_masks(
    files: Sequence[Path],
    labels: LabelValues | None,
    remarks: list[str],
    *,
    is_turned: bool = False,
    may_be_labelled: bool = True,
) -> LabelValues:
    """Return what the values of a recording's masks mean: 255 and 0, or else `labels`.

    labels: what `camera.json` says. may_be_labelled: it can be asked to. Remarks on masks that
    mark nothing; raises as `check_masks`.
    """
    counts = _count_values(files, lambda file: read_mask(file, is_turned=is_turned))
    if not _are_codes(counts):
        if labels is None:
            remedy = _remedy(counts) + (BY_CAMERA_FILE if may_be_labelled else "")
            raise DataError(files[0].parent, _found(counts), remedy)
        return labels
    if counts.any() and not counts[Label.SALIENT :].any():
        n_looked_at = len(_spread(files))
        remarks.append(f"none of {n_looked_at} masks looked at marks anything as salient")
    return GROUND_TRUTH_VALUES


def check_masks(files: Sequence[Path], *, is_turned: bool = False) -> None:
    """Raise `DataError` where a set of masks is not of 255 and 0, after a look at some of them.

    Refused are sets where no mask holds 255 but other values than those of `Label`, where
    numbers of classes outweigh it, and where all are painted in colours.
    """
    counts = _count_values(files, lambda file: read_mask(file, is_turned=is_turned))
    if not _are_codes(counts):
        raise DataError(files[0].parent, _found(counts), _remedy(counts))


def check_greys(files: Sequence[Path]) -> None:
    """Raise `DataError` where all masks or label images are painted in colours."""
    coloured: ColourCoded | None = None
    for file in _spread(files):
        try:
            read_numbers(file)
        except ColourCoded as fault:
            coloured = coloured or fault
        except UnreadableFile:
            continue
        else:
            return
    if coloured:
        raise DataError(files[0].parent, str(coloured), PAINT_GREYS)


def _count_values(files: Sequence[Path], read: Callable[[Path], Values]) -> npt.NDArray[np.int64]:
    """Count the pixels of each value, until a mask with an object leaves no doubt."""
    n_of_value = np.zeros(65536, np.int64)
    check_greys(files)
    for file in _spread(files):
        try:
            values = read(file)
        except UnreadableFile:
            continue
        n_of_value += np.bincount(values.ravel(), minlength=65536)
        if n_of_value[Label.SALIENT :].any() and _are_codes(n_of_value):
            break
    return n_of_value


def _spread(files: Sequence[Path]) -> list[Path]:
    chosen = np.linspace(0, len(files) - 1, min(len(files), N_LOOKED_AT)).astype(int)
    return [files[index] for index in chosen]


def _are_codes(n_of_value: npt.NDArray[np.int64]) -> bool:
    n_salient = n_of_value[Label.SALIENT :].sum()
    if n_salient:
        return bool(n_of_value[1 : MAX_NUMBER + 1].sum() <= n_salient)
    return set(np.flatnonzero(n_of_value).tolist()) <= set(CODES)


def _remedy(n_of_value: npt.NDArray[np.int64]) -> str:
    if np.flatnonzero(n_of_value).tolist() in ([1], [0, 1]):
        return "multiply by 255, so that objects are 255 and the rest 0"
    return "write 255 for objects, 0 for what is none and 125 for what is unknown"


def _found(n_of_value: npt.NDArray[np.int64]) -> str:
    others = [value for value in np.flatnonzero(n_of_value).tolist() if value not in CODES]
    listed = ", ".join(map(str, others[:5])) + (", …" if len(others) > 5 else "")
    values = f"pixels of value {listed}"
    if n_of_value[Label.SALIENT :].any():
        return f"its masks hold {values} besides 255, as numbers of classes"
    return f"no mask holds 255, but {values}"


def _unsmeared(values: Values) -> Values:
    codes = np.array(CODES, np.int16)
    distance = np.abs(np.arange(256, dtype=np.int16)[:, None] - codes)
    nearest = codes[distance.argmin(1)]
    nearest[distance.min(1) > MAX_SMEAR] = Label.UNKNOWN
    unsmeared: Values = nearest.astype(np.uint8)[values]
    return unsmeared


def _is_lossy(path: Path) -> bool:
    with path.open("rb") as file:  # which was read before
        return is_lossy(file.read(16))


def _read_array(path: Path) -> Values:
    try:
        array = read_array(path)
    except FileNotFoundError:
        raise UnreadableFile(f"{path.name} is missing") from None
    except (OSError, ValueError):
        raise UnreadableFile(f"{path.name} is not a NumPy array that can be read") from None
    if array.ndim != 2 or array.dtype not in (np.bool_, np.uint8, np.uint16):
        found = f"{array.shape} {array.dtype}"
        raise UnreadableFile(f"{path.name} is {found}, where a mask is (H, W) bool or uint8")
    values: Values = array.astype(np.uint8) * 255 if array.dtype == np.bool_ else array
    return values
