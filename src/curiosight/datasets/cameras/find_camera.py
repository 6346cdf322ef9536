"""Find the file of a recording's camera among what lies in its folder, one up and one down."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from curiosight.datasets.cameras.intrinsics import FoundCamera, read_intrinsics

ENDINGS = frozenset(
    [
        ".json",
        ".yaml",
        ".yml",
        ".txt",
        ".intr",
        ".ini",
        ".cfg",
        ".csv",
        ".conf",
        ".xml",
        ".mat",
        ".pincam",
        ".npy",
        ".toml",
    ]
)
MAX_BYTES = 200_000
# What a file's name says where it is about a camera.
NAMED = re.compile(
    r"cam(?!el)|intr|calib|kinect|realsense|primesense|param|meta|info|(^|[_.-])K($|[_.-])"
)


def find_camera(folder: Path, *, avoid: Iterable[str] = ()) -> FoundCamera | None:
    """Return the intrinsics of a file in a folder, in one of its folders, or one folder up.

    A file's name must speak of a camera unless it is the folder's own. avoid: names of files
    that are something else. None where no file holds intrinsics.
    """
    skipped = {name.lower() for name in avoid}
    for path in _candidates(folder):
        found = None if path.name.lower() in skipped else read_intrinsics(path)
        # A list of numbers is a camera only where the file's name says so.
        if found is not None and (found.is_named or NAMED.search(path.stem)):
            return found
    return None


def _candidates(folder: Path) -> Iterator[Path]:
    """Yield files that may hold intrinsics, the likeliest first."""
    own = _texts(folder)
    yield from (path for path in own if NAMED.search(path.stem) or path.suffix == ".intr")
    below = [child for child in _children(folder) if child.is_dir()]
    for child in below:
        is_named = bool(NAMED.search(child.name))
        yield from (p for p in _texts(child) if is_named or NAMED.search(p.stem))
    above = folder.resolve().parent
    yield from (p for p in _texts(above) if NAMED.search(p.stem) or p.suffix == ".intr")
    yield from (path for path in own if not NAMED.search(path.stem))


def _texts(folder: Path) -> list[Path]:
    """Return a folder's small text files; of many that are alike, one a frame, the first."""
    files: dict[str, Path] = {}
    for path in _children(folder):
        if path.suffix.lower() in ENDINGS and path.is_file() and path.stat().st_size <= MAX_BYTES:
            files.setdefault(re.sub(r"\d+", "0", path.name), path)
    return list(files.values())


def _children(folder: Path) -> list[Path]:
    try:
        return sorted(child for child in folder.iterdir() if not child.name.startswith("."))
    except OSError:
        return []
