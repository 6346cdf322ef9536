"""A frame in a few pixels: enough to tell whether what it shows is as it was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth, Frame, Label, Pose, Rgb

Array = npt.NDArray[Any]

# Along each side: pixels, and of these in a block that is compared as a whole.
N_DOWN, N_ACROSS, BLOCK = 48, 64, 8
# What is darker or brighter tells no colour.
DARKEST, BRIGHTEST = 8, 247


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """What a posed frame with depth shows, on a coarse grid of its pixels.

    depth: (h, w) float32 metres along z, NaN = no reading. colours: (h, w, 3) float32, see
    `colours_of`. is_salient: (h, w) bool, as its teacher has it. pinhole: (4,) fx, fy, cx, cy in
    pixels of the grid. T_world_camera: (4, 4).
    """

    depth: Depth
    colours: npt.NDArray[np.float32]
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
        v = ((np.arange(N_DOWN) + 0.5) * height / N_DOWN).astype(np.int64)
        u = ((np.arange(N_ACROSS) + 0.5) * width / N_ACROSS).astype(np.int64)
        where = np.ix_(v, u)
        small = cv2.resize(frame.rgb, (N_ACROSS, N_DOWN), interpolation=cv2.INTER_AREA)
        across, down = N_ACROSS / width, N_DOWN / height
        pinhole = np.array(
            [
                camera.fx * across,
                camera.fy * down,
                (camera.cx + 0.5) * across - 0.5,
                (camera.cy + 0.5) * down - 0.5,
            ]
        )
        return cls(
            depth[where].astype(np.float32),
            colours_of(small),
            labels[where] == Label.SALIENT,
            pinhole,
            pose.astype(np.float64),
        )


def colours_of(rgb: Rgb) -> npt.NDArray[np.float32]:
    """Return (h, w, 3) float32 of an image: brightness, red over green, and blue over green.

    They are natural logarithms; brightness is the geometric mean. NaN where a colour is too dark
    or too bright to tell.
    """
    is_told = ((rgb > DARKEST) & (rgb < BRIGHTEST)).all(axis=2)
    logs = _LOGARITHMS.take(rgb)
    red, green, blue = np.moveaxis(logs, 2, 0)
    colours = np.stack([(red + green + blue) / 3, red - green, blue - green], axis=2)
    colours[~is_told] = np.nan
    return colours


_LOGARITHMS = np.log(np.maximum(np.arange(256), 1)).astype(np.float32)
