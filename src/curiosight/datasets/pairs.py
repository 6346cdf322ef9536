"""Pair colour and depth images by their names, whatever these are, and by what they hold."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.datasets.association import associate
from curiosight.datasets.decoding import UnreadableFile, decode_unchanged
from curiosight.datasets.depth_files import ARRAY_ENDINGS, read_raw_depth
from curiosight.datasets.roles import Group, Role, find_groups, frame_key
from curiosight.datasets.sizes import Size, has_shape_of
from curiosight.datasets.trajectory import parse_stamp

# Of the images of the smaller side: fewer, and the names mean something else.
MIN_PAIRED = 0.5
# Smaller numbers count something else.
MIN_CLOCK_NS = 100_000_000 * 10**9
# Images that are tried until one of a group can be read.
N_TRIED = 3


@dataclass(frozen=True, slots=True)
class Pair:
    """The files of a frame; id: what the frame is called."""

    id: str
    rgb: Path
    depth: Path
    confidence: Path | None = None


@dataclass(frozen=True, slots=True)
class Pairing:
    """The frames of a folder.

    how: by what colour and depth were paired, in words. left_out: what other images are called.
    """

    pairs: tuple[Pair, ...]
    how: str
    left_out: tuple[str, ...] = ()
    n_without_depth: int = 0


def pair_folder(root: Path) -> Pairing | None:
    """Return the frames of a folder whose names tell colour from depth; None where none do.

    Both may lie in the folder, or in folders of their own inside it. What is called depth must
    hold depth, of 16 bits or floats, and colour must be a picture.
    """
    groups = find_groups(root)
    depths = {group: size for group in groups if (size := _depth_size(group)) is not None}
    if not depths:
        return None
    pictures = {group: picture for group in groups if (picture := _picture(group)) is not None}
    candidates = []
    for (colour, picture), (depth, size) in product(pictures.items(), depths.items()):
        matched, how = match_names(colour.files, depth.files)
        if matched:
            likeness = _likeness(colour, picture, depth, size)
            candidates.append((len(matched), likeness, colour, depth, matched, how))
    if not candidates:
        return None
    _, _, colour, depth, matched, how = max(candidates, key=lambda found: found[:2])
    return _pairing(root, groups, colour, depth, matched, how)


def match_names(
    colours: Sequence[Path], depths: Sequence[Path]
) -> tuple[list[tuple[Path, Path]], str]:
    """Return pairs of files that show the same, and by what they were paired.

    By whole names, by what is left of them without words such as depth, by the last number, or,
    where there are as many of both, in order. Too few pairs are none.
    """
    ways: tuple[tuple[str, Callable[[Path], str]], ...] = (
        ("their names", lambda path: path.stem),
        ("their names", lambda path: frame_key(path.stem)),
        ("the numbers in their names", lambda path: _last_number(path.stem)),
    )
    for how, key_of in ways:
        by_key = {key_of(path): path for path in reversed(depths)}
        pairs = [(rgb, by_key[key]) for rgb in colours if (key := key_of(rgb)) in by_key]
        is_unique = len({depth for _, depth in pairs}) == len(pairs)
        if is_unique and len(pairs) > MIN_PAIRED * min(len(colours), len(depths)):
            return pairs, how
    pairs = _match_stamps(colours, depths)
    if pairs:
        return pairs, "the times in their names"
    if len(colours) == len(depths) and colours[0].parent != depths[0].parent:
        return list(zip(colours, depths, strict=True)), "their order, for their names differ"
    return [], ""


def _pairing(
    root: Path,
    groups: Sequence[Group],
    colour: Group,
    depth: Group,
    matched: Sequence[tuple[Path, Path]],
    how: str,
) -> Pairing:
    files = [path for group in groups if group.role is Role.CONFIDENCE for path in group.files]
    sure = dict(match_names([rgb for rgb, _ in matched], files)[0]) if files else {}
    pairs = tuple(Pair(_id_of(rgb), rgb, file, sure.get(rgb)) for rgb, file in matched)
    used = {colour, depth, *(group for group in groups if group.role is Role.CONFIDENCE)}
    return Pairing(
        pairs,
        f"{_form(root, colour)} with {_form(root, depth)}, paired by {how}",
        tuple(_form(root, group) for group in groups if group not in used),
        len(colour.files) - len(matched),
    )


def _match_stamps(colours: Sequence[Path], depths: Sequence[Path]) -> list[tuple[Path, Path]]:
    """Return pairs whose names are times at most 20 ms apart; none where names are no times."""
    try:
        wanted, listed = ([(_stamp(p.stem), p) for p in files] for files in (colours, depths))
    except ValueError:
        return []
    near = [(rgb, depth) for _, rgb, depth in associate(wanted, listed)] if listed else []
    is_unique = len({depth for _, depth in near}) == len(near)
    return near if is_unique and len(near) > MIN_PAIRED * min(len(colours), len(depths)) else []


def _stamp(stem: str) -> int:
    """Read a time after 1973 in nanoseconds; raises `ValueError` for anything else."""
    numbers = re.findall(r"\d+(?:\.\d+)?", stem)
    stamp = parse_stamp(max(numbers, key=len)) if numbers else 0
    if stamp < MIN_CLOCK_NS:
        raise ValueError(f"stem: expected a time, got {stem!r}")
    return stamp


def _id_of(rgb: Path) -> str:
    return frame_key(rgb.stem) or rgb.stem


def _form(root: Path, group: Group) -> str:
    """Write what a group's files are called: color_N.png."""
    forms = dict.fromkeys(re.sub(r"\d+", "N", path.name) for path in group.files)
    name = next(iter(forms)) + (", …" if len(forms) > 1 else "")
    return name if group.folder == root else f"{group.folder.name}/{name}"


def _last_number(stem: str) -> str:
    """Return the last number of a name; the name itself where it has none."""
    numbers = re.findall(r"\d+", stem)
    return str(int(numbers[-1])) if numbers else stem


def _likeness(colour: Group, picture: npt.NDArray[np.generic], depth: Group, size: Size) -> float:
    """Return how well two groups go together, beside how many of their names do."""
    is_same_shape = has_shape_of((picture.shape[1], picture.shape[0]), size)
    is_said = colour.role is Role.COLOUR
    is_array = depth.files[0].suffix.lower() in ARRAY_ENDINGS
    words = len(re.findall(r"[a-z]+", depth.files[0].stem.lower()))
    return 8 * is_same_shape + 4 * is_said + 2 * (picture.ndim == 3) + 0.5 * is_array - 0.1 * words


def _depth_size(group: Group) -> Size | None:
    """Return (width, height) of a group's images where they are called depth and hold it."""
    if group.role is not Role.DEPTH:
        return None
    for path in group.files[:N_TRIED]:
        try:
            shape = read_raw_depth(path).shape
        except UnreadableFile:
            continue
        return shape[1], shape[0]
    return None


def _picture(group: Group) -> npt.NDArray[np.generic] | None:
    """Return one of a group's images where they may be colour: of 8 bits, and called no other."""
    if group.role not in (Role.COLOUR, Role.UNSAID):
        return None
    if group.files[0].suffix.lower() in ARRAY_ENDINGS:
        return None
    for path in group.files[:N_TRIED]:
        try:
            picture = decode_unchanged(path)
        except UnreadableFile:
            continue
        return picture if picture.dtype == np.uint8 else None
    return None
