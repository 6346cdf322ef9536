"""The command that writes the maps of baselines."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from command import files, refusal, succeed
from curiosight.evaluation.baselines import METHODS
from golden_maps import GOLDEN

Capsys = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two images, one of them with less than 128 pixels to a side."""
    folder = tmp_path_factory.mktemp("images")
    rgb = cv2.imread(str(GOLDEN / "inputs" / "synth_disk.png"))
    cv2.imwrite(str(folder / "disk.png"), rgb)
    cv2.imwrite(str(folder / "small.png"), rgb[:100, :100])
    return folder


@pytest.mark.parametrize("method", ["frequency-tuned", "mb"])
def test_maps_equal_those_of_the_function(
    images: Path, tmp_path: Path, capsys: Capsys, method: str
) -> None:
    succeed(capsys, "saliency", method, images, "--out", tmp_path / "out")
    assert {"disk.png", "small.png"} <= files(tmp_path / "out")
    for name in ("disk", "small"):
        found = cv2.imread(str(tmp_path / "out" / f"{name}.png"), cv2.IMREAD_UNCHANGED)
        rgb = cv2.cvtColor(cv2.imread(str(images / f"{name}.png")), cv2.COLOR_BGR2RGB)
        np.testing.assert_array_equal(found, np.rint(255 * METHODS[method](rgb)).astype(np.uint8))


def test_images_that_a_method_cannot_take_are_named(
    images: Path, tmp_path: Path, capsys: Capsys
) -> None:
    told = succeed(capsys, "saliency", "gbvs-fast", images, "--out", tmp_path / "out")
    assert files(tmp_path / "out") == {"disk.png"}
    assert "128" in told.err


def test_unknown_method_is_one_line(images: Path, tmp_path: Path, capsys: Capsys) -> None:
    said = refusal(capsys, "saliency", "bsm", images, "--out", tmp_path / "out")
    assert "bms-rliac" in said
    assert not (tmp_path / "out").exists()
