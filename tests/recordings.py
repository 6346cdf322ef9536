"""Write tiny recordings of the room in every layout, for tests that read them back."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.layouts import seven_scenes
from curiosight.frame import Camera, Pose
from room import View, kinect, look, poses_around, render
from room_world import SMALL_ROOM

SIZE = (160, 120)
FIRST_STAMP = 1305031229.5


def write_image(path: Path, image: npt.NDArray[Any]) -> None:
    """Write a colour (red first), grey or depth image, with its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    assert cv2.imwrite(str(path), image)


def write_depth(path: Path, depth: npt.NDArray[np.float32], depth_scale: float = 0.001) -> None:
    """Write metres as 16-bit units, no reading as 0."""
    write_image(path, np.nan_to_num(np.round(depth / depth_scale)).astype(np.uint16))


def write_camera_file(folder: Path, camera: Camera, **changes: Any) -> None:
    """Write camera.json; `changes` add keys or, as None, leave keys out."""
    content: dict[str, Any] = {
        key: getattr(camera, key) for key in ("width", "height", "fx", "fy", "cx", "cy")
    }
    content = {**content, "depth_scale": 0.001, **changes}
    content = {key: value for key, value in content.items() if value is not None}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "camera.json").write_text(json.dumps(content))


def write_seven_scenes(
    root: Path,
    n_frames: int = 3,
    *,
    sequence: str = "seq-01",
    ending: str = "png",
    size: tuple[int, int] = SIZE,
) -> list[View]:
    """Write a 7-Scenes sequence whose depth needs registering; ground truth for even frames.

    Returns what the colour camera sees.
    """
    colour_camera = scaled_camera(seven_scenes.COLOUR_CAMERA, size)
    depth_camera = scaled_camera(seven_scenes.DEPTH_CAMERA, size)
    T_colour_depth = np.eye(4)
    T_colour_depth[:3, 3] = seven_scenes.COLOUR_FROM_DEPTH_METRES
    views = []
    for index, T_world_camera in enumerate(poses_around(n_frames)):
        T_world_depth = T_world_camera @ T_colour_depth
        view = render(colour_camera, T_world_camera)
        stem = f"frame-{index:06d}"
        write_image(root / sequence / f"{stem}.color.{ending}", view.rgb)
        seen = render(depth_camera, T_world_depth).depth
        write_depth(root / sequence / f"{stem}.depth.png", seen)
        np.savetxt(root / sequence / f"{stem}.pose.txt", T_world_depth)
        if index % 2 == 0:
            write_image(root / "ground_truth" / f"{stem}.png", view.ground_truth)
        views.append(view)
    return views


def write_tum(
    root: Path, n_frames: int = 3, *, size: tuple[int, int] = SIZE, with_poses: bool = True
) -> list[View]:
    """Write a TUM RGB-D sequence at 5 Hz, depth 4 ms after colour, poses at 100 Hz."""
    camera = kinect(*size)
    poses = poses_around(n_frames)
    lists: dict[str, list[str]] = {"rgb": [], "depth": [], "groundtruth": []}
    views = []
    for index, pose in enumerate(poses):
        stamp = FIRST_STAMP + 0.2 * index
        view = render(camera, pose)
        write_image(root / f"rgb/{stamp:.6f}.png", view.rgb)
        write_depth(root / f"depth/{stamp + 0.004:.6f}.png", view.depth, 1 / 5000)
        lists["rgb"].append(f"{stamp:.6f} rgb/{stamp:.6f}.png")
        lists["depth"].append(f"{stamp + 0.004:.6f} depth/{stamp + 0.004:.6f}.png")
        for offset in (-0.005, 0.005):
            lists["groundtruth"].append(pose_line(stamp + offset, pose))
        views.append(view)
    if not with_poses:
        del lists["groundtruth"]
    for name, lines in lists.items():
        (root / f"{name}.txt").write_text("\n".join(["# a comment", *lines]) + "\n")
    return views


def write_osd(
    root: Path, n_frames: int = 3, *, size: tuple[int, int] = SIZE, with_camera: bool = True
) -> list[View]:
    """Write an OSD folder whose annotation is 0 ignore, 1 support, 2 and more objects."""
    camera = kinect(*size)
    views = []
    for index, pose in enumerate(poses_around(n_frames)):
        view = render(camera, pose)
        write_image(root / f"image_color/learn{index}.png", view.rgb)
        write_depth(root / f"depth/learn{index}.png", view.depth)
        write_image(root / f"annotation/learn{index}.png", annotation(view))
        views.append(view)
    if with_camera:
        labels = {"ignore": [0], "support": [1], "objects_from": 2}
        write_camera_file(root, camera, labels=labels)
    return views


def write_folder(
    root: Path,
    n_frames: int = 3,
    *,
    size: tuple[int, int] = SIZE,
    with_poses: bool = True,
    with_ground_truth: bool = True,
) -> list[View]:
    """Write a plain folder; poses.txt has one line a frame."""
    camera = kinect(*size)
    poses = poses_around(n_frames)
    views = [render(camera, pose) for pose in poses]
    for index, view in enumerate(views):
        _write_view(root, index, view, with_ground_truth=with_ground_truth)
    if with_poses:
        lines = [pose_line(FIRST_STAMP + 0.1 * index, pose) for index, pose in enumerate(poses)]
        (root / "poses.txt").write_text("\n".join(lines))
    write_camera_file(root, camera)
    return views


def write_rooms(root: Path, n_rooms: int = 3, n_corners: int = 6, n_near: int = 3) -> None:
    """Write a plain folder of rooms 12 m apart; in each corner of one all colours are others.

    So one look teaches little about a room. Of a corner there are `n_near` neighbouring views.
    """
    camera, rng = kinect(*SIZE), np.random.default_rng(0)
    lines: list[str] = []
    for room, corner in np.ndindex(n_rooms, n_corners):
        boxes = tuple(replace(box, colour=tuple(rng.integers(0, 256, 3))) for box in SMALL_ROOM)
        turn = Rotation.from_euler("z", 2 * np.pi * corner / n_corners)
        T_world_corner = np.eye(4)
        T_world_corner[:3, :3], T_world_corner[0, 3] = turn.as_matrix(), 12 * room
        for heading in np.linspace(-8, 8, n_near):
            index = len(lines)
            pose = look(heading)
            _write_view(root, index, render(camera, pose, boxes))
            lines.append(pose_line(FIRST_STAMP + 0.1 * index, T_world_corner @ pose))
    (root / "poses.txt").write_text("\n".join(lines))
    write_camera_file(root, camera)


def _write_view(root: Path, index: int, view: View, *, with_ground_truth: bool = True) -> None:
    write_image(root / f"rgb/{index:06d}.png", view.rgb)
    write_depth(root / f"depth/{index:06d}.png", view.depth)
    if with_ground_truth:
        write_image(root / f"ground_truth/{index:06d}.png", view.ground_truth)


def annotation(view: View) -> npt.NDArray[np.uint8]:
    """Return OSD-like labels: 0 nothing seen, 1 floor and wall, from 2 objects."""
    labels = np.where(view.ground_truth == 255, view.surface + 1, 1)
    return np.where(view.surface < 0, 0, labels).astype(np.uint8)


def pose_line(stamp: float, pose: Pose) -> str:
    """Return `stamp tx ty tz qx qy qz qw`."""
    numbers = [*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
    return f"{stamp:.6f} " + " ".join(f"{number:.9f}" for number in numbers)


def truncate(path: Path, share: float = 0.5) -> None:
    """Cut a file off, as a full disk or a broken copy does."""
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
