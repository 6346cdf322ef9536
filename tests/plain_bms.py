"""BMS as its paper tells it, one Boolean map after another: slow, and easy to believe."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

Array = npt.NDArray[Any]
SQUARE = np.ones((3, 3), np.uint8)


class PlainRandom:
    """OpenCV's cv::RNG in its default state."""

    def __init__(self) -> None:
        self.state = 0xFFFFFFFF

    def next(self) -> int:
        self.state = (self.state % 2**32) * 4164903690 + (self.state >> 32)
        return self.state % 2**32

    def jump(self, longest: int) -> int:
        uniform = ((self.next() << 32) | self.next()) / 2**64
        return min(5 + self.next() % 20, longest) if uniform > 0.99 else 0


def border_seeds(height: int, width: int, random: PlainRandom | None) -> list[tuple[int, int]]:
    """Return the seeds (v, u) of one map; they jump where there are random numbers."""
    seeds = []
    for v in range(height):
        for u, inwards in ((0, 1), (width - 1, -1)):
            seeds.append((v, u + inwards * (random.jump(width - 1) if random else 0)))
    for u in range(width):
        for v, inwards in ((0, 1), (height - 1, -1)):
            seeds.append((v + inwards * (random.jump(height - 1) if random else 0), u))
    return seeds


def surrounded(boolean_map: Array, seeds: list[tuple[int, int]]) -> npt.NDArray[np.bool_]:
    """Return the pixels whose 8-connected component of their own value has no seed."""
    result = np.zeros(boolean_map.shape, bool)
    for part in (boolean_map, ~boolean_map):
        _, component = cv2.connectedComponents(part.astype(np.uint8), connectivity=8)
        reached = {component[seed] for seed in seeds if part[seed]}
        result |= part & ~np.isin(component, list(reached))
    return result


def closed(boolean_map: Array, n_iterations: int) -> npt.NDArray[np.bool_]:
    grown = cv2.dilate(boolean_map.astype(np.uint8), SQUARE, iterations=n_iterations)
    return cv2.erode(grown, SQUARE, iterations=n_iterations).astype(bool)


def plain_attention(
    rgb: Rgb, *, n_closing: int, n_dilation: int, random: PlainRandom | None, by_norm: bool
) -> npt.NDArray[np.float64]:
    """Return the sum of all attention maps, each normalised."""
    total = np.zeros(rgb.shape[:2])
    for channel in cv2.split(cv2.cvtColor(rgb, cv2.COLOR_BGR2LAB)):
        for threshold in range(int(channel.min()), int(channel.max()), 8):
            for boolean_map in (channel > threshold, channel <= threshold):
                seeds = border_seeds(*channel.shape, random)
                attention = surrounded(closed(boolean_map, n_closing), seeds).astype(np.uint8)
                if n_dilation:
                    attention = cv2.dilate(attention, SQUARE, iterations=n_dilation)
                if attention.any() and (by_norm or not attention.all()):
                    total += attention / (np.sqrt(attention.sum()) if by_norm else 1.0)
    return total
