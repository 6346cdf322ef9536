"""`curiosight map` with the depth at hand, how sure and how probable."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import files, refusal, succeed
from recordings import write_image

Capsys = pytest.CaptureFixture[str]


def grey(path: Path) -> np.ndarray:
    found = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert found.ndim == 2
    assert found.dtype == np.uint8
    return found


def test_depth_at_hand_is_fused_and_what_it_shows_is_marked(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    """In the dark, so that nothing looks like what was learned."""
    dark = shutil.copytree(room, tmp_path / "dark")
    for path in (dark / "rgb").iterdir():
        write_image(path, np.full((120, 160, 3), 20, np.uint8))
    options = ["--depth", "--uncertainty", "--probability", "--overlay"]
    succeed(capsys, "map", model, dark, "--out", tmp_path / "fused", *options)
    succeed(capsys, "map", model, dark, "--out", tmp_path / "learned")
    for folder in ("", "seen", "uncertainty", "probability"):
        assert f"{folder}/000004.png".lstrip("/") in files(tmp_path / "fused")
    truth = grey(room / "ground_truth/000004.png")
    fused, learned = (grey(tmp_path / name / "000004.png") for name in ("fused", "learned"))
    seen = grey(tmp_path / "fused/seen/000004.png")
    assert set(np.unique(seen)) == {0, 255}
    is_shown = (seen == 255) & (truth == 255)
    assert is_shown.any()
    assert (fused[is_shown] > 127).mean() > 0.9
    assert (learned[is_shown] > 127).mean() < 0.5
    assert (fused[(seen == 255) & (truth == 0)] > 127).mean() < 0.05
    assert not files(tmp_path / "learned") & {"seen/000004.png", "uncertainty/000004.png"}


def test_colour_alone_has_a_probability_and_an_uncertainty_and_sees_nothing(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ["--uncertainty", "--probability"]
    succeed(capsys, "map", model, room / "rgb", "--out", tmp_path / "out", *options)
    written = files(tmp_path / "out")
    assert {"000004.png", "uncertainty/000004.png", "probability/000004.png"} <= written
    assert "seen/000004.png" not in written
    truth = grey(room / "ground_truth/000004.png")
    told = grey(tmp_path / "out/probability/000004.png")
    assert told[truth == 255].mean() > told[truth == 0].mean() + 50


def test_pictures_without_depth_are_refused(model: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_image(tmp_path / "photos/one.png", np.zeros((60, 80, 3), np.uint8))
    out = tmp_path / "out"
    line = refusal(capsys, "map", model, tmp_path / "photos", "--depth", "--out", out)
    assert "no depth" in line
    assert "without --depth" in line
    assert not out.exists()
