"""Tell which frame of a recording a name means that another program gave it."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath

Keys = Callable[[str], Sequence[Hashable]]

ENDINGS = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".webp", ".tif", ".tiff", ".npy", ".gif"})

# Folders of colour images: ids leave them out, so that `seq/rgb/1.png` is frame `seq/1`.
COLOUR_FOLDERS = frozenset({"rgb", "gray", "color", "colour", "image_color", "images", "imgs"})
MAX_DIGITS = 18  # of a frame's number


@dataclass(frozen=True, slots=True)
class Matches:
    """Which name means which frame.

    name_of: the name that means each frame, by id. doubtful: two names that may mean the same
    frame, or one that may mean two; None where there is no doubt.
    """

    name_of: dict[str, str] = field(default_factory=dict)
    doubtful: tuple[str, str] | None = None


def match_names(names: Iterable[str], ids: Sequence[str]) -> Matches:
    """Match names of files, with or without folders and endings, with ids of frames.

    Trusted in this order: the whole path; the end of it, in either; the file's name alone; and,
    where none of these fits any, a name that is a number, by the number in the id. What fits
    twice is left out.
    """
    left, free = sorted(set(names)), list(dict.fromkeys(ids))
    found = Matches()
    for keys_of_name, keys_of_id in WAYS:
        found = _match(found, left, free, keys_of_name, keys_of_id)
        used = set(found.name_of.values())
        left = [name for name in left if name not in used]
        free = [id for id in free if id not in found.name_of]
    return found if found.name_of else _match(found, left, free, _own_number, _last_number)


def frame_of_file(file_name: str) -> str:
    """Return the frame that an image's file shows: `seq-01/frame-000001` of its `.color.png`."""
    path = PurePosixPath(file_name.replace("\\", "/"))
    stem = path.stem if path.suffix.lower() in ENDINGS else path.name
    for suffix in (".color", "-color"):
        stem = stem.removesuffix(suffix)
    return path.with_name(stem).as_posix() if stem else path.as_posix()


def _match(
    found: Matches,
    names: Sequence[str],
    ids: Sequence[str],
    keys_of_name: Keys,
    keys_of_id: Keys,
) -> Matches:
    """Add the pairs that share a key and fit nothing else."""
    ids_of_key: dict[Hashable, list[str]] = defaultdict(list)
    for id in ids:
        for key in keys_of_id(id):
            ids_of_key[key].append(id)
    fitting = {name: {id for key in keys_of_name(name) for id in ids_of_key[key]} for name in names}
    names_of_id: dict[str, list[str]] = defaultdict(list)
    for name, fits in fitting.items():
        for id in fits:
            names_of_id[id].append(name)
    pairs, doubtful = dict(found.name_of), found.doubtful
    for name, fits in fitting.items():
        if len(fits) > 1:
            doubtful = doubtful or (name, name)
        elif fits:
            (id,) = fits
            if len(names_of_id[id]) == 1:
                pairs[id] = name
            else:
                doubtful = doubtful or (names_of_id[id][0], names_of_id[id][1])
    return Matches(pairs, doubtful)


def _path(name: str) -> tuple[str, ...]:
    return PurePosixPath(frame_of_file(name)).parts


def _whole(name: str) -> list[Hashable]:
    return [_path(name)]


def _without_colour_folder(name: str) -> list[Hashable]:
    *folders, stem = _path(name) or ("",)
    return [(*(folder for folder in folders if folder not in COLOUR_FOLDERS), stem)]


def _ends(name: str) -> list[Hashable]:
    parts = _path(name)
    return [parts[first:] for first in range(len(parts))]


def _stem(name: str) -> list[Hashable]:
    return [_path(name)[-1:]]


def _own_number(name: str) -> list[Hashable]:
    stem = "".join(_path(name)[-1:])
    return [int(stem)] if re.fullmatch(r"[0-9]+", stem) and len(stem) <= MAX_DIGITS else []


def _last_number(id: str) -> list[Hashable]:
    stem = "".join(_path(id)[-1:])
    numbers = re.findall(r"[0-9]+", stem)
    is_stamp = re.fullmatch(r"[0-9]+\.[0-9]+", stem)
    return [int(numbers[-1])] if numbers and not is_stamp and len(numbers[-1]) <= MAX_DIGITS else []


# What a name and an id must share, the most trusted first.
WAYS: tuple[tuple[Keys, Keys], ...] = (
    (_whole, _whole),
    (_without_colour_folder, _without_colour_folder),
    (_ends, _whole),
    (_whole, _ends),
    (_stem, _stem),
)
