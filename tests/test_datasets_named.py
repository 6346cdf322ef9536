"""Recordings whose names alone tell colour from depth: paired, measured, with their cameras."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from curiosight.datasets import Recording, check_dataset, open_dataset
from curiosight.datasets.pairs import match_names
from curiosight.errors import DataError
from recordings import SIZE, pose_line, write_image
from room import View, kinect, poses_around, render

N_FRAMES = 4
VIEWS = [render(kinect(*SIZE), pose) for pose in poses_around(N_FRAMES)]
CAMERA = kinect(*SIZE)
MATRIX = [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]]


def units(view: View, scale: float = 0.001) -> np.ndarray:
    whole = np.nan_to_num(np.round(view.depth / scale))
    return np.where(whole < 65535, whole, 0).astype(np.uint16)


def mask(view: View) -> np.ndarray:
    return np.where(view.ground_truth == 255, 255, 0).astype(np.uint8)


def write_camera(path: Path, **more: object) -> None:
    path.write_text(json.dumps({"K": MATRIX, "width": SIZE[0], "height": SIZE[1], **more}))


def two_folders_without_a_camera(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"rgb/{n}.png", view.rgb)
        write_image(root / f"depth/{n}.png", units(view))


def color_and_depth_by_dash(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"{n:06d}-color.png", view.rgb)
        write_image(root / f"{n:06d}-depth.png", units(view))
        write_image(root / f"{n:06d}-label.png", mask(view))
    (root / "camera_params.json").write_text(
        json.dumps(
            {
                "img_width": SIZE[0],
                "img_height": SIZE[1],
                "fx": CAMERA.fx,
                "fy": CAMERA.fy,
                "x_offset": CAMERA.cx,
                "y_offset": CAMERA.cy,
            }
        )
    )


def arrays_and_masks(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"scene/color_{n}.png", view.rgb)
        np.save(root / f"scene/depth_{n}.npy", view.depth[..., None])
        write_image(root / f"scene/segmask_{n}.png", mask(view))
    keys = {"_fx": CAMERA.fx, "_fy": CAMERA.fy, "_cx": CAMERA.cx, "_cy": CAMERA.cy}
    size = {"_width": SIZE[0], "_height": SIZE[1]}
    (root / "primesense.intr").write_text(json.dumps({**keys, **size}))


def one_frame_a_folder(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"{n:04d}/rgb.png", view.rgb)
        write_image(root / f"{n:04d}/depth.png", units(view))
        numbers = [number for row in MATRIX for number in row]
        camera = {"cam_K": numbers, "depth_scale": 1.0}
        (root / f"{n:04d}/camera.json").write_text(json.dumps(camera))


def camera_intrinsic_with_k(root: Path) -> None:
    two_folders_without_a_camera(root)
    (root / "camera_intrinsic.json").write_text(json.dumps({"K": MATRIX}))


def dots_in_tenths_of_millimetres(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"{n:06d}.color.png", view.rgb)
        write_image(root / f"{n:06d}.depth.png", units(view, 0.0001))
    rows = "\n".join(" ".join(map(str, row)) for row in MATRIX)
    (root / "camera-intrinsics.txt").write_text(f"{rows}\ndepth_scale: 10000\n")


def pgm_and_a_trajectory(root: Path) -> None:
    lines = []
    for n, (view, pose) in enumerate(zip(VIEWS, poses_around(N_FRAMES), strict=True)):
        write_image(root / f"color/{n}.png", view.rgb)
        write_image(root / f"depth/{n}.pgm", units(view))
        lines.append(pose_line(float(n), pose))
    (root / "pose.txt").write_text("\n".join(lines))
    write_camera(root / "camera.json")


def unsaid_colour(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"{n}.png", view.rgb)
        write_image(root / f"{n}_depth.png", units(view, 1 / 5000))
    write_camera(root / "kinect_params.json", depth_factor=5000)


def arrays_among_results(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"image_{n}.jpg", view.rgb)
        np.savez(root / f"image_{n}_depth.npz", depth=view.depth * 1000)
        write_image(root / f"image_{n}_result.png", view.rgb[::-1].copy())
        write_image(root / f"image_{n}_depth_vis.png", view.rgb)
        write_image(root / f"image_{n}_mask.png", mask(view))
    write_camera(root / "camera.json")


def floats_in_tiff(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"left/{n}.png", view.rgb)
        write_image(root / f"image/frame{n:03d}.png", view.rgb)
        path = root / f"depth_map/depth{n:03d}.tiff"
        path.parent.mkdir(parents=True, exist_ok=True)
        assert cv2.imwrite(str(path), np.nan_to_num(view.depth))
    write_camera(root / "camera.json")


def three_equal_channels(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"rgb_{n}.png", view.rgb)
        write_image(root / f"depth_{n}.png", np.dstack([units(view)] * 3))
    write_camera(root / "camera.json")


def times_in_names(root: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(root / f"rgb/{1305031100 + n}.250000.png", view.rgb)
        write_image(root / f"depth/{1305031100 + n}.261000.png", units(view))
    write_camera(root / "camera.json")


Writer = Callable[[Path], None]
KINDS: list[tuple[Writer, str, str]] = [
    (two_folders_without_a_camera, "plain folder", "0"),
    (color_and_depth_by_dash, "colour and depth by name", "000000"),
    (arrays_and_masks, "Dex-Net", "0"),
    (one_frame_a_folder, "colour and depth by name", "0000/rgb"),
    (camera_intrinsic_with_k, "plain folder", "0"),
    (dots_in_tenths_of_millimetres, "3DMatch / MIT-Princeton", "000000"),
    (pgm_and_a_trajectory, "colour and depth by name", "0"),
    (unsaid_colour, "colour and depth by name", "0"),
    (arrays_among_results, "colour and depth by name", "0"),
    (floats_in_tiff, "colour and depth by name", "frame000"),
    (three_equal_channels, "colour and depth by name", "0"),
    (times_in_names, "plain folder", "1305031100.250000"),
]


@pytest.mark.parametrize(("write", "layout", "first"), KINDS, ids=[k[0].__name__ for k in KINDS])
def test_kind_is_opened_right(write: Writer, layout: str, first: str, tmp_path: Path) -> None:
    write(tmp_path)
    dataset = open_dataset(tmp_path)
    assert isinstance(dataset, Recording)
    assert (dataset.name, dataset.ids[0], len(dataset)) == (layout, first, N_FRAMES)
    check_dataset(dataset)
    assert dataset.camera is not None
    assert dataset.camera.fx == pytest.approx(CAMERA.fx)
    for index, view in enumerate(VIEWS):
        frame = dataset[index]
        assert frame.problem is None
        assert frame.depth is not None
        known = np.isfinite(frame.depth)
        assert known.sum() > 0.97 * np.isfinite(view.depth).sum()
        np.testing.assert_allclose(frame.depth[known], view.depth[known], atol=0.0006)
        assert np.abs(frame.rgb.astype(int) - view.rgb).mean() < 6  # JPEG smears


def test_masks_of_dex_net_are_ground_truth(tmp_path: Path) -> None:
    arrays_and_masks(tmp_path)
    for folder in (tmp_path, tmp_path / "scene"):
        truth = open_dataset(folder).ground_truth(1)
        np.testing.assert_array_equal(truth, mask(VIEWS[1]))


def test_trajectory_beside_is_read(tmp_path: Path) -> None:
    pgm_and_a_trajectory(tmp_path)
    np.testing.assert_allclose(open_dataset(tmp_path).poses, poses_around(N_FRAMES), atol=1e-8)


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    arrays_among_results(tmp_path)
    remarks = " ".join(open_dataset(tmp_path).remarks)
    for name in ("image_N_result.png", "image_N_depth_vis.png", "image_N_mask.png"):
        assert name in remarks


def test_unit_that_no_file_says_is_said(tmp_path: Path) -> None:
    two_folders_without_a_camera(tmp_path)
    assert "no file says the unit of depth: a millimetre is taken" in open_dataset(tmp_path).remarks


@pytest.mark.parametrize(
    ("colours", "depths", "n_pairs", "how"),
    [
        (["a1.png", "a2.png"], ["a1.png", "a2.png"], 2, "their names"),
        (["color_1.png", "color_2.png"], ["depth_1.png", "depth_2.png"], 2, "their names"),
        (["f_001.jpg", "f_002.jpg"], ["d_1.png", "d_2.png"], 2, "the numbers in their names"),
        (["a.png", "b.png"], ["x.png", "y.png"], 2, "their order, for their names differ"),
        (["a.png", "b.png", "c.png"], ["x.png", "y.png"], 0, ""),
    ],
)
def test_names_are_matched(colours: list[str], depths: list[str], n_pairs: int, how: str) -> None:
    rgb, depth = [Path("c") / name for name in colours], [Path("d") / name for name in depths]
    pairs, by = match_names(rgb, depth)
    assert (len(pairs), by) == (n_pairs, how)


def test_pictures_of_depth_are_no_depth(tmp_path: Path) -> None:
    for n, view in enumerate(VIEWS):
        write_image(tmp_path / f"color_{n}.png", view.rgb)
        write_image(tmp_path / f"depth_{n}.png", view.rgb)
    dataset = open_dataset(tmp_path)
    assert dataset.name == "folder of images"
    assert len(dataset) == N_FRAMES
    assert "left out, for their names: depth_0.png (depth)" in dataset.remarks


def test_files_that_are_called_by_words_are_frames(tmp_path: Path) -> None:
    for name, view in zip(("test-image", "test-background", "mug"), VIEWS, strict=False):
        write_image(tmp_path / f"{name}.color.png", view.rgb)
        write_image(tmp_path / f"{name}.depth.png", units(view))
    write_camera(tmp_path / "test-camera.json")
    dataset = open_dataset(tmp_path)
    assert len(dataset) == 3
    assert all(dataset[index].problem is None for index in range(3))
    assert np.array_equal(dataset[0].rgb, VIEWS[2].rgb)


def test_folders_may_have_cameras_of_their_own(tmp_path: Path) -> None:
    for folder, focal in (("cam1", 150.0), ("cam2", 120.0)):
        write_image(tmp_path / folder / "color/0.png", VIEWS[0].rgb)
        write_image(tmp_path / folder / "depth/0.png", units(VIEWS[0]))
        matrix = [[focal, 0, CAMERA.cx], [0, focal, CAMERA.cy], [0, 0, 1]]
        write_camera(tmp_path / folder / "intrinsics.json", K=matrix)
    dataset = open_dataset(tmp_path)
    cameras = [dataset[index].camera for index in range(2)]
    assert [camera and camera.fx for camera in cameras] == [150.0, 120.0]


def test_folders_of_different_units_are_refused(tmp_path: Path) -> None:
    for folder, scale in (("cam1", 1000.0), ("cam2", 5000.0)):
        write_image(tmp_path / folder / "color/0.png", VIEWS[0].rgb)
        write_image(tmp_path / folder / "depth/0.png", units(VIEWS[0], 1 / scale))
        write_camera(tmp_path / folder / "intrinsics.json", depth_scale=scale)
    with pytest.raises(DataError, match="different units of depth"):
        open_dataset(tmp_path)


def test_folder_of_depth_alone_is_no_colour(tmp_path: Path) -> None:
    write_image(tmp_path / "0.png", units(VIEWS[0]))
    with pytest.raises(DataError, match="depth, not colour"):
        open_dataset(tmp_path)
