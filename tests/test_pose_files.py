"""Poses are found and read in files of any usual name and form."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import open_dataset
from curiosight.datasets.pose_files import FoundPoses, find_poses
from curiosight.frame import Pose
from recordings import pose_line, write_folder
from room import poses_around

NAMES = ["000000", "000001", "000002", "000003"]
POSES = poses_around(4)
STAMP = 1305031229.5


def row_of(pose: Pose, n_rows: int = 4) -> str:
    return " ".join(f"{number:.12g}" for number in pose[:n_rows].ravel())


def block_of(pose: Pose, n_rows: int = 4) -> str:
    return "\n".join(" ".join(f"{number:.12g}" for number in row) for row in pose[:n_rows])


def quaternion_first(pose: Pose) -> str:
    position, quaternion = np.split(np.array(pose_line(0, pose).split()[1:], float), [3])
    return " ".join(map(str, [*np.roll(quaternion, 1), *position]))


def write(path: Path, lines: Sequence[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines))


def found_in(folder: Path, names: Sequence[str] = NAMES) -> FoundPoses:
    found = find_poses(folder, names)
    assert found is not None
    return found


def assert_poses(found: FoundPoses, expected: Sequence[Pose | None] = POSES) -> None:
    assert len(found.poses) == len(expected)
    for pose, right in zip(found.poses, expected, strict=True):
        if right is None or pose is None:
            assert pose is right
        else:
            np.testing.assert_allclose(pose, right, atol=1e-6)


FORMS: dict[str, Callable[[int, Pose], str]] = {
    "16 numbers": lambda i, pose: row_of(pose),
    "16 numbers in columns": lambda i, pose: row_of(pose.T),
    "12 numbers": lambda i, pose: row_of(pose, 3),
    "a number and 16": lambda i, pose: f"{i} {row_of(pose)}",
    "commas": lambda i, pose: f"{i}, {row_of(pose, 3).replace(' ', ', ')}",
    "a name and 12": lambda i, pose: f"rgb/{i:06d}.png {row_of(pose, 3)}",
    "stamp and quaternion": lambda i, pose: pose_line(STAMP + i, pose),
    "no stamp": lambda i, pose: pose_line(0, pose).partition(" ")[2],
    "quaternion first": lambda i, pose: quaternion_first(pose),
    "Redwood": lambda i, pose: f"{i} {i} {i + 1}\n{block_of(pose)}",
    "blocks": lambda i, pose: block_of(pose) + "\n\n",
    "blocks of three lines": lambda i, pose: block_of(pose, 3),
    "blocks after a number": lambda i, pose: f"{i}\n{block_of(pose)}",
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["traj.txt", "livingRoom1.gt.freiburg", "trajectory.log"])
def test_trajectory_is_read_in_any_form(tmp_path: Path, form: str, name: str) -> None:
    lines = [FORMS[form](index, pose) for index, pose in enumerate(POSES)]
    write(tmp_path / name, ["# made by a test", *lines, ""])
    found = found_in(tmp_path)
    assert found.source == tmp_path / name
    assert found.n_lost == 0
    assert_poses(found)


JSON_FORMS = {
    "poses.json": lambda: [pose.tolist() for pose in POSES],
    "pose.json": lambda: {
        name: pose.ravel().tolist() for name, pose in zip(NAMES, POSES, strict=True)
    },
    "camera_poses.json": lambda: {
        "poses": [{"id": n, "pose": pose[:3].tolist()} for n, pose in enumerate(POSES)]
    },
    "transforms.json": lambda: {
        "fl_x": 500.0,
        "frames": [
            {
                "file_path": f"rgb/{name}.png",
                "transform_matrix": (pose @ np.diag([1.0, -1, -1, 1])).tolist(),
            }
            for name, pose in reversed(list(zip(NAMES, POSES, strict=True)))
        ],
    },
    "trajectory.json": lambda: {
        "class_name": "PinholeCameraTrajectory",
        "parameters": [{"extrinsic": np.linalg.inv(pose).T.ravel().tolist()} for pose in POSES],
    },
}


@pytest.mark.parametrize("name", JSON_FORMS)
def test_json_is_read(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(json.dumps(JSON_FORMS[name]()))
    for found, pose in zip(found_in(tmp_path).poses, POSES, strict=True):
        assert found == pytest.approx(pose)


def test_header_tells_where_w_stands(tmp_path: Path) -> None:
    lines = []
    for index, pose in enumerate(POSES):
        words = pose_line(STAMP + index, pose).split()
        lines.append(",".join([*words[:4], words[7], *words[4:7]]))
    write(tmp_path / "groundtruth.csv", ["timestamp,tx,ty,tz,qw,qx,qy,qz", *lines])
    assert_poses(found_in(tmp_path))


@pytest.mark.parametrize(
    "name", ["pose/{}.txt", "poses/{}.txt", "{}.pose.txt", "{}-pose.txt", "camera-pose/{}.txt"]
)
def test_one_file_an_image(tmp_path: Path, name: str) -> None:
    for image, pose in zip(NAMES, POSES, strict=True):
        write(tmp_path / name.format(image), [block_of(pose)])
    found = found_in(tmp_path, [f"{image}.color" for image in NAMES])
    assert "by name" in found.remark
    assert_poses(found)


def test_one_file_an_image_by_number(tmp_path: Path) -> None:
    for index, pose in enumerate(POSES):
        write(tmp_path / f"poses/pose_{index}.txt", [block_of(pose)])
    found = found_in(tmp_path, ["rgb_0001", "rgb_0003"])
    assert "by number" in found.remark
    assert_poses(found, POSES[1::2])


@pytest.mark.parametrize("fill", ["nan", "-inf", "0", "-nan(ind)", "-1.#IND"])
def test_lost_poses_are_none_and_counted(tmp_path: Path, fill: str) -> None:
    lines = [row_of(pose) for pose in POSES]
    lines[1] = " ".join([fill] * 16)
    write(tmp_path / "poses.txt", lines)
    found = found_in(tmp_path)
    assert found.n_lost == 1
    assert "1 of them are lost" in found.remark
    assert_poses(found, [POSES[0], None, *POSES[2:]])


def test_lost_pose_in_blocks_and_in_files(tmp_path: Path) -> None:
    blocks = [f"{i} {i} {i + 1}\n{block_of(pose)}" for i, pose in enumerate(POSES)]
    blocks[2] = "2 2 3\n" + block_of(np.full((4, 4), np.nan))
    write(tmp_path / "log/trajectory.log", blocks)
    assert_poses(found_in(tmp_path / "log"), [*POSES[:2], None, POSES[3]])
    for image, pose in zip(NAMES, POSES, strict=True):
        write(tmp_path / f"files/pose/{image}.txt", [block_of(pose)])
    write(tmp_path / f"files/pose/{NAMES[0]}.txt", [block_of(np.full((4, 4), -np.inf))])
    found = found_in(tmp_path / "files")
    assert found.n_lost == 1
    assert_poses(found, [None, *POSES[1:]])


def test_all_poses_lost(tmp_path: Path) -> None:
    write(tmp_path / "poses.txt", [" ".join(["nan"] * 12)] * 4)
    assert found_in(tmp_path).n_lost == 4
    assert_poses(found_in(tmp_path), [None] * 4)


def test_images_that_count_from_one_are_matched_line_by_line(tmp_path: Path) -> None:
    write(tmp_path / "traj.txt", [f"{i} {row_of(pose)}" for i, pose in enumerate(POSES)])
    found = found_in(tmp_path, ["0001", "0002", "0003", "0004"])
    assert "line by line" in found.remark
    assert_poses(found)


def test_every_second_image_is_matched_by_number(tmp_path: Path) -> None:
    write(tmp_path / "traj.txt", [row_of(pose) for pose in POSES])
    assert_poses(found_in(tmp_path, ["frame000000", "frame000002"]), POSES[::2])


def test_stamps_in_exponents_and_nanoseconds(tmp_path: Path) -> None:
    stamps = [STAMP + 0.1 * index for index in range(4)]
    lines = [pose_line(s, p).split() for s, p in zip(stamps, POSES, strict=True)]
    exponents = [" ".join([f"{s:.18e}", *w[1:]]) for s, w in zip(stamps, lines, strict=True)]
    write(tmp_path / "groundtruth.txt", exponents[::-1])
    found = found_in(tmp_path, [f"{round(stamp * 1e9)}" for stamp in stamps])
    assert "by stamp" in found.remark
    assert_poses(found)


def test_poses_between_stamps(tmp_path: Path) -> None:
    """A tracker of its own clock rate: images lie between its poses."""
    lines = []
    for index, pose in enumerate(POSES):
        lines += [pose_line(STAMP + 0.1 * index + off, pose) for off in (-0.004, 0.004)]
    write(tmp_path / "groundtruth.txt", lines)
    found = found_in(tmp_path, [f"{STAMP + 0.1 * index:.6f}" for index in range(4)])
    assert "between" in found.remark
    assert_poses(found)


def test_stamps_that_the_caller_knows(tmp_path: Path) -> None:
    write(tmp_path / "gt.txt", [pose_line(STAMP + i, p) for i, p in enumerate(POSES)])
    stamps = [round((STAMP + index) * 1e9) for index in (2, 0)]
    found = find_poses(tmp_path, ["b", "a"], stamps)
    assert found is not None
    assert_poses(found, [POSES[2], POSES[0]])


def test_file_that_fits_no_image_is_named(tmp_path: Path) -> None:
    write(tmp_path / "traj.txt", [row_of(pose) for pose in POSES])
    found = found_in(tmp_path, [f"{index:06d}" for index in range(7)])
    assert_poses(found, [None] * 7)
    assert "traj.txt are left out: it holds 4 for 7 images" in found.remark


def test_global_trajectory_is_preferred_to_odometry(tmp_path: Path) -> None:
    write(tmp_path / "odometry.log", [FORMS["Redwood"](i, np.eye(4)) for i in range(4)])
    assert_poses(found_in(tmp_path), [np.eye(4)] * 4)
    write(tmp_path / "trajectory.log", [FORMS["Redwood"](i, p) for i, p in enumerate(POSES)])
    assert_poses(found_in(tmp_path))


def test_one_folder_up_only_where_the_names_say_so(tmp_path: Path) -> None:
    for name in ("office1", "office2"):
        (tmp_path / name).mkdir()
    write(tmp_path / "traj.txt", [row_of(pose) for pose in POSES])
    assert find_poses(tmp_path / "office1", NAMES) is None
    write(tmp_path / "office2-traj.txt", [row_of(pose) for pose in POSES])
    assert find_poses(tmp_path / "office1", NAMES) is None
    assert_poses(found_in(tmp_path / "office2"))
    (tmp_path / "results").mkdir()
    assert found_in(tmp_path / "results").source.name == "traj.txt"


@pytest.mark.parametrize(
    "text",
    [
        "525 0 319.5\n0 525 239.5\n0 0 1",
        "525 0 319.5 0\n0 525 239.5 0\n0 0 1 0\n0 0 0 1",
        "0.0 rgb/0.png 0.0 depth/0.png\n1.0 rgb/1.png 1.0 depth/1.png",
        "1.0 rgb/1.png\n2.0 rgb/2.png",
        "1,-1,912,484,97,109,0\n2,-1,338,418,167,379,1\n3,-1,3,4,16,37,1",
        "[12:00:01] started\n[12:00:02] stopped",
        "",
        '{"poses": [1, 2]}',
    ],
)
@pytest.mark.parametrize("name", ["poses.txt", "gt.txt", "trajectory.log", "run.log"])
def test_other_files_are_no_poses(tmp_path: Path, text: str, name: str) -> None:
    write(tmp_path / name, [text])
    assert find_poses(tmp_path, NAMES) is None
    assert find_poses(tmp_path, NAMES[:1]) is None


def test_arrays(tmp_path: Path) -> None:
    np.save(tmp_path / "poses.npy", np.array(POSES))
    assert_poses(found_in(tmp_path))
    np.save(tmp_path / "poses.npy", np.array(POSES)[:, :3])
    assert_poses(found_in(tmp_path))
    for other in (np.zeros(0), np.zeros((3, 0)), np.array(3.0), np.zeros((2, 4, 4, 4))):
        np.save(tmp_path / "poses.npy", other)
        assert find_poses(tmp_path, NAMES) is None


def test_plain_folder_takes_poses_of_any_form(tmp_path: Path) -> None:
    write_folder(tmp_path, 4, with_poses=False)
    write(tmp_path / "traj.txt", [row_of(pose, 3) for pose in POSES])
    dataset = open_dataset(tmp_path)
    for pose, right in zip(dataset.poses, POSES, strict=True):
        assert pose is not None
        np.testing.assert_allclose(pose, right, atol=1e-6)
    assert any("traj.txt" in remark for remark in dataset.remarks)


@pytest.mark.parametrize("name", ["frame_{}.{}", "rgb-{}-{}", "{}_{}_color", "cam0_{}{}"])
def test_stamp_inside_a_name(tmp_path: Path, name: str) -> None:
    stamps = [(1305031229 + index, 500000 + index) for index in range(3)]
    lines = [
        pose_line(0, pose).replace("0.000000", f"{seconds}.{micros}", 1)
        for (seconds, micros), pose in zip(stamps, POSES[:3], strict=True)
    ]
    write(tmp_path / "groundtruth.txt", lines)
    found = found_in(tmp_path, [name.format(*stamp) for stamp in stamps[1:]])
    assert "by stamp" in found.remark
    assert_poses(found, POSES[1:3])


def test_images_that_a_tracker_lost_are_not_interpolated(tmp_path: Path) -> None:
    """Where the file has images' own stamps, one that it leaves out has no pose."""
    lines = [pose_line(STAMP + 0.1 * index, pose) for index, pose in enumerate(POSES)]
    write(tmp_path / "trajectory.txt", [*lines[:1], *lines[2:]])
    found = found_in(tmp_path, [f"{STAMP + 0.1 * index:.6f}" for index in range(4)])
    assert_poses(found, [POSES[0], None, *POSES[2:]])
    assert "it has none for 1 of 4 images" in found.remark
