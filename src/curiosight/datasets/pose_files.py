"""Find the poses of a recording's images, in files of any usual name and form."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from curiosight.datasets.listing import natural_key
from curiosight.datasets.pose_json import read_json_poses
from curiosight.datasets.pose_match import Matched, match_poses, plain_stem, varying_numbers
from curiosight.datasets.pose_text import PoseRow, read_pose_rows
from curiosight.frame import Pose

ENDINGS = frozenset(
    (".txt", ".log", ".traj", ".pose", ".poses", ".freiburg", ".tum", ".csv", ".npy", ".json")
)
# What the name of a file of many poses says, the likeliest first; the last may drift.
SPEAKING = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        r"^poses?\.|^camera[_-]?poses?\.",
        r"^trajectory|^traj([._-]|$)|camera_?trajectory",
        r"^ground_?truth|^gt[._-]|gt\.freiburg$",
        r"traj|poses?|\.freiburg$|\.tum$|^transforms\.json$",
        r"^(?!.*odom).*\.log$",
        r"odom",
    )
)
GLOBAL_LOG = "trajectory.log"
POSE_FOLDERS = ("pose", "poses", "camera-pose", "camera_pose", "camera_poses", "")
POSE_SUFFIX = re.compile(r"[._-](?:camera[_-]?)?pose$", re.IGNORECASE)
# Of the images that have a file of their own, below which these files are something else.
MIN_SHARE_OF_FILES = 0.5
MAX_BYTES_OF_ONE = 4096
# Folders of colour images alone: what is one folder up is the recording's own.
IMAGE_FOLDERS = re.compile(r"^(?:rgb|colou?r|images?|imgs?|frames?|results)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class FoundPoses:
    """Poses that were found for images.

    poses: (4, 4) one an image, as the source has them; None = unknown.
    source: the file, or the folder of files. remark: how they were matched, a sentence.
    n_lost: how many images the source names without a pose that is one.
    """

    poses: tuple[Pose | None, ...]
    source: Path
    remark: str
    n_lost: int


def find_poses(
    folder: Path,
    names: Sequence[str],
    stamps_ns: Sequence[int | None] | None = None,
    *,
    files: Sequence[Path] | None = None,
) -> FoundPoses | None:
    """Return the poses of images, or None where there is no file of poses.

    names: stems of the colour images, in order. stamps_ns: when they were taken, where that is
    known better than from their names. files: where to look, instead of in `folder` and, for
    what is named so, one folder up. Where a file of poses fits no image, `poses` are all None
    and the remark tells it.
    """
    misfit = None
    for path in _trajectory_files(folder) if files is None else files:
        rows = _rows_of(path)
        if rows is None:
            continue
        matched = match_poses(rows, names, stamps_ns)
        is_near = files is not None or path.parent == folder or _belongs(path, folder)
        if matched is not None and (is_near or matched.is_certain):
            return _found(path, rows, matched)
        if matched is None and is_near and len(rows) > 1 and misfit is None:
            misfit = _unmatched(path, len(rows), len(names))
    if files is not None:
        return misfit
    return _files_of_images(folder, names) or misfit


def _trajectory_files(folder: Path) -> Iterator[Path]:
    """Yield files that may hold many poses, the likeliest first; those one folder up last."""
    folder = folder.resolve() if folder.name in ("", "..") else folder
    for place in (folder, folder.parent):
        texts = [path for path in _children(place) if path.suffix.lower() in ENDINGS]
        if any(path.name.lower() == GLOBAL_LOG for path in texts):
            # Open3D's odometry is from frame to frame, and drifts; the other is the result.
            texts = [path for path in texts if not path.name.lower().startswith("odom")]
        own = re.compile(rf"^{re.escape(folder.resolve().name)}([._-]|$)", re.IGNORECASE)
        patterns = (*SPEAKING, own) if place != folder else SPEAKING
        listed = [path for path in texts if not POSE_SUFFIX.search(path.stem)]
        # One a frame are no trajectories; they are looked at together.
        ranked = {
            path: next(r for r, pattern in enumerate(patterns) if pattern.search(path.name))
            for path in listed
            if any(pattern.search(path.name) for pattern in patterns)
        }
        yield from sorted(ranked, key=lambda path: (ranked[path], natural_key(path.name)))


def _rows_of(path: Path) -> list[PoseRow] | None:
    is_json = path.suffix.lower() == ".json"
    return read_json_poses(path) if is_json else read_pose_rows(path)


def _children(folder: Path) -> list[Path]:
    try:
        return [path for path in folder.iterdir() if path.is_file() and path.name[0] != "."]
    except OSError:
        return []


def _belongs(path: Path, folder: Path) -> bool:
    """Tell whether a file one folder up is of this folder: called after it, or beside images."""
    name = folder.resolve().name.lower()
    return path.name.lower().startswith(name) or bool(IMAGE_FOLDERS.match(name))


def _found(path: Path, rows: Sequence[PoseRow], matched: Matched) -> FoundPoses:
    poses = tuple(None if row is None else rows[row].pose for row in matched.rows)
    if matched.between is not None:
        poses = tuple(matched.between)
    n_lost = sum(row is not None and rows[row].pose is None for row in matched.rows)
    return FoundPoses(poses, path, _remark(path.name, matched.how, poses, n_lost), n_lost)


def _remark(name: str, how: str, poses: Sequence[Pose | None], n_lost: int) -> str:
    n_other = sum(pose is None for pose in poses) - n_lost
    lost = f"{n_lost} of them are lost (no rigid pose)" if n_lost else ""
    other = f"it has none for {n_other} of {len(poses)} images" if n_other > 0 else ""
    return "; ".join(filter(None, (f"poses of {name} are matched {how}", lost, other)))


def _unmatched(path: Path, n_poses: int, n_images: int) -> FoundPoses:
    remark = (
        f"poses of {path.name} are left out: it holds {n_poses} for {n_images} images, and "
        "neither stamps nor numbers say which is whose"
    )
    return FoundPoses((None,) * n_images, path, remark, 0)


def _files_of_images(folder: Path, names: Sequence[str]) -> FoundPoses | None:
    """Return the poses of files that hold one each."""
    for name in POSE_FOLDERS:
        for place in (folder / name, folder.parent / name) if name else (folder,):
            files = {
                POSE_SUFFIX.sub("", path.stem): path
                for path in _children(place)
                if path.suffix.lower() in ENDINGS and path.stat().st_size <= MAX_BYTES_OF_ONE
            }
            of_image, how = _by_stem(files, names)
            if sum(file is not None for file in of_image) < MIN_SHARE_OF_FILES * len(names):
                continue
            read = [None if file is None else _rows_of(file) for file in of_image]
            # A matrix that is no pose is lost only among others that are.
            if not any(rows and len(rows) == 1 and rows[0].pose is not None for rows in read):
                continue
            poses = tuple(rows[0].pose if rows and len(rows) == 1 else None for rows in read)
            n_lost = sum(
                pose is None and file is not None
                for pose, file in zip(poses, of_image, strict=True)
            )
            return FoundPoses(poses, place, _remark(f"{place.name}/", how, poses, n_lost), n_lost)
    return None


def _by_stem(files: dict[str, Path], names: Sequence[str]) -> tuple[list[Path | None], str]:
    """Return the file of each image, by name or by the number in the name; and how."""
    by_name = [files.get(name, files.get(plain_stem(name))) for name in names]
    if any(by_name):
        return by_name, "by name"
    # Either side counts in its own words, such as rgb_12 and pose_12.
    for of_files in varying_numbers(list(files)):
        file_of_number = dict(zip(of_files, files.values(), strict=True))
        for of_names in varying_numbers(names):
            if any(number in file_of_number for number in of_names):
                return [file_of_number.get(number) for number in of_names], "by number"
    return [None] * len(names), ""
