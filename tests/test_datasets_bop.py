"""Scenes of BOP, written small in the layout of the benchmark."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.datasets import Bop, KnowsInstances, check_dataset, open_dataset
from curiosight.errors import DataError
from recordings import truncate, write_depth, write_image
from room import View, kinect, poses_around, render

DEPTH_SCALE = 0.1  # millimetres per unit, as in most of BOP's data sets


def write_bop(
    scene: Path, n_frames: int = 3, *, with_poses: bool = True, colour: str = "rgb/{}.png"
) -> list[View]:
    """Write a scene whose masks are of the boxes on the floor; image 1 has none."""
    camera = kinect()
    cameras: dict[str, dict[str, Any]] = {}
    views = []
    for number, pose in enumerate(poses_around(n_frames)):
        view = render(camera, pose)
        stem = f"{number:06d}"
        write_image(scene / colour.format(stem), view.rgb)
        near = np.where(view.depth < 6.5, view.depth, np.nan).astype(np.float32)
        write_depth(scene / f"depth/{stem}.png", near, DEPTH_SCALE / 1000)
        K = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
        cameras[str(number)] = {"cam_K": K, "depth_scale": DEPTH_SCALE}
        if with_poses:
            T_camera_world = np.linalg.inv(pose)
            cameras[str(number)]["cam_R_w2c"] = T_camera_world[:3, :3].ravel().tolist()
            cameras[str(number)]["cam_t_w2c"] = (1000 * T_camera_world[:3, 3]).tolist()
        for place in range(3) if number != 1 else ():
            mask = 255 * (view.surface == place + 1).astype(np.uint8)
            write_image(scene / f"mask_visib/{stem}_{place:06d}.png", mask)
        views.append(view)
    (scene / "scene_camera.json").write_text(json.dumps(cameras))
    return views


def change(scene: Path, image: str, **values: Any) -> None:
    """Change what scene_camera.json says of an image; None leaves a value out."""
    content = json.loads((scene / "scene_camera.json").read_text())
    changed = {**content[image], **values}
    content[image] = {key: value for key, value in changed.items() if value is not None}
    (scene / "scene_camera.json").write_text(json.dumps(content))


def bop(path: Path) -> Bop:
    dataset = open_dataset(path)
    assert isinstance(dataset, Bop)
    return dataset


def test_scene_is_guessed_and_read(tmp_path: Path) -> None:
    views = write_bop(tmp_path)
    dataset = bop(tmp_path)
    assert dataset.name == "BOP"
    assert dataset.ids == ("000000", "000001", "000002")
    assert dataset.camera == kinect()
    frame = dataset[2]
    assert frame.problem is None
    np.testing.assert_array_equal(frame.rgb, views[2].rgb)
    assert frame.depth is not None
    seen = np.isfinite(frame.depth)
    assert seen.mean() > 0.5
    np.testing.assert_allclose(frame.depth[seen], views[2].depth[seen], atol=1e-4)
    check_dataset(dataset)


def test_poses_are_inverted_and_in_metres(tmp_path: Path) -> None:
    write_bop(tmp_path)
    for pose, expected in zip(bop(tmp_path).poses, poses_around(3), strict=True):
        np.testing.assert_allclose(pose, expected, atol=1e-9)
    write_bop(tmp_path, with_poses=False)
    assert bop(tmp_path).poses == (None, None, None)
    assert bop(tmp_path)[0].problem is None


def test_outside_all_masks_is_ignored(tmp_path: Path) -> None:
    views = write_bop(tmp_path)
    dataset = bop(tmp_path)
    assert [dataset.has_ground_truth(index) for index in range(3)] == [True, False, True]
    assert dataset.remarks == (
        "outside the masks all is ignored: recall can be measured, precision cannot",
    )
    expected = np.where(views[2].ground_truth == 255, 255, 125)
    np.testing.assert_array_equal(dataset.ground_truth(2), expected)
    assert dataset.ground_truth(1) is None


def test_instances_are_numbered_by_their_masks(tmp_path: Path) -> None:
    views = write_bop(tmp_path)
    dataset = open_dataset(tmp_path)
    assert isinstance(dataset, KnowsInstances)
    boxes = np.where(np.isin(views[0].surface, (1, 2, 3)), views[0].surface, -1)
    instances = dataset.instance_truth(0)
    assert instances is not None
    assert instances.dtype == np.int32
    np.testing.assert_array_equal(instances, boxes)
    assert dataset.instance_truth(1) is None


def test_masks_of_ones_own_replace_the_visible_ones(tmp_path: Path) -> None:
    views = write_bop(tmp_path / "scene")
    write_image(tmp_path / "scene/ground_truth/000001.png", views[1].ground_truth)
    dataset = bop(tmp_path / "scene")
    np.testing.assert_array_equal(dataset.ground_truth(1), views[1].ground_truth)
    assert dataset.instance_truth(0) is not None
    given = open_dataset(tmp_path / "scene", ground_truth=tmp_path / "scene/ground_truth")
    assert isinstance(given, Bop)
    assert [given.has_ground_truth(index) for index in range(3)] == [False, True, False]
    assert given.instance_truth(0) is None


@pytest.mark.parametrize("colour", ["rgb/{}.jpg", "gray/{}.png"])
def test_colour_may_be_jpeg_or_grey(colour: str, tmp_path: Path) -> None:
    views = write_bop(tmp_path, colour=colour)
    if colour.startswith("gray"):
        for path in (tmp_path / "gray").iterdir():
            write_image(path, views[0].rgb[..., 0])
    dataset = bop(tmp_path)
    assert dataset[0].problem is None
    check_dataset(dataset)


def test_scenes_share_no_world(tmp_path: Path) -> None:
    write_bop(tmp_path / "test/000002", 1)
    write_bop(tmp_path / "test/000048", 2)
    dataset = bop(tmp_path / "test")
    assert dataset.ids == ("000002/000000", "000048/000000", "000048/000001")
    assert dataset.poses == (None, None, None)
    assert "each scene has a world of its own: open a single one to have poses" in dataset.remarks
    assert dataset.ground_truth(1) is not None
    check_dataset(dataset)
    with pytest.raises(DataError, match=f"did you mean {tmp_path / 'test'}"):
        open_dataset(tmp_path)


def test_unit_of_depth_may_change_from_image_to_image(tmp_path: Path) -> None:
    views = write_bop(tmp_path)
    write_depth(tmp_path / "depth/000001.png", views[1].depth, 0.001)
    change(tmp_path, "1", depth_scale=1.0)
    depth = bop(tmp_path)[1].depth
    np.testing.assert_allclose(depth, views[1].depth, atol=0.0006)


def test_scene_without_depth_is_for_maps_only(tmp_path: Path) -> None:
    write_bop(tmp_path)
    for path in (tmp_path / "depth").iterdir():
        path.unlink()
    (tmp_path / "depth").rmdir()
    dataset = bop(tmp_path)
    assert not dataset.has_depth
    assert dataset.has_ground_truth(0)
    check_dataset(dataset)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"depth_scale": None}, "scene_camera.json gives no depth_scale for it"),
        ({"cam_R_w2c": [2, 0, 0, 0, 1, 0, 0, 0, 1]}, "are not a rigid pose"),
        ({"cam_K": [131.0, 0, 95.0, 0, 131.0, 59.5, 0, 0, 1]}, "is not that of most images"),
    ],
    ids=["no unit", "no pose", "other camera"],
)
def test_bad_image_is_told(values: dict[str, Any], words: str, tmp_path: Path) -> None:
    write_bop(tmp_path)
    change(tmp_path, "1", **values)
    dataset = bop(tmp_path)
    assert words in (dataset[1].problem or "")
    assert dataset[0].problem is None
    check_dataset(dataset)


def test_missing_depth_and_missing_line_cost_one_frame_each(tmp_path: Path) -> None:
    write_bop(tmp_path)
    (tmp_path / "depth/000000.png").unlink()
    content = json.loads((tmp_path / "scene_camera.json").read_text())
    del content["2"]
    (tmp_path / "scene_camera.json").write_text(json.dumps(content))
    dataset = bop(tmp_path)
    assert dataset[0].problem == "000000.png is missing"
    assert "scene_camera.json says nothing of it" in (dataset[2].problem or "")
    assert dataset[1].problem is None


def test_damaged_mask_is_an_error_of_its_file(tmp_path: Path) -> None:
    write_bop(tmp_path)
    truncate(tmp_path / "mask_visib/000000_000001.png")
    with pytest.raises(DataError, match=r"000000_000001\.png: .* is truncated"):
        bop(tmp_path).ground_truth(0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"cam_K": None}, 'image "0" has no cam_K'),
        ({"cam_K": [1, 2, 3]}, 'cam_K of image "0" is malformed; expected 9 numbers'),
        ({"cam_K": [0.0] * 9}, 'cam_K of image "0" is no camera'),
        ({"depth_scale": 0}, 'depth_scale of image "0" is 0'),
        ({"depth_scale": "mm"}, 'depth_scale of image "0" is malformed; expected a number'),
        ({"cam_t_w2c": [1, 2, float("nan")]}, 'cam_t_w2c of image "0" is malformed'),
        ({"cam_R_w2c": [[1], [2, 3]]}, 'cam_R_w2c of image "0" is malformed'),
    ],
)
def test_malformed_scene_camera(values: dict[str, Any], words: str, tmp_path: Path) -> None:
    write_bop(tmp_path)
    change(tmp_path, "0", **values)
    with pytest.raises(DataError) as caught:
        open_dataset(tmp_path)
    assert caught.value.path == tmp_path / "scene_camera.json"
    assert words in str(caught.value)


@pytest.mark.parametrize("text", ["", "[1]", '{"one": {}}', '{"0": 1}', '{"-1": {}}', "{}"])
def test_unusable_scene_camera(text: str, tmp_path: Path) -> None:
    write_bop(tmp_path)
    (tmp_path / "scene_camera.json").write_text(text)
    with pytest.raises(DataError, match=r"scene_camera\.json"):
        open_dataset(tmp_path)


def test_camera_that_moves_in_the_image_is_refused(tmp_path: Path) -> None:
    write_bop(tmp_path, 5)
    for image in range(5):
        K = [131.25, 0, 79.5 + 4 * image, 0, 131.25, 59.5, 0, 0, 1]
        change(tmp_path, str(image), cam_K=K)
    with pytest.raises(DataError, match="cam_K differs from image to image"):
        open_dataset(tmp_path)


def test_tiff_and_arrays(tmp_path: Path) -> None:
    """ITODD has grey and depth as TIFF; some write depth as arrays."""
    views = write_bop(tmp_path, colour="gray/{}.tif")
    for stem in ("000000", "000001"):
        (tmp_path / f"depth/{stem}.png").rename(tmp_path / f"depth/{stem}.old")
    write_depth(tmp_path / "depth/000000.tif", views[0].depth, DEPTH_SCALE / 1000)
    units = np.nan_to_num(views[1].depth / (DEPTH_SCALE / 1000)).astype(np.uint32)
    np.save(tmp_path / "depth/000001.npy", units)
    dataset = bop(tmp_path)
    assert dataset.ids == ("000000", "000001", "000002")
    for index in range(3):
        frame = dataset[index]
        assert frame.problem is None
        assert frame.depth is not None
        np.testing.assert_array_equal(frame.rgb, views[index].rgb)
        seen = np.isfinite(frame.depth) & (views[index].depth < 6.5)
        assert seen.mean() > 0.5
        np.testing.assert_allclose(frame.depth[seen], views[index].depth[seen], atol=2e-4)


def test_camera_of_the_data_set_is_not_the_scenes(tmp_path: Path) -> None:
    """T-LESS and YCB-V have files of several cameras beside their scenes."""
    write_bop(tmp_path / "test/000001")
    other = {"cx": 9, "cy": 9, "depth_scale": 1.0, "fx": 99, "fy": 99, "height": 9, "width": 9}
    for folder in (tmp_path, tmp_path / "test"):
        (folder / "camera.json").write_text(json.dumps(other))
        (folder / "camera_uw.json").write_text(json.dumps(other))
    for path in (tmp_path / "test", tmp_path / "test/000001"):
        assert bop(path).camera == kinect()
