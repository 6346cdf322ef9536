"""Find the files of a recording: images in natural order, sequences, ground truth."""

from __future__ import annotations

import fnmatch
import os
import re
from collections.abc import Callable, Collection, Iterable
from pathlib import Path

from curiosight.datasets.masks import find_masks
from curiosight.errors import DataError

IMAGE_ENDINGS = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".webp", ".ppm", ".tif", ".tiff"})


def natural_key(text: str) -> tuple[tuple[int, int | str], ...]:
    """Order names as people do.

    >>> sorted(["img10", "img2"], key=natural_key)
    ['img2', 'img10']
    """
    parts = re.split(r"(\d+)", text)
    return tuple((0, int(part)) if part.isdecimal() else (1, part) for part in parts if part)


def frame_id(path: Path) -> str:
    """Name a frame after its colour file: `frame-000001.color.png` is `frame-000001`."""
    stem = path.stem
    for suffix in (".color", "-color"):
        stem = stem.removesuffix(suffix)
    return stem


def list_images(folder: Path, endings: Collection[str] = IMAGE_ENDINGS) -> dict[str, Path]:
    """Map frame ids to the colour images of a folder, in natural order; depth files left out.

    endings: of the images, in small letters. Raises `DataError` where two files would give
    frames of the same id.
    """
    images: dict[str, Path] = {}
    for path in sorted(folder.iterdir(), key=lambda path: natural_key(path.name)):
        is_image = path.suffix.lower() in endings and not path.name.startswith(".")
        if not is_image or path.stem.endswith((".depth", "-depth", "_depth")):
            continue
        twin = images.setdefault(frame_id(path), path)
        if twin != path:
            raise DataError(
                folder, f"{twin.name} and {path.name} are the same frame", "keep one of the two"
            )
    return images


def subfolder(root: Path, names: Iterable[str]) -> Path | None:
    """Return the first of the named folders inside `root` that exists, else None."""
    return next((root / name for name in names if (root / name).is_dir()), None)


def find_sequences(
    root: Path, holds_frames: Callable[[Path], bool], *, levels: int, pattern: str = "*"
) -> dict[str, Path]:
    """Map id prefixes ("" or "seq-01/") to the folders of a recording that hold frames.

    Looks at `root` itself, then down to `levels` folders below it, in natural order, into
    folders that match `pattern`. A single sequence needs no prefix.
    """
    if holds_frames(root):
        return {"": root}
    found: list[Path] = []
    _search(root, holds_frames, levels, pattern, found)
    if len(found) == 1:
        return {"": found[0]}
    return {f"{folder.relative_to(root).as_posix()}/": folder for folder in found}


def _search(
    folder: Path, holds_frames: Callable[[Path], bool], levels: int, pattern: str, found: list[Path]
) -> None:
    if levels == 0:
        return
    for child in sorted(_folders(folder, pattern), key=lambda path: natural_key(path.name)):
        if holds_frames(child):
            found.append(child)
        else:
            _search(child, holds_frames, levels - 1, pattern, found)


def places_of(folder: Path) -> list[Path]:
    """Return where a folder lies: as it is called, each link on the way, and where it ends."""
    places = [Path(os.path.abspath(folder))]
    while places[-1].is_symlink():
        target = places[-1].parent / places[-1].readlink()
        place = Path(os.path.abspath(target))
        if place in places:
            break
        places.append(place)
    return list(dict.fromkeys([*places, folder.resolve()]))


def _folders(folder: Path, pattern: str) -> list[Path]:
    """Return the folders in a folder, which may hold thousands of files."""
    try:
        with os.scandir(folder) as children:
            names = [child.name for child in children if child.is_dir()]
    except (NotADirectoryError, PermissionError):
        return []
    return [folder / name for name in names if fnmatch.fnmatch(name, pattern)]


def find_ground_truth(
    root: Path, sequence: Path | None = None, prefix: str = ""
) -> dict[str, Path]:
    """Map frame ids, without the prefix, to the ground-truth files of a sequence.

    `root` is the folder that was opened, `sequence` the one with the frames (default: the
    same). Where a single sequence of a larger recording was opened, the ground truth may
    stand beside it.
    """
    sequence = sequence or root
    folders = [root / "ground_truth" / prefix, sequence / "ground_truth"]
    if sequence == root:
        for opened in places_of(sequence):
            if opened.name.startswith("seq"):
                beside = opened.parent / "ground_truth"
                folders.append(beside / opened.name)
                # Beside several sequences a bare id would be ambiguous.
                if len(list(opened.parent.glob("seq*/"))) == 1:
                    folders.append(beside)
    files: dict[str, Path] = {}
    for folder in reversed(folders):
        files.update(find_masks(folder))
    return files
