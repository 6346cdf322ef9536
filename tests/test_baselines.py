"""What every method promises: an image in, a map in [0, 1] out, or a clear error."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.evaluation.baselines import METHODS
from golden_maps import GOLDEN, IMAGES, assert_equals_golden, golden_input

# These methods work on maps that smaller images do not have.
LEAST_SIDE = {"gbvs": 128, "gbvs-fast": 128}
SIZES = [(1, 1), (2, 3), (1, 12), (9, 7), (130, 140)]

names = pytest.mark.parametrize("name", METHODS)


def texture(size: tuple[int, int]) -> np.ndarray:
    return golden_input("sk_coffee")[: size[0], : size[1]].copy()


@names
@pytest.mark.parametrize("size", SIZES)
def test_images_of_any_size_have_maps(name: str, size: tuple[int, int]) -> None:
    method, rgb = METHODS[name], texture(size)
    if min(size) < LEAST_SIDE.get(name, 0):
        with pytest.raises(ValueError, match="rgb: expected sides of at least 128"):
            method(rgb)
        return
    for image in (rgb, np.repeat(rgb[..., :1], 3, axis=2)):
        before = image.copy()
        saliency = method(image)
        assert saliency.shape == size
        assert saliency.dtype == np.float32
        assert np.isfinite(saliency).all()
        assert 0 <= saliency.min() <= saliency.max() <= 1
        assert np.array_equal(image, before)
        assert np.array_equal(method(image), saliency)


@names
@pytest.mark.parametrize("grey", [0, 77, 255])
def test_images_without_contrast_have_empty_maps(name: str, grey: int) -> None:
    for size in SIZES:
        if min(size) >= LEAST_SIDE.get(name, 0):
            assert not METHODS[name](np.full((*size, 3), grey, np.uint8)).any()


@names
def test_how_an_image_lies_in_memory_changes_nothing(name: str) -> None:
    view = texture((260, 150)).transpose(1, 0, 2)[:, ::-1, ::-1]
    assert np.array_equal(METHODS[name](view), METHODS[name](np.ascontiguousarray(view)))


@names
@pytest.mark.parametrize(
    "image",
    [
        np.zeros((140, 140), np.uint8),
        np.zeros((140, 140, 3), np.float32),
        np.zeros((140, 140, 4), np.uint8),
        np.zeros((0, 140, 3), np.uint8),
    ],
    ids=["grey", "float", "alpha", "empty"],
)
def test_other_arrays_are_refused(name: str, image: Any) -> None:
    with pytest.raises(ValueError, match="rgb: expected"):
        METHODS[name](image)


@pytest.mark.parametrize("image", IMAGES)
def test_fine_grained_is_opencvs(image: str) -> None:
    saliency = METHODS["fine-grained"](golden_input(image))
    assert_equals_golden(saliency, "cv2_finegrained", image, pearson=0.9999, levels=2)


def test_benchmark_holds_every_method_against_its_original(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "benchmarks")
    benchmark = importlib.import_module("baselines")
    assert benchmark.ORIGINALS.keys() == METHODS.keys() | {"u2netp"}
    figures = {"mb": benchmark.compare("mb", GOLDEN, repeats=1)}
    assert figures["mb"]["images"] == 6
    assert figures["mb"]["largest_difference"] == 0
    last = benchmark.table_of(figures).splitlines()[-1]
    assert last.startswith("| `mb` | `mbd_mb` (6) | 1.000000 | 0 | ")


def test_methods_are_called_as_in_the_commands() -> None:
    assert set(METHODS) == {
        "bms",
        "bms-fixation",
        "bms-pami",
        "bms-rliac",
        "gbvs",
        "gbvs-fast",
        "vocus2",
        "vocus2-kitchen",
        "vocus2-msra",
        "itti",
        "mb",
        "mbplus",
        "spectral-residual",
        "frequency-tuned",
        "fine-grained",
    }
