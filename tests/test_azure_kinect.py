"""Recordings of Azure Kinect and Femto: tracks, calibration, registration, what is cut."""

from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from curiosight import check_dataset
from curiosight.datasets import AzureKinect, open_dataset
from curiosight.datasets.cameras.azure_kinect import read_calibration
from curiosight.datasets.cameras.registration import register_depth
from curiosight.errors import DataError
from curiosight.frame import Camera
from drawn_cameras import room_views
from kinect_files import KinectTrack, calibration_of, write_kinect
from recordings import write_camera_file
from room import kinect

N_FRAMES = 3
DEPTH_CAMERA = Camera(160, 120, 120.0, 121.0, 80.0, 60.0)
STEP_NS = 33_333_000


def beside() -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = -0.032, -0.002, 0.004
    return pose


def millimetres(number: int) -> np.ndarray:
    return np.nan_to_num(room_views()[number].depth * 1000).astype(np.uint16)


def jpeg(rgb: np.ndarray) -> bytes:
    content: bytes = cv2.imencode(".jpg", rgb[..., ::-1])[1].tobytes()
    return content


def tracks(n_frames: int = N_FRAMES, four: str = "MJPG") -> list[KinectTrack]:
    colour, depth, infrared = [], [], []
    for number in range(n_frames):
        at = number * STEP_NS
        rgb = room_views()[number].rgb
        content = jpeg(rgb) if four == "MJPG" else cv2.cvtColor(rgb, cv2.COLOR_RGB2BGRA).tobytes()
        colour.append((at, content))
        depth.append((at + 2_000_000, millimetres(number).astype(">u2").tobytes()))
        infrared.append((at + 2_000_000, np.zeros((120, 160), ">u2").tobytes()))
    return [
        KinectTrack("COLOR", four, (160, 120), colour),
        KinectTrack("DEPTH", "b16g", (160, 120), depth),
        KinectTrack("IR", "b16g", (160, 120), infrared),
    ]


def calibration(**changes: Any) -> bytes:
    return calibration_of(kinect(), DEPTH_CAMERA, beside(), **changes)


def check_frames(path: Path, n_frames: int = N_FRAMES) -> None:
    dataset = open_dataset(path)
    assert dataset.name == "Azure Kinect"
    assert dataset.ids == tuple(f"{number:06d}" for number in range(n_frames))
    for number in range(n_frames):
        frame = dataset[number]
        assert frame.problem is None
        assert frame.stamp_ns == number * STEP_NS
        metres = millimetres(number) * np.float32(0.001)
        metres[metres == 0] = np.nan
        expected = register_depth(metres, DEPTH_CAMERA, kinect(), beside())
        np.testing.assert_allclose(frame.depth, expected, rtol=1e-4)
        assert np.abs(frame.rgb.astype(int) - room_views()[number].rgb).mean() < 8


@pytest.mark.parametrize("tagged", [True, False])
@pytest.mark.parametrize("is_open", [True, False])
def test_colour_and_depth_are_read_and_registered(
    tmp_path: Path, tagged: bool, is_open: bool
) -> None:
    path = tmp_path / "kinect.mkv"
    path.write_bytes(write_kinect(tracks(), calibration(), tagged=tagged, is_open=is_open))
    check_frames(path)
    assert check_dataset(open_dataset(path)) is None


def test_colour_as_the_sensor_gives_it_is_read_to_the_bit(tmp_path: Path) -> None:
    path = tmp_path / "kinect.mkv"
    path.write_bytes(write_kinect(tracks(four="BGRA"), calibration()))
    check_frames(path)
    assert np.array_equal(open_dataset(path)[1].rgb, room_views()[1].rgb)


@pytest.mark.parametrize("is_open", [True, False])
def test_cut_file_is_read_to_its_last_whole_pair(tmp_path: Path, is_open: bool) -> None:
    content = write_kinect(tracks(), calibration(), is_open=is_open)
    path = tmp_path / "kinect.mkv"
    path.write_bytes(content[: content.rfind(millimetres(2).astype(">u2").tobytes()) + 100])
    check_frames(path, 2)
    remarks = open_dataset(path).remarks
    assert "it was cut short: what is whole is read" in remarks
    assert "1 colour images have no depth at their time: left out" in remarks


def test_calibration_is_for_the_sensor_that_images_are_cut_out_of() -> None:
    colour = Camera(1280, 720, 611.0, 612.0, 638.0, 366.0)
    depth = Camera(640, 576, 504.0, 505.0, 321.0, 337.0)
    told = calibration_of(colour, depth, beside(), depth_sensor=(1024, 1024), corner=(192, 180))
    lenses = read_calibration(told, (1280, 720), (640, 576))
    assert lenses is not None
    for lens, camera in zip(lenses, (colour, depth), strict=True):
        for name in ("width", "height", "fx", "fy", "cx", "cy"):
            assert getattr(lens.camera, name) == pytest.approx(getattr(camera, name))
        assert lens.distortion is None
    assert np.allclose(lenses[0].T_camera_rig, beside())


def test_bent_lens_is_straightened(tmp_path: Path) -> None:
    bend = (0.4, -0.1, 0.02, 0.5, -0.05, 0.01, 0.001, -0.002)
    lenses = read_calibration(calibration(bend=bend), (160, 120), (160, 120))
    assert lenses is not None
    K = np.array([[120.0, 0, 80], [0, 121, 60], [0, 0, 1]])
    bent = np.array([0.4, -0.1, -0.002, 0.001, 0.02, 0.5, -0.05, 0.01])
    ray = np.array([[[0.3, -0.2, 1.0]]])
    ((u, v),) = cv2.projectPoints(ray, np.zeros(3), np.zeros(3), K, bent)[0].reshape(1, 2)
    image = np.zeros((120, 160), np.uint16)
    image[round(float(v)), round(float(u))] = 1234
    straight = lenses[1].straightened(image)
    row, column = np.argwhere(straight == 1234)[0]
    assert abs(column - (80 + 0.3 * 120)) <= 1
    assert abs(row - (60 - 0.2 * 121)) <= 1


def test_bad_blocks_are_data(tmp_path: Path) -> None:
    colour, depth, _ = tracks()
    short = [
        (at, content[:-2] if number == 1 else content)
        for number, (at, content) in enumerate(depth.blocks)
    ]
    path = tmp_path / "kinect.mkv"
    path.write_bytes(
        write_kinect([colour, KinectTrack("DEPTH", "b16g", (160, 120), short)], calibration())
    )
    dataset = open_dataset(path)
    assert dataset[0].problem is None
    assert dataset[1].problem == "depth 000001 has 38398 bytes, no image of its track"


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    path = tmp_path / "kinect.mkv"
    path.write_bytes(write_kinect(tracks(), None))
    with pytest.raises(DataError, match="holds no calibration of an Azure Kinect"):
        open_dataset(path)
    write_camera_file(tmp_path, kinect())
    assert "camera of camera.json" in open_dataset(path).remarks
    path.write_bytes(write_kinect(tracks()[1:2], calibration()))
    with pytest.raises(DataError, match="has no track of color"):
        open_dataset(path)
    (tmp_path / "camera.json").unlink()
    with pytest.raises(DataError, match=r"give one of them, kinect\.mkv say"):
        open_dataset(tmp_path)


def test_infrared_is_no_depth(tmp_path: Path) -> None:
    colour, _, infrared = tracks()
    path = tmp_path / "kinect.mkv"
    path.write_bytes(write_kinect([colour, infrared], calibration()))
    assert not AzureKinect.recognises(path)


def test_depth_that_needs_a_decoder_is_decoded_to_the_bit(tmp_path: Path) -> None:
    av: Any = pytest.importorskip("av")
    path = tmp_path / "kinect.mkv"
    with av.open(str(path), "w") as container:
        colour = container.add_stream("ffv1", rate=30)
        colour.width, colour.height, colour.pix_fmt = 160, 120, "bgr0"
        colour.metadata["title"] = "COLOR"
        depth = container.add_stream("ffv1", rate=30)
        depth.width, depth.height, depth.pix_fmt = 160, 120, "gray16le"
        depth.metadata["title"] = "DEPTH"
        container.add_attachment("calibration.json", "application/json", calibration())
        for number in range(4):
            for stream, pixels, form in (
                (colour, room_views()[number].rgb, "rgb24"),
                (depth, millimetres(number), "gray16le"),
            ):
                frame = av.VideoFrame.from_ndarray(pixels, format=form)
                frame.pts = number
                container.mux(stream.encode(frame))
        for stream in (colour, depth):
            container.mux(stream.encode(None))
    dataset = open_dataset(path)
    assert dataset.name == "Azure Kinect"
    for number in (2, 0, 3, 1):
        frame = dataset[number]
        assert frame.problem is None
        assert np.array_equal(frame.rgb, room_views()[number].rgb)
        metres = millimetres(number) * np.float32(0.001)
        metres[metres == 0] = np.nan
        expected = register_depth(metres, DEPTH_CAMERA, kinect(), beside())
        np.testing.assert_allclose(frame.depth, expected, rtol=1e-4)


def test_missing_decoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "av":
            raise ImportError(name)
        return usual(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    path = tmp_path / "kinect.mkv"
    path.write_bytes(write_kinect(tracks(four="H264"), calibration()))
    with pytest.raises(
        DataError, match=r"needs PyAV, which is missing; pip install 'curiosight\[video\]'"
    ):
        open_dataset(path)
