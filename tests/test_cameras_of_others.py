"""Files of intrinsics in the forms that others write: found, read, named; never guessed at."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from curiosight.datasets import open_dataset
from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.cameras.find_camera import find_camera
from curiosight.datasets.cameras.intrinsics import read_intrinsics
from curiosight.errors import DataError
from recordings import SIZE, write_camera_file, write_folder
from room import kinect

ROWS = "[600.0, 0, 310.5, 0, 601.0, 235.5, 0, 0, 1]"
COLUMNS = "[600.0, 0, 0, 0, 601.0, 0, 310.5, 235.5, 1]"
PIXELS = (600.0, 601.0, 310.5, 235.5)
OPENCV = """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 600., 0., 310.5, 0., 601., 235.5, 0., 0., 1. ]
"""
ROS = f"height: 480\nwidth: 640\nD: [0.1, 0, 0, 0, 0]\nK: {ROWS}\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
ORB = (
    "Camera.fx: 600.0\nCamera.fy: 601.0\nCamera.cx: 310.5\nCamera.cy: 235.5\nDepthMapFactor: 5000\n"
)
SIZED = (640, 480)

FORMS = {
    "k.json": (f'{{"cam_K": {ROWS}, "depth_scale": 0.1}}', None, 0.0001),
    "camera_intrinsic.json": (
        '{"K": [[600.0, 0, 310.5], [0, 601.0, 235.5], [0, 0, 1]]}',
        None,
        None,
    ),
    "camera.json": (f'{{"width": 640, "height": 480, "intrinsic_matrix": {COLUMNS}}}', SIZED, None),
    "camera_params.json": (
        '{"img_width": 640, "img_height": 480, "fx": 600, "fy": 601, "x_offset": 310.5, '
        '"y_offset": 235.5}',
        SIZED,
        None,
    ),
    "prime.intr": (
        '{"_cy": 235.5, "_cx": 310.5, "_fy": 601.0, "_height": 480, "_fx": 600.0, "_width": 640}',
        SIZED,
        None,
    ),
    "realsense.json": (
        '{"depth": {"fx": 380, "fy": 380, "ppx": 320, "ppy": 240, "width": 640, "height": 480}, '
        '"color": {"fx": 600, "fy": 601, "ppx": 310.5, "ppy": 235.5, "width": 640, "height": 480}, '
        '"depth_scale": 0.001}',
        SIZED,
        0.001,
    ),
    "cam_params.json": (
        '{"camera": {"w": 640, "h": 480, "fx": 600, "fy": 601, "cx": 310.5, "cy": 235.5, '
        '"scale": 6553.5}}',
        SIZED,
        1 / 6553.5,
    ),
    "camera_info.yaml": (ROS, SIZED, None),
    "calibration.yml": (OPENCV, SIZED, None),
    "camera.yaml": (ORB, None, 1 / 5000),
    "intrinsics.txt": ("600.0 0 310.5\n0 601.0 235.5\n0 0 1\n", None, None),
    "intrinsic_color.txt": ("600 0 310.5 0\n0 601 235.5 0\n0 0 1 0\n0 0 0 1\n", None, None),
    "intrinsic.txt": ("600.0 601.0 310.5 235.5\n", None, None),
    "camera_matrix.csv": ("600.0,0,310.5\n0,601.0,235.5\n0,0,1\n", None, None),
    "calib.txt": ("fx: 600\nfy: 601\ncx: 310.5\ncy: 235.5\nwidth: 640\nheight: 480\n", SIZED, None),
    "kinect.txt": ("fx,fy,cx,cy\n600,601,310.5,235.5\n", None, None),
    "cam.info.txt": (
        "# Objects: [a, b]\n\n# Color camera intrinsic matrix\n600 0 310.5\n0 601 235.5\n0 0 1\n\n"
        "# Depth camera intrinsic matrix\n475 0 314\n0 475 245\n0 0 1\n",
        None,
        None,
    ),
    "info.txt": (
        "m_colorWidth = 640\nm_colorHeight = 480\nm_depthShift = 1000\n"
        "m_calibrationColorIntrinsic = 600 0 310.5 0 0 601 235.5 0 0 0 1 0 0 0 0 1\n"
        "m_calibrationDepthIntrinsic = 583 0 320 0 0 583 240 0 0 0 1 0 0 0 0 1\n",
        SIZED,
        0.001,
    ),
    "cameras.txt": (
        "# Camera list\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        "1 PINHOLE 640 480 600 601 310.5 235.5\n",
        SIZED,
        None,
    ),
    "calib.xml": (
        '<?xml version="1.0"?>\n<opencv_storage>\n<image_width>640</image_width>\n'
        '<image_height>480</image_height>\n<camera_matrix type_id="opencv-matrix">\n<rows>3</rows>'
        "<cols>3</cols><dt>d</dt>\n<data>\n600. 0. 310.5 0. 601.\n235.5 0. 0. 1.</data>"
        "</camera_matrix>\n</opencv_storage>\n",
        SIZED,
        None,
    ),
    "x.pincam": ("640 480 600 601 310.5 235.5", SIZED, None),
}


@pytest.mark.parametrize("name", FORMS)
def test_form_is_read(name: str, tmp_path: Path) -> None:
    text, size, scale = FORMS[name]
    (tmp_path / name).write_text(text)
    found = read_intrinsics(tmp_path / name)
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == PIXELS
    assert found.size == size
    assert found.depth_scale == (None if scale is None else pytest.approx(scale))


def test_matlab_form_is_read(tmp_path: Path) -> None:
    matrix = np.array([[600.0, 0, 310.5], [0, 601.0, 235.5], [0, 0, 1]])
    savemat(tmp_path / "meta.mat", {"intrinsic_matrix": matrix, "factor_depth": 10000.0})
    found = find_camera(tmp_path)
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == PIXELS
    assert found.depth_scale == pytest.approx(0.0001)


@pytest.mark.parametrize("name", ["realsense.json", "cam.info.txt", "info.txt"])
def test_depth_camera_of_two(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(FORMS[name][0])
    found = read_intrinsics(tmp_path / name, of_depth=True)
    assert found is not None
    assert found.fx in (380, 475, 583)


@pytest.mark.parametrize(
    "text",
    [
        "0 depth/0.png 0 rgb/0.png\n1 depth/1.png 1 rgb/1.png\n",
        "1305031102.17 0.1 0.2 0.3 0 0 0 1\n1305031102.21 0.1 0.2 0.3 0 0 0 1\n",
        "1 0 0 0.5\n0 1 0 0.5\n0 0 1 0.5\n0 0 0 1\n",
        "{}",
        '{"objects": [{"id": 3, "bbox": [10, 20, 300, 200]}]}',
        '{"fx": 600}',
        '{"K": [0, 0, 0, 0, 0, 0, 0, 0, 0]}',
        "",
    ],
)
def test_what_is_no_camera_is_none(text: str, tmp_path: Path) -> None:
    (tmp_path / "camera_list.txt").write_text(text)
    assert read_intrinsics(tmp_path / "camera_list.txt") is None
    assert find_camera(tmp_path) is None


@pytest.mark.parametrize("place", [".", "..", "cameras"])
def test_file_is_found_in_the_folder_and_one_up_or_down(place: str, tmp_path: Path) -> None:
    scene = tmp_path / "room" / "scene"
    write_folder(scene)
    camera = json.loads((scene / "camera.json").read_text())
    (scene / "camera.json").unlink()
    folder = scene / place
    folder.mkdir(exist_ok=True)
    keys = ("fx", "fy", "cx", "cy")
    matrix = [[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]]
    (folder / "camera_intrinsic.json").write_text(json.dumps({"K": matrix}))
    dataset = open_dataset(scene)
    assert [getattr(dataset.camera, key) for key in keys] == [camera[key] for key in keys]
    assert any("camera_intrinsic.json: fx" in remark for remark in dataset.remarks)
    assert "no file says the unit of depth: a millimetre is taken" in dataset.remarks


def test_intrinsics_without_a_size_are_of_the_size_that_their_centre_is_amid(
    tmp_path: Path,
) -> None:
    write_folder(tmp_path)
    camera = kinect(640, 480)
    matrix = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (tmp_path / "camera.json").write_text(json.dumps({"K": matrix}))
    dataset = open_dataset(tmp_path)
    assert dataset.camera is not None
    assert dataset.camera.fx == pytest.approx(kinect(*SIZE).fx)
    assert "its intrinsics are for 640x480: scaled to 160x120" in dataset.remarks


def test_no_file_of_a_camera_is_said(tmp_path: Path) -> None:
    write_folder(tmp_path)
    (tmp_path / "camera.json").unlink()
    dataset = open_dataset(tmp_path)
    assert "no camera.json: the usual intrinsics of a Kinect are assumed" in dataset.remarks
    assert dataset.camera is not None
    assert dataset.camera.fx == pytest.approx(525 / 4)


def test_own_file_with_a_mistyped_key_is_still_refused(tmp_path: Path) -> None:
    write_folder(tmp_path)
    camera = json.loads((tmp_path / "camera.json").read_text())
    camera["depth_scal"] = camera.pop("depth_scale")
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    with pytest.raises(DataError, match='use "depth_scale"'):
        open_dataset(tmp_path)


def test_array_is_read(tmp_path: Path) -> None:
    np.save(tmp_path / "K.npy", np.array([[600.0, 0, 310.5], [0, 601.0, 235.5], [0, 0, 1]]))
    found = find_camera(tmp_path)
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == PIXELS


def test_files_in_a_folder_of_cameras_are_found(tmp_path: Path) -> None:
    (tmp_path / "camera-intrinsics").mkdir()
    (tmp_path / "camera-intrinsics/000000-0.txt").write_text(FORMS["intrinsics.txt"][0])
    found = find_camera(tmp_path)
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == PIXELS


def test_size_may_be_height_and_width(tmp_path: Path) -> None:
    size = (160, 120)
    (tmp_path / "camera.json").write_text(
        '{"K": [[150, 0, 79.5], [0, 150, 59.5], [0, 0, 1]], "resolution": [120, 160]}'
    )
    camera = find_calibration(tmp_path, size, []).camera
    assert (camera.width, camera.height, camera.fx, camera.cx) == (160, 120, 150, 79.5)


def test_intrinsics_of_images_that_were_halved_are_halved(tmp_path: Path) -> None:
    (tmp_path / "intrinsics.txt").write_text("1000 0 619.5\n0 1000 449.5\n0 0 1\n")
    camera = find_calibration(tmp_path, (620, 450), []).camera
    assert (camera.width, camera.height) == (1240, 900)


@pytest.mark.parametrize("size", [(480, 640), (1280, 720)])
def test_assumed_camera_has_square_pixels(size: tuple[int, int], tmp_path: Path) -> None:
    camera = find_calibration(tmp_path, size, []).camera
    assert camera.fx == camera.fy
    assert (camera.cx, camera.cy) == ((size[0] - 1) / 2, (size[1] - 1) / 2)
    assert camera.fx == pytest.approx(525 * np.sqrt(size[0] * size[1] / (640 * 480)))


def test_camera_file_of_windows_is_read(tmp_path: Path) -> None:
    write_camera_file(tmp_path, kinect(*SIZE))
    path = tmp_path / "camera.json"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert find_calibration(tmp_path, SIZE, []).camera == kinect(*SIZE)


def test_key_that_is_like_no_other_suggests_none(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text('{"camera_angle_x": 1.07}')
    with pytest.raises(DataError) as refused:
        find_calibration(tmp_path, SIZE, [])
    assert 'the unknown key "camera_angle_x"; Known: width' in str(refused.value)
