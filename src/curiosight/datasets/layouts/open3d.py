"""Read recordings of Open3D: color/ with depth/, trajectory.log, a camera with intrinsic_matrix."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from curiosight.datasets.cameras.camera_file import FILE_NAME
from curiosight.datasets.depth_files import DEPTH_ENDINGS
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import (
    find_ground_truth,
    find_sequences,
    list_images,
    natural_key,
    subfolder,
)
from curiosight.datasets.pose_files import FoundPoses, find_poses
from curiosight.datasets.pose_match import varying_numbers
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text

COLOUR_FOLDERS = ("color", "rgb", "image")
# The second is what the reconstruction system writes; its fragments are of worlds of their own.
TRAJECTORIES = ("trajectory.log", "scene/trajectory.log")
MAX_BYTES = 100_000


class Open3d(Calibrated):
    """A folder as Open3D's examples, recorders and reconstruction system have it.

    Each folder has a world of its own, so that frames have poses where one is opened.
    """

    name = "Open3D"
    evidence = "color/, rgb/ or image/ with depth/, trajectory.log or a camera of Open3D"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one in it, is laid out this way."""
        return bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        sequences = _sequences(path)
        remarks: list[str] = []
        entries: list[Entry] = []
        found: list[FoundPoses] = []
        for prefix, sequence in sequences.items():
            listed, poses = _list_sequence(path, sequence, prefix, remarks)
            entries += listed
            found += [poses] if poses else []
        if len(sequences) > 1 and found:
            remarks.append("each folder has a world of its own: open a single one to have poses")
            entries = [replace(entry, T_world_camera=None) for entry in entries]
        else:
            remarks += [poses.remark for poses in found]
        first = path if (path / FILE_NAME).is_file() else next(iter(sequences.values()))
        super().__init__(path, entries, remarks, camera_folder=first, avoid=("config.json",))


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, _is_open3d, levels=1) if path.is_dir() else {}


def _is_open3d(folder: Path) -> bool:
    colour = subfolder(folder, COLOUR_FOLDERS)
    if colour is None or not (folder / "depth").is_dir():
        return False
    has_camera = _has_camera(folder) or _has_camera(folder.resolve().parent)
    if colour.name == "rgb":  # else a plain folder
        return has_camera and not (folder / FILE_NAME).is_file()
    return has_camera or any((folder / name).is_file() for name in TRAJECTORIES)


def _has_camera(folder: Path) -> bool:
    """Tell whether a JSON file of the folder has the key that Open3D writes."""
    for path in folder.glob("*.json"):
        try:
            content = json.loads(read_text(path, max_bytes=MAX_BYTES))
        except (OSError, ValueError, RecursionError):
            continue
        if isinstance(content, dict):
            inner = content.get("intrinsic")
            if "intrinsic_matrix" in (*content, *(inner if isinstance(inner, dict) else ())):
                return True
    return False


def _list_sequence(
    root: Path, sequence: Path, prefix: str, remarks: list[str]
) -> tuple[list[Entry], FoundPoses | None]:
    colour = subfolder(sequence, COLOUR_FOLDERS)
    assert colour is not None
    images = list_images(colour)
    depth = _paired(sequence, list(images.values()), remarks)
    names = [rgb.stem for rgb in images.values()]
    files = [sequence / name for name in TRAJECTORIES if (sequence / name).is_file()]
    found = find_poses(sequence, names, files=files) if files else find_poses(sequence, names)
    poses = found.poses if found else (None,) * len(images)
    ground_truth = find_ground_truth(root, sequence, prefix)
    entries = [
        Entry(
            id=prefix + id,
            rgb=rgb,
            depth=file,
            T_world_camera=pose,
            ground_truth=ground_truth.get(id),
        )
        for (id, rgb), file, pose in zip(images.items(), depth, poses, strict=True)
    ]
    return entries, found


def _paired(sequence: Path, images: list[Path], remarks: list[str]) -> list[Path]:
    """Return each image's depth: of its name, of its number, or, as Open3D does, by order."""
    folder = sequence / "depth"
    files = sorted(
        (path for path in folder.iterdir() if path.suffix.lower() in DEPTH_ENDINGS),
        key=lambda path: natural_key(path.name),
    )
    if not files:
        raise DataError(folder, "holds no depth files", "add 16-bit depth images")
    file_of_stem = {file.stem: file for file in files}
    paired = [file_of_stem.get(rgb.stem) for rgb in images]
    if not any(paired):
        numbers, of_images = (
            varying_numbers([path.stem for path in paths])[:1] for paths in (files, images)
        )
        file_of_number = dict(zip(numbers[0], files, strict=True)) if numbers else {}
        paired = [file_of_number.get(n) for n in of_images[0]] if of_images else paired
    if not any(paired) and len(files) == len(images):
        remarks.append("colour and depth are paired in order of their names: these differ")
        return files
    return [file or folder / f"{rgb.stem}.png" for file, rgb in zip(paired, images, strict=True)]
