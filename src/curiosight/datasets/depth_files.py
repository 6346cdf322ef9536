"""Read depth as files hold it, in whole numbers or floats, and bring it to metres along z."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.arrays import read_array
from curiosight.datasets.decoding import UnreadableFile, decode_unchanged
from curiosight.frame import Depth

ARRAY_ENDINGS = (".npy", ".npz")
DEPTH_ENDINGS = (".png", ".pgm", ".tif", ".tiff", *ARRAY_ENDINGS)
OUT_OF_RANGE = 65535
MAX_METRES = 100.0
N_BITS = 16

Raw = npt.NDArray[Any]


class EightBitDepth(UnreadableFile):
    """Name a depth image that has 8 bits a pixel: no distances can be read from it."""


@dataclass(frozen=True, slots=True)
class DepthForm:
    """What the numbers of depth files mean.

    scale: metres per unit of whole numbers. float_scale: of floats; what writes floats mostly
        means metres.
    rotated_bits: how far the 16 bits are rotated to the left, as SUN RGB-D stores them.
    is_assumed: no file says the unit; it is what the layout mostly has.
    """

    scale: float = 0.001
    float_scale: float = 1.0
    rotated_bits: int = 0
    is_assumed: bool = False

    def unit_m(self, raw: Raw) -> float:
        """Return metres per unit of (H, W) numbers."""
        return self.float_scale if raw.dtype.kind == "f" else self.scale

    def to_metres(self, raw: Raw) -> Depth:
        """Return (H, W) float32 metres; what is no reading becomes NaN.

        That is 0 and less, what is not finite, and the largest number of 16 bits.
        """
        if self.rotated_bits:
            raw = rotate_right(raw, self.rotated_bits)
        depth: Depth = (raw * np.float32(self.unit_m(raw))).astype(np.float32)
        is_reading = (raw > 0) & np.isfinite(depth)
        if raw.dtype == np.uint16:
            is_reading &= raw != OUT_OF_RANGE
        depth[~is_reading] = np.nan
        return depth


MILLIMETRES = DepthForm()
ASSUMED = DepthForm(is_assumed=True)


def assumed_form(paths: Iterable[Path], scale: float = 0.001) -> DepthForm:
    """Return how depth is read where no file says it: floats as metres, or as millimetres.

    scale: metres per unit of whole numbers. Floats of some hundreds can be no metres.
    """
    for path in paths:
        try:
            raw = read_raw_depth(path)
        except UnreadableFile:
            continue
        known = raw[np.isfinite(raw) & (raw > 0)] if raw.dtype.kind == "f" else raw[:0]
        is_metric = not known.size or float(np.median(known)) < MAX_METRES
        return DepthForm(scale, 1.0 if is_metric else 0.001, is_assumed=True)
    return DepthForm(scale, is_assumed=True)


def rotate_right(raw: Raw, n_bits: int) -> Raw:
    """Rotate the bits of (H, W) uint16 to the right; other types are returned as they are."""
    if raw.dtype != np.uint16:
        return raw
    rotated: Raw = (raw >> n_bits) | (raw << (N_BITS - n_bits))
    return rotated


def read_raw_depth(path: Path) -> Raw:
    """Read (H, W) numbers of depth, uint16 or wider or float; raise `UnreadableFile`.

    Images have 16 bits or floats, in one channel or in three that are equal; `.npy` and `.npz`
    hold one such array, or one that is called depth.
    """
    raw = _read_array(path) if path.suffix.lower() in ARRAY_ENDINGS else decode_unchanged(path)
    raw = _one_channel(path, raw)
    if raw.dtype in (np.uint8, np.int8, np.bool_):
        raise EightBitDepth(f"{path.name} has 8 bits a pixel where depth needs 16")
    if raw.dtype.kind not in "iuf":
        raise UnreadableFile(f"{path.name} holds {raw.dtype}, not numbers")
    return raw


def read_depth(path: Path, form: DepthForm = MILLIMETRES) -> Depth:
    """Read a depth file as (H, W) float32 metres, NaN = no reading; raise `UnreadableFile`."""
    return form.to_metres(read_raw_depth(path))


def _one_channel(path: Path, raw: Raw) -> Raw:
    """Return (H, W) of (H, W), (H, W, 1), (1, H, W) or equal channels; `UnreadableFile`."""
    if raw.ndim == 3 and 1 in (raw.shape[0], raw.shape[2]):
        raw = raw[0] if raw.shape[0] == 1 else raw[..., 0]
    if raw.ndim == 3 and raw.shape[2] in (3, 4):
        if all(np.array_equal(raw[..., 0], raw[..., channel]) for channel in (1, 2)):
            return raw[..., 0]
        found = f"{path.name} is no depth image: its {raw.shape[2]} channels differ"
        raise UnreadableFile(f"{found}; is it a picture of depth?")
    if raw.ndim != 2 or not raw.size:
        raise UnreadableFile(f"{path.name} is no depth image: its shape is {raw.shape}")
    return raw


def _read_array(path: Path) -> Raw:
    try:
        return read_array(path, lambda names: _depth_name(path, names))
    except FileNotFoundError:
        raise UnreadableFile(f"{path.name} is missing") from None
    except OSError as error:
        reason = error.strerror or "it is cut short or damaged"
        raise UnreadableFile(f"{path.name} cannot be read ({reason})") from error
    except ValueError as error:
        raise UnreadableFile(f"{path.name} is no array of numbers that NumPy reads") from error


def _depth_name(path: Path, names: list[str]) -> str:
    called = [name for name in names if "depth" in name.lower()]
    if len(names) == 1 or len(called) == 1:
        return (called or names)[0]
    raise UnreadableFile(
        f"{path.name} holds the arrays {', '.join(names[:5]) or 'none'}: none of them, or more "
        "than one, is called depth"
    )
