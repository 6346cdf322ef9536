"""Minimum barrier distance to the border: J. Zhang, S. Sclaroff, Z. Lin, X. Shen, B. Price and
R. Mech, "Minimum Barrier Salient Object Detection at 80 FPS", ICCV 2015.

The barrier of a path is the range of grey levels that it crosses; what cannot be reached from
the border without crossing many is an object. Kept of the authors' C++ program: red and blue
change places on the way to Lab and to grey, the three passes of its scan, and what it takes for
a drawn frame.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.evaluation.baselines.maps import (
    Saliency,
    check_rgb,
    in_size_of,
    resized_to,
    stretched,
    to_grey,
)
from curiosight.evaluation.baselines.reconstruction import open_and_close_by_reconstruction
from curiosight.evaluation.baselines.whitening import whitening_of
from curiosight.frame import Rgb

Array = npt.NDArray[Any]
Grey = npt.NDArray[np.uint8]
FloatMap = npt.NDArray[np.float32]

LONGER_SIDE = 300
N_PASSES = 3
BORDER_SHARE = 0.1
# What the program takes for a drawn frame: within so many pixels, edges of so many grey levels,
# which fill a row to such a share; and how many pixels more it cuts.
FRAME_STRIP = 20
FRAME_EDGE = 102
FRAME_SHARE = 0.6
FRAME_EXTRA = 2
FAR = 100_000


def mb(rgb: Rgb) -> Saliency:
    """Return the map of the minimum barrier distance alone, (H, W) in [0, 1]."""
    return _minimum_barrier(rgb, has_backgroundness=False)


def mbplus(rgb: Rgb) -> Saliency:
    """Return MB+, (H, W) in [0, 1]: with how much a colour is unlike the border's."""
    return _minimum_barrier(rgb, has_backgroundness=True)


def _minimum_barrier(rgb: Rgb, *, has_backgroundness: bool) -> Saliency:
    check_rgb(rgb)
    small = resized_to(rgb, LONGER_SIDE)
    inner = inside_of_frame(small)
    lab = cv2.cvtColor(np.ascontiguousarray(small[inner]), cv2.COLOR_BGR2LAB)
    barrier = stretched(barrier_distance(cv2.medianBlur(lab, 5)))
    prior = cv2.resize(_centre_prior(), lab.shape[1::-1])
    if has_backgroundness:
        saliency, split = (barrier + _backgroundness(lab)) * prior, barrier
    else:
        # The original weights its only buffer, so that it splits by the weighted map.
        saliency = split = barrier * prior
    smooth = _smoothed(to_grey(saliency))
    grey = np.zeros(small.shape[:2], np.uint8)
    grey[inner] = to_grey(_contrasted(smooth, np.rint(255 * split) > 127))
    return in_size_of(rgb, grey)


def inside_of_frame(rgb: Rgb) -> tuple[slice, slice]:
    """Return rows and columns inside of a frame that is drawn around an image, if there is one.

    Where two sides or more have one, as much is cut from all four as from the widest.
    """
    height, width = rgb.shape[:2]
    grey = cv2.cvtColor(rgb, cv2.COLOR_BGR2GRAY)
    sides = (grey, grey[::-1], grey.T, grey.T[::-1])
    margins = np.array([_frame_margin(side[:FRAME_STRIP]) for side in sides])
    framed = margins > 0
    if framed.sum() >= 2:
        margins[:] = margins.max()
        framed[:] = True
    top, bottom, left, right = np.where(framed, margins + FRAME_EXTRA, 0)
    if top + bottom >= height or left + right >= width:
        return slice(0, height), slice(0, width)
    return slice(top, height - bottom), slice(left, width - right)


def _frame_margin(strip: Grey) -> int:
    """Return how many rows the frame takes of a strip along its edge, outermost row first."""
    edges = cv2.convertScaleAbs(cv2.Sobel(np.ascontiguousarray(strip), cv2.CV_32F, 0, 1))
    is_edge = (edges == cv2.dilate(edges, np.ones((5, 5), np.uint8))) & (edges >= FRAME_EDGE)
    rows = np.flatnonzero(is_edge.mean(axis=1) > FRAME_SHARE)
    return int(rows[-1]) + 1 if rows.size else 0


def barrier_distance(lab: Rgb) -> FloatMap:
    """Return the sum over channels of the barrier to the border, (H, W) float32 (alg. 1)."""
    barriers = [scan_barriers(channel) for channel in cv2.split(lab)]
    total: FloatMap = np.sum(barriers, axis=0, dtype=np.float32)
    return total


@njit(cache=True, nogil=True)
def scan_barriers(channel: Array) -> Array:
    """Return the (H, W) int32 barrier of one channel, in passes to and fro.

    The border itself is never reached anew. Of the two neighbours that a pass has left behind,
    the vertical one is asked last and so wins.
    """
    height, width = channel.shape
    distance = np.zeros((height, width), np.int32)
    distance[1:-1, 1:-1] = FAR
    grey, barrier = channel.ravel(), distance.ravel()
    low, high = grey.astype(np.int32), grey.astype(np.int32)
    for index in range(N_PASSES):
        start, step = (0, 1) if index % 2 == 0 else (grey.size - 1, -1)
        for v in range(1, height - 1):
            for u in range(1, width - 1):
                pixel = start + step * (v * width + u)
                for back in (1, width):
                    other = pixel - step * back
                    lowest = min(low[other], grey[pixel])
                    highest = max(high[other], grey[pixel])
                    if highest - lowest < barrier[pixel]:
                        barrier[pixel] = highest - lowest
                        low[pixel], high[pixel] = lowest, highest
    return distance


def _backgroundness(lab: Rgb) -> FloatMap:
    """Return how unlike the border's colours a pixel is, but for the side it is most unlike."""
    height, width = lab.shape[:2]
    rows, columns = (max(int(BORDER_SHARE * side), 1) for side in (height, width))
    colours = lab.astype(np.float64)
    strips = (
        colours[:rows],
        colours[height - rows :],
        colours[:, :columns],
        colours[:, width - columns :],
    )
    unlike = []
    for strip in strips:
        border = strip.reshape(-1, 3)
        matrix = whitening_of(border).T
        white = cv2.transform(colours, np.column_stack([matrix, -matrix @ border.mean(axis=0)]))
        unlike.append(stretched(cv2.transform(np.abs(white), np.ones((1, 3)))))
    result: FloatMap = stretched(np.sum(unlike, axis=0) - np.max(unlike, axis=0))
    return result


@lru_cache(maxsize=1)
def _centre_prior() -> FloatMap:
    """Return 1 in the middle of a 300x300 map, falling to 0 at the farthest corner."""
    place = np.arange(LONGER_SIDE, dtype=np.float32) - LONGER_SIDE // 2
    return 1 - stretched(np.hypot(place[:, None], place))


def _smoothed(grey: Grey) -> FloatMap:
    """Open and close by reconstruction, with a square as large as the objects are."""
    width = max(int(50 * np.sqrt(grey.mean() / 255)), 3)
    square = np.ones((2 * (width // 2) + 1,) * 2, np.uint8)
    smooth = open_and_close_by_reconstruction(grey, square, n_neighbours=4)
    return stretched(smooth.astype(np.float32))


def _contrasted(saliency: FloatMap, is_object: npt.NDArray[np.bool_]) -> FloatMap:
    """Push values away from the middle between object and background."""
    means = [saliency[part].mean() if part.any() else 0.0 for part in (is_object, ~is_object)]
    contrasted: FloatMap = 1 / (1 + np.exp(-10 * (saliency - sum(means) / 2)))
    return contrasted
