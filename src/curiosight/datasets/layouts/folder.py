"""Read a plain folder: rgb/, depth/, camera.json, and what else there may be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.datasets.depth_files import DEPTH_ENDINGS, assumed_form
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, list_images, natural_key
from curiosight.datasets.pairs import match_names
from curiosight.datasets.pose_files import find_poses
from curiosight.datasets.pose_match import match_stamps
from curiosight.datasets.trajectory import read_trajectory, table_rows
from curiosight.errors import DataError
from curiosight.frame import Pose

POSE_FILE = "poses.txt"
BAD_POSE = f"{POSE_FILE} holds no valid pose for it"
BY_ORDER = f"{POSE_FILE} is taken line by line: its stamps are not the images' names"


class Folder(Calibrated):
    """A folder with `rgb/` and `depth/`, files of the same names, registered to each other."""

    name = "plain folder"
    has_any_unit = True
    evidence = "rgb/ with depth/"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds `rgb/` and `depth/`."""
        return (path / "rgb").is_dir() and (path / "depth").is_dir()

    def __init__(self, path: Path) -> None:
        images = list_images(path / "rgb")
        if not images:
            raise DataError(path / "rgb", "holds no images", "add colour images")
        remarks: list[str] = []
        depth = _depth_of(path / "depth", images, remarks)
        confidence = _confidence_of(path / "confidence", images)
        poses, stamps = _poses(path, list(images), remarks)
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=depth[id],
                confidence=confidence.get(rgb),
                T_world_camera=pose,
                stamp_ns=stamp,
                ground_truth=ground_truth.get(id),
                pose_problem=BAD_POSE if pose is None and stamp is not None else None,
            )
            for (id, rgb), pose, stamp in zip(images.items(), poses, stamps, strict=True)
        ]
        assumed = assumed_form(entry.depth for entry in entries if entry.depth)
        super().__init__(path, entries, remarks, usual_form=assumed)


def _depth_of(folder: Path, images: dict[str, Path], remarks: list[str]) -> dict[str, Path]:
    """Return the depth file of each frame; where names differ, by what is alike in them."""
    files = [
        path
        for path in sorted(folder.iterdir(), key=lambda path: natural_key(path.name))
        if path.suffix.lower() in DEPTH_ENDINGS and not path.name.startswith(".")
    ]
    if not files:
        endings = ", ".join(DEPTH_ENDINGS)
        raise DataError(folder, f"holds no {endings} files", "add depth images of 16 bits")
    by_stem = {path.stem: path for path in reversed(files)}
    if by_stem.keys() & {rgb.stem for rgb in images.values()}:
        # One that is missing costs one frame.
        return {id: by_stem.get(rgb.stem, folder / f"{rgb.stem}.png") for id, rgb in images.items()}
    pairs, how = match_names(list(images.values()), files)
    if not pairs:
        first = next(iter(images.values())).name
        found = f"has no depth for the images in rgb, such as {first}: its files are called "
        remedy = "give a frame's two files one name"
        raise DataError(folder, f"{found}{files[0].name}", remedy)
    remarks.append(f"depth is found by {how}: {pairs[0][0].name} with {pairs[0][1].name}")
    depth_of = dict(pairs)
    return {id: depth_of.get(rgb, folder / f"{rgb.stem}.png") for id, rgb in images.items()}


def _confidence_of(folder: Path, images: dict[str, Path]) -> dict[Path, Path]:
    """Return the image of how sure depth is for each colour image that has one."""
    files = list(list_images(folder).values()) if folder.is_dir() else []
    return dict(match_names(list(images.values()), files)[0]) if files else {}


def _poses(
    path: Path, ids: Sequence[str], remarks: list[str]
) -> tuple[Sequence[Pose | None], Sequence[int | None]]:
    """Return each image's pose and the stamp of its line of `poses.txt`; remark on them."""
    unknown = [None] * len(ids)
    file = path / POSE_FILE
    _, words = next(table_rows(file), (0, [])) if file.is_file() else (0, [])
    if not file.is_file() or (words and len(words) != 8):
        found = find_poses(path, ids)
        if found is not None:
            remarks.append(found.remark)
            return found.poses, unknown
        if not file.is_file():
            return unknown, unknown
    trajectory = read_trajectory(file)
    rows, is_by_order = match_stamps(file, trajectory.stamps_ns.tolist(), ids)
    listed = trajectory.poses()
    if is_by_order:
        remarks.append(BY_ORDER)
    return (
        [None if row is None else listed[row] for row in rows],
        [None if row is None else int(trajectory.stamps_ns[row]) for row in rows],
    )
