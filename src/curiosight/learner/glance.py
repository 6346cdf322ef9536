"""A frame in a few pixels: enough to tell whether what it shows is as it was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Depth, Frame, Label, Pose, Rgb

Array = npt.NDArray[Any]

# Along each side: pixels, and of these in a block that is compared as a whole.
N_DOWN, N_ACROSS, BLOCK = 36, 48, 6
# What is darker or brighter tells no colour.
DARKEST, BRIGHTEST = 8, 247


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """What a posed frame with depth shows, on a coarse grid of its pixels.

    depth: (h, w) float32 metres along z, NaN = no reading. rgb: (h, w, 3). is_salient: (h, w) bool,
    as its teacher has it. pinhole: (4,) fx, fy, cx, cy in pixels of the grid. T_world_camera:
    (4, 4).
    """

    depth: Depth
    rgb: Rgb
    is_salient: npt.NDArray[np.bool_]
    pinhole: Array
    T_world_camera: Pose

    @classmethod
    def of(cls, frame: Frame, labels: npt.NDArray[np.uint8]) -> Self | None:
        """Return that of a frame with (H, W) labels; None without depth or a pose."""
        depth, camera, pose = frame.depth, frame.camera, frame.T_world_camera
        if depth is None or camera is None or pose is None or frame.problem is not None:
            return None
        height, width = depth.shape
        across, down = N_ACROSS / width, N_DOWN / height
        pinhole = np.array(
            [
                camera.fx * across,
                camera.fy * down,
                (camera.cx + 0.5) * across - 0.5,
                (camera.cy + 0.5) * down - 0.5,
            ]
        )
        size = N_DOWN, N_ACROSS
        sampled = (
            np.empty(size, np.float32),
            np.empty(size, np.bool_),
            np.empty((*size, 3), np.uint8),
        )
        _sample(depth, labels, np.uint8(Label.SALIENT), frame.rgb, *sampled)
        return cls(sampled[0], sampled[2], sampled[1], pinhole, np.asarray(pose, np.float64))

    @property
    def colours(self) -> npt.NDArray[np.float32]:
        """(h, w, 3) float32, see `colours_of`."""
        return colours_of(self.rgb)


@njit(cache=True, nogil=True)
def _sample(
    depth: Array,
    labels: Array,
    salient: int,
    rgb: Array,
    some_depth: Array,
    some_salient: Array,
    some_rgb: Array,
) -> None:
    """Take evenly spaced pixels; of colours the mean of four, for they are of patterns."""
    for row in range(some_depth.shape[0]):
        v = (2 * row + 1) * depth.shape[0] // (2 * some_depth.shape[0])
        up = max(0, v - 1)
        for column in range(some_depth.shape[1]):
            u = (2 * column + 1) * depth.shape[1] // (2 * some_depth.shape[1])
            left = max(0, u - 1)
            some_depth[row, column] = depth[v, u]
            some_salient[row, column] = labels[v, u] == salient
            for colour in range(3):
                above = np.int64(rgb[up, left, colour]) + np.int64(rgb[up, u, colour])
                here = np.int64(rgb[v, left, colour]) + np.int64(rgb[v, u, colour])
                some_rgb[row, column, colour] = (above + here) // 4


def colours_of(rgb: Rgb) -> npt.NDArray[np.float32]:
    """Return (h, w, 3) float32 of an image: brightness, red over green, and blue over green.

    They are natural logarithms; brightness is the geometric mean. NaN where a colour is too dark
    or too bright to tell.
    """
    return np.asarray(_take_logarithms(rgb, _LOGARITHMS))


# NaN for what is too dark or too bright.
_LOGARITHMS = np.full(256, np.nan, np.float32)
_LOGARITHMS[DARKEST + 1 : BRIGHTEST] = np.log(np.arange(DARKEST + 1, BRIGHTEST))


@njit(cache=True, nogil=True)
def _take_logarithms(rgb: Array, logarithms: Array) -> Array:
    found = np.empty(rgb.shape, np.float32)
    for v in range(rgb.shape[0]):
        for u in range(rgb.shape[1]):
            red, green, blue = (
                logarithms[rgb[v, u, 0]],
                logarithms[rgb[v, u, 1]],
                logarithms[rgb[v, u, 2]],
            )
            found[v, u, 0] = (red + green + blue) / np.float32(3)
            found[v, u, 1] = red - green + np.float32(0) * blue
            found[v, u, 2] = blue - green + np.float32(0) * red
    return found
