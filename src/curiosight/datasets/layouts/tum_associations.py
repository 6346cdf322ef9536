"""Read recordings in the form of TUM RGB-D whose pairs of images stand in one file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DEPTH_ENDINGS, read_raw_depth
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.layouts.tum_rgbd import CAMERA, UNIT, WHOSE
from curiosight.datasets.listing import IMAGE_ENDINGS, find_ground_truth, frame_id
from curiosight.datasets.pose_match import stamp_or_none
from curiosight.datasets.poses_of_entries import with_found_poses
from curiosight.datasets.trajectory import table_rows
from curiosight.errors import DataError

FILE_NAME = re.compile(r"^assoc\w*([._-]\w+)*\.txt$", re.IGNORECASE)
ENDINGS = tuple(IMAGE_ENDINGS | set(DEPTH_ENDINGS))
N_LOOKED_AT = 5


@dataclass(frozen=True, slots=True)
class Pair:
    """Two images of one line, in its order, and the stamp before each; None = none."""

    files: tuple[Path, Path]
    stamps_ns: tuple[int | None, int | None]

    @property
    def is_stamped(self) -> bool:
        """Tell whether both images have a stamp."""
        return None not in self.stamps_ns

    @property
    def is_there(self) -> bool:
        """Tell whether both files are."""
        return all(file.is_file() for file in self.files)


class TumAssociations(Calibrated):
    """A recording in the form of TUM RGB-D with `associations.txt`, in either order."""

    name = "TUM RGB-D, associated"
    evidence = "associations.txt with lines of two images"
    usual_camera = CAMERA
    usual_form = UNIT
    whose = WHOSE

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether a file of the folder pairs images that are there."""
        return path.is_dir() and _association_file(path) is not None

    def __init__(self, path: Path) -> None:
        file = _association_file(path)
        assert file is not None
        pairs = _read_pairs(file)
        depth_first = _is_depth_first(file, pairs)
        remarks: list[str] = []
        listed: dict[Path, Entry] = {}
        ground_truth = find_ground_truth(path)
        for pair in pairs:
            depth, rgb = pair.files if depth_first else pair.files[::-1]
            id = frame_id(rgb)
            entry = Entry(
                id=id,
                rgb=rgb,
                depth=depth,
                stamp_ns=pair.stamps_ns[1 if depth_first else 0],
                ground_truth=ground_truth.get(id),
            )
            listed.setdefault(rgb, entry)
        if len(listed) < len(pairs):
            n_repeated = len(pairs) - len(listed)
            remarks.append(f"{n_repeated} lines of {file.name} repeat another: left out")
        entries = with_found_poses(path, list(listed.values()), remarks)
        super().__init__(path, entries, remarks, avoid=(file.name,))


def _association_file(path: Path) -> Path | None:
    for file in sorted(path.iterdir()):
        if FILE_NAME.search(file.name) and file.is_file():
            pairs = _pairs(file)[:N_LOOKED_AT]
            # Without stamps it may be a list of any program's.
            if any(pair.is_stamped and pair.is_there for pair in pairs):
                return file
    return None


def _pairs(file: Path) -> list[Pair]:
    """Return the pairs of a file; none where one of its lines is something else."""
    try:
        return _read_pairs(file)
    except DataError:
        return []


def _read_pairs(file: Path) -> list[Pair]:
    """Read lines of `[stamp] file [stamp] file`; raises `DataError` for any other."""
    pairs = []
    for number, words in table_rows(file):
        places = [place for place, word in enumerate(words) if word.lower().endswith(ENDINGS)]
        if len(places) != 2:
            found = f'line {number} is "{" ".join(words)[:60]}"'
            raise DataError(file, found, "expected: stamp, file name, stamp, file name")
        before = [words[place - 1] if place - 1 not in (-1, *places) else "" for place in places]
        first, second = (stamp_or_none(word) for word in before)
        a, b = (file.parent / words[place] for place in places)
        pairs.append(Pair((a, b), (first, second)))
    if not pairs:
        raise DataError(file, "lists no images", "check that the recording is complete")
    return pairs


def _is_depth_first(file: Path, pairs: list[Pair]) -> bool:
    """Tell whether the first image of each line is depth, by what it holds."""
    for pair in pairs:
        are_depth = [_is_depth(path) for path in pair.files]
        if are_depth[0] != are_depth[1]:
            return are_depth[0]
    remedy = "each line needs a colour image and depth of 16 bits"
    raise DataError(file, "pairs no colour image with depth", remedy)


def _is_depth(path: Path) -> bool:
    try:
        read_raw_depth(path)
    except UnreadableFile:
        return False
    return True
