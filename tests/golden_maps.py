"""The maps of the original programs, and how near a map of ours comes to them.

Six images are free to copy and lie in `golden/` with their maps; the others are read from
`golden/` in the folder that CURIOSIGHT_TEST_DATA names.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Rgb

GOLDEN = Path(__file__).parent / "golden"
FREE = ("sk_astronaut", "sk_chelsea", "sk_coffee", "sk_rocket", "synth_disk", "synth_frame")
ELSEWHERE = (
    "gbvs_1",
    "gbvs_3",
    "tsdf_000000",
    "tsdf_000100",
    "tsdf_000200",
    "tsdf_000300",
    "tsdf_000500",
    "tsdf_000700",
    "tsdf_000900",
    "vocus2_msra",
)
IMAGES = FREE + ELSEWHERE


def golden_input(image: str) -> Rgb:
    """Return an image that the originals were run on, (H, W, 3) uint8, red first."""
    return cv2.cvtColor(_read("inputs", image, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def golden_map(program: str, image: str) -> npt.NDArray[np.uint8]:
    """Return the map (h, w) uint8 that an original program made of an image."""
    return _read(program, image, cv2.IMREAD_GRAYSCALE)


def assert_equals_golden(
    saliency: npt.NDArray[np.float32], program: str, image: str, *, pearson: float, levels: int
) -> None:
    """Fail unless a map correlates with the original's and differs by few grey levels."""
    golden = golden_map(program, image)
    assert saliency.dtype == np.float32
    assert saliency.shape == golden.shape
    assert saliency.min() >= 0
    assert saliency.max() <= 1
    grey = np.rint(saliency.astype(np.float64) * 255)
    assert np.abs(grey - golden).max() <= levels
    assert np.corrcoef(grey.ravel(), golden.ravel())[0, 1] >= pearson


def _read(folder: str, image: str, flags: int) -> npt.NDArray[Any]:
    root = GOLDEN
    if image not in FREE:
        if "CURIOSIGHT_TEST_DATA" not in os.environ:
            pytest.skip("CURIOSIGHT_TEST_DATA is not set")
        root = Path(os.environ["CURIOSIGHT_TEST_DATA"]) / "golden"
    path = root / folder / f"{image}.png"
    pixels = cv2.imread(str(path), flags)
    assert pixels is not None, f"{path} is missing"
    return pixels
