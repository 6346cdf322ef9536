"""Recordings of Record3D: K and poses from metadata, depth smaller than colour, what is cut."""

from __future__ import annotations

import builtins
import io
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from curiosight import check_dataset
from curiosight.datasets import Reading, open_dataset
from curiosight.errors import DataError
from recordings import truncate
from room import kinect, poses_around, render

lzfse: Any = pytest.importorskip("lzfse")

N_FRAMES = 3
WIDTH, HEIGHT = 160, 120
TO_ARKIT = np.diag([1.0, -1.0, -1.0, 1.0])
POSES = poses_around(N_FRAMES)


def depth_of(number: int) -> np.ndarray:
    """Return a quarter of the room's depth, as LiDAR is smaller than colour; 0 = none."""
    return np.nan_to_num(render(kinect(), POSES[number]).depth[1::2, 1::2]).astype("<f4")


def metadata(**changes: Any) -> dict[str, Any]:
    camera = kinect()
    poses = []
    for pose in POSES:
        turned = pose @ TO_ARKIT
        quaternion = Rotation.from_matrix(turned[:3, :3]).as_quat()
        poses.append([*quaternion.tolist(), *turned[:3, 3].tolist()])
    told = {
        "w": WIDTH,
        "h": HEIGHT,
        "dw": WIDTH // 2,
        "dh": HEIGHT // 2,
        "fps": 30,
        "K": [camera.fx, 0, 0, 0, camera.fy, 0, camera.cx, camera.cy, 1],
        "poses": poses,
        "frameTimestamps": [10 + number / 30 for number in range(N_FRAMES)],
        "initPose": [0, 0, 0, 1, 0, 0, 0],
    }
    told |= changes
    return {key: value for key, value in told.items() if value is not None}


def members(scale: int = 1, **changes: Any) -> dict[str, bytes]:
    """Return what a .r3d holds; scale: how much larger its JPEGs are than it says."""
    found = {"metadata": json.dumps(metadata(**changes)).encode()}
    for number, pose in enumerate(POSES):
        rgb = render(kinect(), pose).rgb
        large = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
        _, jpeg = cv2.imencode(".jpg", large[..., ::-1])
        confidence = np.full((HEIGHT // 2, WIDTH // 2), 2, np.uint8)
        confidence[:5] = 0
        found[f"rgbd/{number}.jpg"] = jpeg.tobytes()
        found[f"rgbd/{number}.depth"] = lzfse.compress(depth_of(number).tobytes())
        found[f"rgbd/{number}.conf"] = lzfse.compress(confidence.tobytes())
    return found


class Stream(io.BytesIO):
    """What cannot be gone back in: sizes come behind their members then."""

    def seek(self, offset: int, whence: int = 0) -> int:
        raise OSError("it flows on")


def write_r3d(
    path: Path, contents: dict[str, bytes], prefix: str = "", *, method: int = zipfile.ZIP_STORED
) -> Path:
    with zipfile.ZipFile(path, "w", method) as file:
        for name, content in contents.items():
            file.writestr(prefix + name, content)
    return path


def check_frames(path: Path, n_frames: int = N_FRAMES) -> None:
    dataset = open_dataset(path)
    assert dataset.name == "Record3D"
    assert dataset.ids == tuple(f"{number:06d}" for number in range(n_frames))
    for number, pose in enumerate(POSES[:n_frames]):
        frame = dataset[number]
        assert frame.problem is None
        assert frame.camera == kinect()
        assert frame.stamp_ns == round((10 + number / 30) * 1e9)
        np.testing.assert_allclose(frame.T_world_camera, pose, atol=1e-6)
        expected = depth_of(number)
        expected[:5] = np.nan  # not sure of it
        expected[expected == 0] = np.nan
        assert frame.depth is not None
        np.testing.assert_array_equal(frame.depth[1::2, 1::2], expected)
        assert np.abs(frame.rgb.astype(int) - render(kinect(), pose).rgb).mean() < 8


@pytest.mark.parametrize("prefix", ["", "2026-11-30--10-00-00/"])
def test_file_is_read(tmp_path: Path, prefix: str) -> None:
    path = write_r3d(tmp_path / "room.r3d", members(), prefix)
    check_frames(path)
    assert check_dataset(open_dataset(path)) is None
    again = pickle.loads(pickle.dumps(open_dataset(path)))
    assert np.array_equal(again[1].depth, open_dataset(path)[1].depth, equal_nan=True)


def test_unpacked_folder_is_read(tmp_path: Path) -> None:
    for name, content in members().items():
        (tmp_path / "room" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "room" / name).write_bytes(content)
    check_frames(tmp_path / "room")


def test_confidence_that_counts_can_be_chosen(tmp_path: Path) -> None:
    path = write_r3d(tmp_path / "room.r3d", members())
    frame = open_dataset(path, reading=Reading(min_confidence=0))[0]
    assert frame.depth is not None
    assert np.array_equal(np.nan_to_num(frame.depth[1::2, 1::2]), depth_of(0))


def test_intrinsics_are_those_of_each_frame_and_of_the_size_they_were_told_for(
    tmp_path: Path,
) -> None:
    own = [[130.0 + number, 131.0 + number, 79.0, 59.0] for number in range(N_FRAMES)]
    contents = members(2, perFrameIntrinsicCoeffs=own)
    dataset = open_dataset(write_r3d(tmp_path / "room.r3d", contents))
    for number in range(N_FRAMES):
        camera = dataset[number].camera
        assert camera is not None
        assert (camera.width, camera.height) == (2 * WIDTH, 2 * HEIGHT)
        assert (camera.fx, camera.fy) == (2 * (130.0 + number), 2 * (131.0 + number))
        assert (camera.cx, camera.cy) == (2 * 79.0 + 0.5, 2 * 59.0 + 0.5)


@pytest.mark.parametrize(
    "changes",
    [
        {"dw": None, "dh": None},
        {"dw": HEIGHT // 2, "dh": WIDTH // 2},
        {"K": [131.25, 0, 79.5, 0, 131.25, 59.5, 0, 0, 1]},
        {"frameTimestamps": [10, 10 + 1 / 30, 10 + 2 / 30], "initPose": None},
    ],
)
def test_what_apps_and_versions_write_otherwise_is_read_alike(
    tmp_path: Path, changes: dict[str, Any]
) -> None:
    check_frames(write_r3d(tmp_path / "room.r3d", members(**changes)))


def test_cut_file_is_read_to_its_last_whole_frame(tmp_path: Path) -> None:
    path = write_r3d(tmp_path / "room.r3d", members())
    with zipfile.ZipFile(path) as file:
        end = file.getinfo("rgbd/2.depth").header_offset + 100
    path.write_bytes(path.read_bytes()[:end])
    check_frames(path, 2)
    remarks = open_dataset(path).remarks
    assert "it was cut short: what is whole is read" in remarks
    assert "1 frames lack colour or depth: left out" in remarks


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_cut_file_that_was_streamed_is_read_alike(tmp_path: Path, method: int) -> None:
    stream = Stream()
    with zipfile.ZipFile(stream, "w", method) as file:
        for name, content in members().items():
            file.writestr(name, content)
        last = file.getinfo("rgbd/2.depth")
    assert last.flag_bits & 8
    end = last.header_offset + 100
    path = tmp_path / "room.r3d"
    path.write_bytes(stream.getvalue())
    check_frames(path)
    path.write_bytes(stream.getvalue()[:end])
    check_frames(path, 2)


def test_missing_unpacker_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_r3d(tmp_path / "room.r3d", members())
    usual = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name in ("lzfse", "liblzfse"):
            raise ImportError(name)
        return usual(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(DataError, match=r"needs lzfse, which is missing; pip install"):
        open_dataset(path)


def test_bad_frames_are_data(tmp_path: Path) -> None:
    contents = members()
    contents["rgbd/1.depth"] = contents["rgbd/1.depth"][:-4]
    contents["rgbd/2.jpg"] = b""
    dataset = open_dataset(write_r3d(tmp_path / "room.r3d", contents))
    assert [dataset[number].problem for number in range(3)] == [
        None,
        "1.depth is not whole: no LZFSE",
        "2.jpg is empty",
    ]


@pytest.mark.parametrize(
    ("contents", "said"),
    [
        ({"rgbd/0.jpg": b"x", "rgbd/0.depth": b"x"}, "its metadata is missing"),
        ({"metadata": b"[1]"}, "its metadata is no JSON object"),
        ({"metadata": b"{}"}, "holds 0 colour images and 0 depths, no pair"),
        ({**members(K=None)}, "metadata holds no intrinsics"),
    ],
)
def test_what_cannot_be_a_recording_is_refused(
    tmp_path: Path, contents: dict[str, bytes], said: str
) -> None:
    with pytest.raises(DataError, match=said):
        open_dataset(write_r3d(tmp_path / "room.r3d", contents))


def test_no_zip_file_is_refused(tmp_path: Path) -> None:
    path = write_r3d(tmp_path / "room.r3d", members())
    truncate(path, 0.001)
    with pytest.raises(DataError, match="is no zip file that can be read"):
        open_dataset(path)
