"""What phones and scanners write: one folder a scan, or a folder of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from curiosight.datasets.cameras.depth_camera import DepthCamera
from curiosight.datasets.depth_files import MILLIMETRES, DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import find_ground_truth, find_sequences, natural_key
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import Size
from curiosight.errors import DataError
from curiosight.frame import Camera

ONE_WORLD_EACH = "each scan has a world of its own: open a single one to have poses"


@dataclass(frozen=True, slots=True)
class Scan:
    """One scan: its frames, named as if it were alone, and what holds for all of them."""

    entries: list[Entry]
    camera: Camera
    depth_form: DepthForm = MILLIMETRES
    remarks: list[str] = field(default_factory=list)
    depth_camera: DepthCamera | None = None


class Scans(Recording, ABC):
    """A scan, or a folder with scans up to `levels` below it.

    Each scan has a world of its own, so that frames have poses where one scan is opened.
    """

    levels = 1

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder is a scan of this layout, or holds some."""
        return path.is_dir() and bool(cls._folders(path))

    @staticmethod
    @abstractmethod
    def holds_scan(folder: Path) -> bool:
        """Tell whether the folder is a scan."""

    @abstractmethod
    def read_scan(self, folder: Path) -> Scan:
        """List the frames of a scan; raises `DataError` where it has none."""

    def __init__(self, path: Path) -> None:
        folders = self._folders(path)
        scans = {prefix: self.read_scan(folder) for prefix, folder in folders.items()}
        first = next(iter(scans.values()))
        if any(scan.depth_form != first.depth_form for scan in scans.values()):
            raise DataError(path, "its scans differ in the unit of depth", "open one at a time")
        remarks = list(_remarks(scans))
        entries = [
            _named(entry, prefix, scan, find_ground_truth(path, folders[prefix], prefix))
            for prefix, scan in scans.items()
            for entry in scan.entries
        ]
        if len(scans) > 1 and any(entry.T_world_camera is not None for entry in entries):
            entries = [replace(entry, T_world_camera=None) for entry in entries]
            remarks.append(ONE_WORLD_EACH)
        # Where depth of some is registered, each scan has what it needs in its entries.
        has_depth_camera = all(scan.depth_camera is not None for scan in scans.values())
        super().__init__(
            path,
            entries,
            first.camera,
            depth_form=first.depth_form,
            depth_camera=first.depth_camera if has_depth_camera else None,
            remarks=remarks,
        )

    @classmethod
    def _folders(cls, path: Path) -> dict[str, Path]:
        return find_sequences(path, cls.holds_scan, levels=cls.levels)


def numbered(paths: Iterable[Path]) -> dict[int, Path]:
    """Map the last whole number in files' names to the files, in order of the numbers."""
    numbers = {}
    for path in paths:
        digits = [part for kind, part in natural_key(path.stem) if not kind]
        if digits and not path.name.startswith("."):
            numbers[int(digits[-1])] = path
    return dict(sorted(numbers.items()))


def with_depth(
    colour: Mapping[int, Path], depth: Mapping[int, Path], folder: Path, remarks: list[str]
) -> list[int]:
    """Return the numbers of frames that have colour and depth, and remark on the others.

    Raises `DataError` where there is none.
    """
    numbers = [number for number in colour if number in depth]
    if not numbers:
        found = f"none of its {len(colour)} colour images has a depth image of the same number"
        raise DataError(folder, found, "check that the scan is complete")
    for what, other, images in (
        ("colour", "depth", len(colour)),
        ("depth", "colour", len(depth)),
    ):
        if images > len(numbers):
            n_alone = images - len(numbers)
            remarks.append(f"{n_alone} of {images} {what} images have no {other}: left out")
    return numbers


def remark_on_poses(entries: Iterable[Entry], remarks: list[str]) -> None:
    """Say how many frames have no pose, where some have one or all lack it."""
    poses = [entry.T_world_camera for entry in entries]
    n_lost = sum(pose is None for pose in poses)
    if n_lost == len(poses):
        remarks.append("no frame has a valid pose")
    elif n_lost:
        remarks.append(f"{n_lost} of {len(poses)} frames have no valid pose: tracking was lost")


def centred_size(cx: float, cy: float, sizes: Iterable[Size]) -> Size:
    """Return the size of images, (width, height), whose middle is nearest a principal point."""

    def off_centre(size: Size) -> float:
        return max(abs((2 * cx + 1) / size[0] - 1), abs((2 * cy + 1) / size[1] - 1))

    return min(sizes, key=off_centre)


def _named(entry: Entry, prefix: str, scan: Scan, ground_truth: Mapping[str, Path]) -> Entry:
    """Return a frame of a scan as one of several scans."""
    return replace(
        entry,
        id=prefix + entry.id,
        ground_truth=ground_truth.get(entry.id),
        camera=entry.camera or (scan.camera if prefix else None),
        depth_camera=scan.depth_camera if prefix else None,
    )


def _remarks(scans: Mapping[str, Scan]) -> Iterator[str]:
    """Yield what is to be said of the scans, the same words once."""
    places: dict[str, list[str]] = {}
    for prefix, scan in scans.items():
        for remark in scan.remarks:
            places.setdefault(remark, []).append(prefix.rstrip("/"))
    for remark, names in places.items():
        others = f" and {len(names) - 1} more" if len(names) > 1 else ""
        yield remark if len(names) == len(scans) else f"{names[0]}{others}: {remark}"
