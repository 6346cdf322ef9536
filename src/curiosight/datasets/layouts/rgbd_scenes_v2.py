"""Read RGB-D Scenes v2 (University of Washington): imgs/scene_NN, poses in pc/NN.pose."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, find_sequences, list_images
from curiosight.datasets.trajectory import Trajectory, table_rows
from curiosight.errors import DataError
from curiosight.frame import Camera, Pose

# What those who use the data set take, as its makers' code for clouds does.
CAMERA = Camera(640, 480, 570.3, 570.3, 320.0, 240.0)
# Unlike v1's millimetres; its makers print no unit, their clouds and those who read them agree.
UNIT = DepthForm(0.0001, is_assumed=True)
SCENE = re.compile(r"scene_\d+")
WHOSE = "the usual intrinsics of this data set are assumed"


class RgbdScenesV2(Calibrated):
    """A scene, or all of them.

    Each scene has a world of its own, so that frames have poses where one scene is opened.
    """

    name = "RGB-D Scenes v2"
    evidence = "scene_*/N-color.png with N-depth.png"
    usual_camera = CAMERA
    usual_form = UNIT
    whose = WHOSE

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder is a scene, or holds scenes, maybe in `imgs`."""
        return bool(_scenes(path))

    def __init__(self, path: Path) -> None:
        scenes = _scenes(path)
        remarks: list[str] = []
        pose_files = {prefix: _pose_file(scene) for prefix, scene in scenes.items()}
        if len(scenes) > 1:
            remarks.append("each scene has a world of its own: open a single one to have poses")
            pose_files = {}
        elif not all(file.is_file() for file in pose_files.values()):
            remarks.append(f"no poses: they are looked for in {pose_files[''].parent}")
            pose_files = {}
        entries = [
            entry
            for prefix, scene in scenes.items()
            for entry in _list_scene(path, scene, prefix, pose_files.get(prefix))
        ]
        super().__init__(path, entries, remarks)


def _scenes(path: Path) -> dict[str, Path]:
    images = path / "imgs" if (path / "imgs").is_dir() else path
    return find_sequences(images, _holds_frames, levels=1, pattern="scene_*")


def _holds_frames(folder: Path) -> bool:
    # Others name their images so too: only the folder's name tells the unit of this data set.
    if not SCENE.fullmatch(folder.resolve().name):
        return False
    return any(folder.glob("*-color.png")) and any(folder.glob("*-depth.png"))


def _pose_file(scene: Path) -> Path:
    """Return where the poses of `imgs/scene_01` should be: `pc/01.pose`."""
    folder = scene.resolve()
    return folder.parent.parent / "pc" / f"{folder.name.removeprefix('scene_')}.pose"


def _list_scene(root: Path, scene: Path, prefix: str, pose_file: Path | None) -> list[Entry]:
    poses = None if pose_file is None else _read_poses(pose_file)
    ground_truth = find_ground_truth(root, scene, prefix)
    entries = []
    for id, rgb in list_images(scene).items():
        pose, problem = None, None
        if poses is not None and pose_file is not None:
            place = int(id) if id.isdecimal() else len(poses)
            pose = poses[place] if place < len(poses) else None
            problem = None if pose is not None else f"{pose_file.name} holds no valid pose for it"
        entries.append(
            Entry(
                id=prefix + id,
                rgb=rgb,
                depth=scene / f"{id}-depth.png",
                T_world_camera=pose,
                ground_truth=ground_truth.get(id),
                pose_problem=problem,
            )
        )
    return entries


def _read_poses(path: Path) -> list[Pose | None]:
    """Read lines of `qw qx qy qz tx ty tz`, camera to world, one a frame; None = not a pose.

    Raises `DataError` for a line of any other form, and where there is none.
    """
    rows = []
    for number, words in table_rows(path):
        try:
            qw, qx, qy, qz, *position = (float(word) for word in words)
            tx, ty, tz = position
        except ValueError:
            found = f'line {number} is "{" ".join(words)[:60]}"'
            raise DataError(path, found, "expected: qw qx qy qz tx ty tz") from None
        rows.append((tx, ty, tz, qx, qy, qz, qw))
    if not rows:
        raise DataError(path, "holds no poses", "fill it or delete it")
    numbers = np.array(rows, np.float64)
    stamps = np.arange(len(rows), dtype=np.int64)
    return Trajectory(stamps, numbers[:, :3], numbers[:, 3:]).poses()
