"""LeRobot data sets with depth: codes of 12 bits, videos one after the other, what is missing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight import check_dataset
from curiosight.datasets import open_dataset
from curiosight.datasets.layouts.lerobot import Quantiser
from curiosight.errors import DataError
from drawn_cameras import room_views
from recordings import write_camera_file
from room import kinect

av: Any = pytest.importorskip("av")

TOP, TOP_DEPTH = "observation.images.top", "observation.images.top_depth"
RANGE = {"depth_min": 0.2, "depth_max": 8.0, "shift": 1.5, "use_log": True}


def codes_of(number: int) -> np.ndarray:
    """Quantise as LeRobot does, in millimetres; no reading is 0."""
    millimetres = np.nan_to_num(room_views()[number].depth * 1000).round()
    low, high = np.log(200 + 1500), np.log(8000 + 1500)
    share = (np.log(millimetres + 1500) - low) / (high - low)
    return np.rint(share * 4095).clip(0, 4095).astype(np.uint16)


def write_video(path: Path, images: list[np.ndarray], codec: str, pixels: str) -> None:
    """Write a video; FFV1 stands in for lossless HEVC, which cannot always be written to MP4."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w", format="matroska") as container:
        stream = container.add_stream(codec, rate=10)
        stream.height, stream.width = images[0].shape[:2]
        stream.pix_fmt = pixels
        for number, image in enumerate(images):
            form = "rgb24" if image.ndim == 3 else pixels
            frame = av.VideoFrame.from_ndarray(image, format=form)
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def write_lerobot(root: Path, **changes: Any) -> Path:
    """Write four frames in two files a camera, whose files are cut at other frames."""
    told = {"is_depth_map": True, **{f"video.{name}": value for name, value in RANGE.items()}}
    features = {
        "action": {"dtype": "float32", "shape": [6]},
        "observation.images.wrist": {"dtype": "video", "shape": [120, 160, 3], "info": {}},
        TOP: {"dtype": "video", "shape": [120, 160, 3], "info": {"video.fps": 10}},
        TOP_DEPTH: {"dtype": "video", "shape": [120, 160, 1], "info": told | changes},
    }
    info = {"codebase_version": "v3.0", "fps": 10, "total_frames": 4, "features": features}
    (root / "meta").mkdir(parents=True)
    (root / "meta/info.json").write_text(json.dumps(info))
    colour = [view.rgb for view in room_views()]
    depth = [codes_of(number) for number in range(len(colour))]
    for key, images, cut, codec, pixels in (
        (TOP, colour, 1, "mpeg4", "yuv420p"),
        (TOP_DEPTH, depth, 2, "ffv1", "gray12le"),
    ):
        for number, part in enumerate((images[:cut], images[cut:])):
            write_video(root / f"videos/{key}/chunk-000/file-{number:03d}.mp4", part, codec, pixels)
    return root


def test_codes_become_metres() -> None:
    quantiser = Quantiser(**RANGE)
    for number in range(4):
        depth = room_views()[number].depth
        metres = quantiser.to_metres(codes_of(number))
        seen = np.isfinite(depth) & (depth < 8)
        assert np.array_equal(np.isfinite(metres), seen)
        # A code is log((8 + 1.5) / (0.2 + 1.5)) / 4095 of the distance and the shift.
        np.testing.assert_allclose(metres[seen], depth[seen], atol=9.5 * 4.3e-4)
    linear = Quantiser(1.0, 5.095, 0.0, use_log=False)
    assert linear.to_metres(np.array([[1, 1000]], np.uint16)) == pytest.approx(
        np.array([[1.001, 2.0]])
    )


def test_colour_and_depth_of_one_number_belong_together(tmp_path: Path) -> None:
    dataset = open_dataset(write_lerobot(tmp_path / "set"))
    assert dataset.name == "LeRobot"
    assert dataset.ids == ("000000", "000001", "000002", "000003")
    assert f"colour {TOP}, depth {TOP_DEPTH}" in dataset.remarks
    assert any("LeRobot stores no intrinsics" in remark for remark in dataset.remarks)
    for number in (2, 0, 3, 1):
        frame = dataset[number]
        assert frame.problem is None
        assert frame.stamp_ns == number * 100_000_000
        assert np.array_equal(
            frame.depth, Quantiser(**RANGE).to_metres(codes_of(number)), equal_nan=True
        )
        assert np.abs(frame.rgb.astype(int) - room_views()[number].rgb).mean() < 8
    assert check_dataset(dataset) is None


def test_camera_file_beside_it_counts(tmp_path: Path) -> None:
    root = write_lerobot(tmp_path / "set")
    write_camera_file(root, kinect())
    assert open_dataset(root).camera == kinect()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"is_depth_map": False}, "without a video of depth"),
        ({"video.depth_max": 0.1}, "tells no range of depth"),
        ({"video.depth_max": "far"}, "tells no range of depth"),
    ],
)
def test_what_cannot_be_read_is_refused(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(DataError, match=said):
        open_dataset(write_lerobot(tmp_path / "set", **changes))


def test_videos_that_are_missing_are_named(tmp_path: Path) -> None:
    root = write_lerobot(tmp_path / "set")
    (root / f"videos/{TOP_DEPTH}/chunk-000/file-001.mp4").write_bytes(b"cut")
    with pytest.raises(DataError, match=r"file-001\.mp4: cannot be read as a video"):
        open_dataset(root)
    for file in (root / f"videos/{TOP_DEPTH}/chunk-000").iterdir():
        file.unlink()
    with pytest.raises(DataError, match=f"has no videos of {TOP_DEPTH}"):
        open_dataset(root)
