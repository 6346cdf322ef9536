"""Masks and label images as other programs write them, and which way up an image is read."""

from __future__ import annotations

import json
import re
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from command import call, refusal, succeed
from curiosight.datasets import check_dataset, open_dataset
from curiosight.datasets.decoding import UnreadableFile, read_grey, read_rgb
from curiosight.datasets.depth_files import DepthForm, read_depth
from curiosight.datasets.masks import read_mask, read_numbers
from curiosight.errors import DataError
from recordings import annotation, write_camera_file, write_folder, write_image, write_osd
from room import kinect

Capsys = pytest.CaptureFixture[str]
Numbers = npt.NDArray[np.uint8]
NUMBERS = np.arange(77, dtype=np.uint8).reshape(7, 11)
COLOURS = [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0, *range(1, 220)]
# x and y of the first pixel of each pass of Adam7, and the steps.
ADAM7 = (
    *((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4)),
    *((0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)),
)


def write_palette_png(path: Path, indices: Numbers, bits: int = 8, *, interlaced: bool) -> None:
    """Write a PNG with a palette, as libraries that save bits do."""
    height, width = indices.shape
    passes = ADAM7 if interlaced else ((0, 0, 1, 1),)
    parts = (indices[y::dy, x::dx] for x, y, dx, dy in passes)
    rows = b"".join(b"\0" + packed(row, bits) for part in parts if part.size for row in part)
    header = struct.pack(">IIBBBBB", width, height, bits, 3, 0, 0, interlaced)
    palette = bytes(COLOURS[: 3 * min(2**bits, 70)])
    chunks = (b"IHDR" + header, b"PLTE" + palette, b"IDAT" + zlib.compress(rows), b"IEND")
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + b"".join(
            struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
            for chunk in chunks
        )
    )


def packed(row: Numbers, bits: int) -> bytes:
    text = "".join(f"{value:0{bits}b}" for value in row)
    text = text.ljust(-(-len(text) // 8) * 8, "0")
    return bytes(int(text[at : at + 8], 2) for at in range(0, len(text), 8))


def save(path: Path, image: npt.NDArray[np.generic], *, orientation: int = 1) -> None:
    """Write an image that a viewer turns."""
    path.parent.mkdir(parents=True, exist_ok=True)
    exif = Image.Exif()
    exif[0x0112] = orientation
    quality = {"quality": 100, "subsampling": 0} if path.suffix == ".jpg" else {}
    Image.fromarray(image).save(path, exif=exif, **quality)


def save_masks(folder: Path, change: object) -> None:
    """Rewrite the masks of a recording, each as `change` says."""
    for path in folder.glob("*.png"):
        mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert callable(change)
        assert cv2.imwrite(str(path), change(mask))


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_palette_is_read_as_indices(bits: int, interlaced: bool, tmp_path: Path) -> None:
    indices = (NUMBERS % min(2**bits, 70)).astype(np.uint8)
    write_palette_png(tmp_path / "a.png", indices, bits, interlaced=interlaced)
    np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), indices)


@pytest.mark.parametrize("ending", ["png", "bmp", "tif"])
def test_palette_of_any_file(ending: str, tmp_path: Path) -> None:
    image = Image.fromarray(NUMBERS).convert("P")
    image.putpalette(COLOURS)
    image.save(tmp_path / f"a.{ending}", transparency=0)
    np.testing.assert_array_equal(read_grey(tmp_path / f"a.{ending}"), NUMBERS)


def test_palette_of_greys_is_a_grey_image(tmp_path: Path) -> None:
    image = Image.fromarray(NUMBERS % 2).convert("P")
    image.putpalette([0, 0, 0, 255, 255, 255])
    image.save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), NUMBERS % 2 * 255)


@pytest.mark.parametrize("mode", ["1", "L", "LA", "RGB", "RGBA"])
def test_black_and_white_of_any_channels(mode: str, tmp_path: Path) -> None:
    mask = np.where(NUMBERS > 30, 255, 0).astype(np.uint8)
    Image.fromarray(mask).convert(mode).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_grey(tmp_path / "a.png"), mask)


def test_sixteen_bits_made_of_eight(tmp_path: Path) -> None:
    codes = np.array([[0, 75, 125, 255]], np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), codes.astype(np.uint16) * 257)
    np.testing.assert_array_equal(read_mask(tmp_path / "a.png"), codes)


def test_masks_of_numpy_files(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", NUMBERS > 30)
    np.testing.assert_array_equal(read_numbers(tmp_path / "a.npy"), (NUMBERS > 30) * 255)
    np.save(tmp_path / "b.npy", NUMBERS / 2)
    with pytest.raises(UnreadableFile, match=r"b\.npy is \(7, 11\) float64"):
        read_numbers(tmp_path / "b.npy")
    content = (tmp_path / "a.npy").read_bytes()
    (tmp_path / "a.npy").write_bytes(content.replace(b"(7, 11)", b"(7, 99)"))
    with pytest.raises(UnreadableFile, match=r"a\.npy is not a NumPy array"):
        read_numbers(tmp_path / "a.npy")


def test_lossy_masks_are_read_as_the_codes_they_lie_next_to(tmp_path: Path) -> None:
    mask = np.zeros((48, 64), np.uint8)
    mask[10:30, 10:30], mask[30:40, 40:60] = 255, 125
    cv2.imwrite(str(tmp_path / "a.jpg"), mask, [cv2.IMWRITE_JPEG_QUALITY, 60])
    assert len(np.unique(read_grey(tmp_path / "a.jpg"))) > 3
    found = read_mask(tmp_path / "a.jpg")
    assert set(np.unique(found)) <= {0, 75, 125, 255}
    assert np.mean(found == mask) > 0.97


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "webp"])
def test_pixels_are_read_as_stored(ending: str, orientation: int, tmp_path: Path) -> None:
    colour = np.zeros((16, 24, 3), np.uint8)
    colour[2:5, 4:12] = 200
    path = tmp_path / f"a.{ending}"
    save(path, colour, orientation=orientation)
    np.testing.assert_allclose(read_rgb(path), colour, atol=30)
    np.testing.assert_allclose(read_grey(path), colour[..., 0], atol=30)
    if ending in ("png", "tif"):
        depth = np.arange(1, 385, dtype=np.uint16).reshape(16, 24)
        save(path, depth, orientation=orientation)
        np.testing.assert_allclose(read_depth(path, DepthForm(1.0)), depth)


@pytest.mark.parametrize("orientation", [3, 6])
@pytest.mark.parametrize("ending", ["png", "jpg"])
def test_orientation_turns_no_recording_with_depth(
    ending: str, orientation: int, tmp_path: Path
) -> None:
    views = write_folder(tmp_path, n_frames=1)
    (tmp_path / "rgb/000000.png").unlink()
    save(tmp_path / f"rgb/000000.{ending}", views[0].rgb, orientation=orientation)
    save(tmp_path / "ground_truth/000000.png", views[0].ground_truth, orientation=orientation)
    dataset = open_dataset(tmp_path)
    frame = dataset[0]
    assert frame.problem is None
    assert np.abs(frame.rgb.astype(int) - views[0].rgb).mean() < 2
    np.testing.assert_array_equal(dataset.ground_truth(0), views[0].ground_truth)


@pytest.mark.parametrize("ending", ["png", "jpg", "tif"])
def test_orientation_turns_pictures_and_their_masks(ending: str, tmp_path: Path) -> None:
    views = write_folder(tmp_path / "room", n_frames=1)
    save(tmp_path / "a.png", views[0].rgb, orientation=6)
    truth = views[0].ground_truth
    if ending == "png":
        save(tmp_path / "ground_truth/a.png", truth, orientation=6)
    else:  # as an editor saves it that turned the picture itself
        Image.fromarray(np.rot90(truth, -1)).save(tmp_path / f"ground_truth.{ending}")
        (tmp_path / "ground_truth").mkdir()
        (tmp_path / f"ground_truth.{ending}").rename(tmp_path / f"ground_truth/a.{ending}")
    dataset = open_dataset(tmp_path)
    np.testing.assert_array_equal(dataset[0].rgb, np.rot90(views[0].rgb, -1))
    found = dataset.ground_truth(0)
    assert found is not None
    assert np.mean(found == np.rot90(truth, -1)) > (0.95 if ending == "jpg" else 0.999)
    check_dataset(dataset)


def test_annotation_with_a_palette(tmp_path: Path) -> None:
    views = write_osd(tmp_path, n_frames=1)
    expected = open_dataset(tmp_path).ground_truth(0)
    write_palette_png(tmp_path / "annotation/learn0.png", annotation(views[0]), interlaced=False)
    np.testing.assert_array_equal(open_dataset(tmp_path).ground_truth(0), expected)


@pytest.mark.parametrize(
    ("value", "remedy"),
    [(1, "multiply by 255, so that objects are 255"), (7, "write 255 for objects, 0 for what")],
)
def test_masks_without_255_are_refused_in_one_line(
    value: int, remedy: str, tmp_path: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path / "r", n_frames=2)
    folder = tmp_path / "r/ground_truth"
    save_masks(folder, lambda mask: (mask == 255).astype(np.uint8) * value)
    line = refusal(capsys, "score-teacher", tmp_path / "r", "--out", tmp_path / "out")
    assert f"no mask holds 255, but pixels of value {value}; {remedy}" in line
    assert '"labels" in camera.json' in line
    write_folder(tmp_path / "other", n_frames=2, with_ground_truth=False)
    options = ("--ground-truth", folder, "--out", tmp_path / "out")
    assert "no mask holds 255" in refusal(capsys, "score-teacher", tmp_path / "other", *options)
    options = ("--teacher", f"masks:{folder}", "--out", tmp_path / "out")
    assert "no mask holds 255" in refusal(capsys, "learn", tmp_path / "other", *options)


def test_camera_file_is_no_remedy_where_it_is_not_read(tmp_path: Path) -> None:
    write_folder(tmp_path / "r", n_frames=1)
    (tmp_path / "r/ground_truth").rename(tmp_path / "r/rgb/ground_truth")
    save_masks(tmp_path / "r/rgb/ground_truth", lambda mask: mask // 255)
    with pytest.raises(DataError, match=r"objects are 255 and the rest 0$"):
        open_dataset(tmp_path / "r/rgb")


def test_camera_file_says_what_other_values_mean(tmp_path: Path) -> None:
    views = write_folder(tmp_path, n_frames=2)
    labels = {"support": [0], "objects_from": 1, "ignore": [255]}
    write_camera_file(tmp_path, kinect(), labels=labels)
    truth = [view.ground_truth for view in views]
    np.testing.assert_array_equal(open_dataset(tmp_path).ground_truth(0), truth[0])
    save_masks(tmp_path / "ground_truth", lambda mask: (mask == 255).astype(np.uint8))
    np.testing.assert_array_equal(open_dataset(tmp_path).ground_truth(1), truth[1])


def test_classes_with_void_are_not_taken_for_masks(tmp_path: Path) -> None:
    views = write_folder(tmp_path, n_frames=1)
    classes = np.where(views[0].ground_truth == 255, 15, 0).astype(np.uint8)
    classes[:, 0] = 255
    write_palette_png(tmp_path / "ground_truth/000000.png", classes, interlaced=False)
    with pytest.raises(DataError, match="pixels of value 15 besides 255, as numbers of classes"):
        open_dataset(tmp_path)
    labels = {"support": [0], "objects_from": 1, "ignore": [255]}
    write_camera_file(tmp_path, kinect(), labels=labels)
    expected = np.where(classes == 255, 125, views[0].ground_truth)
    np.testing.assert_array_equal(open_dataset(tmp_path).ground_truth(0), expected)


def test_other_ground_truth_replaces_masks_that_mean_nothing(tmp_path: Path) -> None:
    views = write_folder(tmp_path / "r", n_frames=1)
    write_image(tmp_path / "good/000000.png", views[0].ground_truth)
    save_masks(tmp_path / "r/ground_truth", lambda mask: mask // 255)
    dataset = open_dataset(tmp_path / "r", ground_truth=tmp_path / "good")
    np.testing.assert_array_equal(dataset.ground_truth(0), views[0].ground_truth)


@pytest.mark.parametrize("folder", ["ground_truth", "annotation"])
def test_masks_painted_in_colours_are_refused_together(folder: str, tmp_path: Path) -> None:
    (write_folder if folder == "ground_truth" else write_osd)(tmp_path, 2)
    for path in (tmp_path / folder).iterdir():
        write_image(path, np.full((120, 160, 3), (200, 0, 0), np.uint8))
    with pytest.raises(DataError, match=r"\d\.png is painted in colours.*write greys: 255 sal"):
        open_dataset(tmp_path)


def test_one_mask_painted_in_colours_is_one_bad_frame(tmp_path: Path) -> None:
    views = write_folder(tmp_path, n_frames=2)
    write_image(tmp_path / "ground_truth/000000.png", views[0].rgb)
    dataset = open_dataset(tmp_path)
    with pytest.raises(DataError, match="painted in colours"):
        dataset.ground_truth(0)
    np.testing.assert_array_equal(dataset.ground_truth(1), views[1].ground_truth)


def test_masks_of_another_size_tell_both(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "r", n_frames=2)
    save_masks(tmp_path / "r/ground_truth", lambda mask: mask[::2, ::2])
    line = refusal(capsys, "score-teacher", tmp_path / "r", "--quiet", "--out", tmp_path / "out")
    assert "2 of 2 frames cannot be scored" in line
    assert "(ground truth: is 80x60, not 160x120)" in line


def test_where_nothing_is_marked_precision_is_undefined(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "r", n_frames=2)
    save_masks(tmp_path / "r/ground_truth", lambda mask: np.zeros_like(mask))
    out = ("--out", tmp_path / "out")
    said = call(capsys, "score-teacher", tmp_path / "r", *out)
    assert "none of 2 masks looked at marks anything as salient" in said.err
    assert re.search(r"precision of salient +–", said.out)
    pixels = json.loads((tmp_path / "out/teacher.json").read_text())["pixels"]
    assert pixels["precision"] is None
    assert pixels["recall"] is None
    assert pixels["coverage"] > 0


def test_ground_truth_of_other_endings(tmp_path: Path, capsys: Capsys) -> None:
    views = write_folder(tmp_path / "r", n_frames=3)
    for index, ending in enumerate(("npy", "tif", "bmp")):
        path = tmp_path / f"r/ground_truth/{index:06d}.png"
        path.unlink()
        if ending == "npy":
            np.save(path.with_suffix(".npy"), views[index].ground_truth == 255)
        else:
            write_image(path.with_suffix(f".{ending}"), views[index].ground_truth)
    dataset = open_dataset(tmp_path / "r")
    again = open_dataset(tmp_path / "r", ground_truth=tmp_path / "r/ground_truth")
    for index, view in enumerate(views):
        expected = view.ground_truth
        if not index:
            expected = np.where(expected == 255, 255, 0)
        np.testing.assert_array_equal(dataset.ground_truth(index), expected)
        np.testing.assert_array_equal(again.ground_truth(index), expected)
    succeed(capsys, "info", tmp_path / "r")
