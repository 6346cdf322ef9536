"""Tell which pose of a file is of which image: by name, by stamp, by number, or by order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from curiosight.datasets.pose_text import PoseRow
from curiosight.datasets.trajectory import Trajectory, parse_stamp
from curiosight.errors import DataError
from curiosight.frame import Pose
from curiosight.frame.rotations import quaternion_of

# A tracker may lose many frames, and a stamp with a fraction is not hit by chance; counted names
# are, so nearly all of theirs must be there.
MIN_SHARE_OF_STAMPS = 0.2
MIN_SHARE_OF_NUMBERS = 0.9
SAME_STAMP_NS = 1_000_000
NS_PER_SECOND = 10**9
# Seconds below this may as well be the numbers of frames.
MIN_CLOCK_NS = 1_000_000 * NS_PER_SECOND
# Seconds with a fraction, or whole milliseconds to nanoseconds.
CLOCK = re.compile(r"(?<!\d)(?:(\d{10})[._-](\d{6}|\d{9})|(\d{13}|\d{16}|\d{19}))(?!\d)")
COLOUR_SUFFIX = re.compile(r"[._-](?:rgb|colou?r|image)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Which row is of which image.

    rows: one an image; None = none is. how: in words. is_certain: not by counting alone.
    between: (4, 4) one an image, where poses are taken between two rows.
    """

    rows: Sequence[int | None]
    how: str
    is_certain: bool
    between: Sequence[Pose | None] | None = None


def match_poses(
    rows: Sequence[PoseRow], names: Sequence[str], stamps_ns: Sequence[int | None] | None = None
) -> Matched | None:
    """Return each image's row; None where nothing tells it. Arguments as in `find_poses`."""
    keys = [row.key for row in rows]
    if any(key is not None and stamp_or_none(key) is None for key in keys):
        return _by_name(keys, names)
    stamps = [stamp_in_name(plain_stem(name)) for name in names]
    if stamps_ns is not None:
        stamps = [
            of_name if own is None else own for own, of_name in zip(stamps_ns, stamps, strict=True)
        ]
    return _by_stamp(rows, stamps) or _by_number(keys, names) or _in_order(rows, names)


def plain_stem(name: str) -> str:
    """Return an image's stem without what only says that it is of colour.

    >>> plain_stem("frame-000012.color")
    'frame-000012'
    """
    return COLOUR_SUFFIX.sub("", name)


def stamp_or_none(text: str) -> int | None:
    """Return nanoseconds of a time, see `parse_stamp`; None where the text is none."""
    try:
        return parse_stamp(text)
    except ValueError:
        return None


def stamp_in_name(name: str) -> int | None:
    """Return nanoseconds of a name that is a time, or that holds one since 1970; None if none.

    >>> stamp_in_name("rgb_1305031229_528748") == stamp_in_name("1305031229.528748")
    True
    """
    inside = CLOCK.search(name)
    if inside is None or stamp_or_none(name) is not None:
        return stamp_or_none(name)
    seconds, fraction, whole = inside.groups()
    return stamp_or_none(whole or f"{seconds}.{fraction}")


def varying_numbers(names: Sequence[str]) -> list[list[int]]:
    """Return numbers in the names, in order of the names, that tell all of them apart.

    Those that stand last in the names come first.

    >>> varying_numbers(["cam0_frame7", "cam0_frame8"])
    [[7, 8]]
    """
    parts = [[int(digits) for digits in re.findall(r"\d+", name)] for name in names]
    if len({len(numbers) for numbers in parts}) != 1:
        return []
    columns = [list(column) for column in zip(*parts, strict=True)]
    return [column for column in reversed(columns) if len(set(column)) == len(names)]


def _by_name(keys: Sequence[str | None], names: Sequence[str]) -> Matched | None:
    row_of_name: dict[str, int] = {}
    for row, key in enumerate(keys):
        if key is not None:
            place = PurePosixPath(key.replace("\\", "/"))
            for name in (place.name, place.stem, plain_stem(place.stem)):
                row_of_name.setdefault(name, row)
    rows = [row_of_name.get(name, row_of_name.get(plain_stem(name))) for name in names]
    if len(names) - rows.count(None) < MIN_SHARE_OF_STAMPS * len(names):
        return None
    return Matched(rows, "by name", is_certain=True)


def _by_stamp(rows: Sequence[PoseRow], stamps: Sequence[int | None]) -> Matched | None:
    """Match times, the nearest within 1 ms, or else between two poses."""
    times = [-1 if row.key is None else stamp_or_none(row.key) or 0 for row in rows]
    known = [stamp for stamp in stamps if stamp is not None]
    if not known or -1 in times or not _is_clock(known):
        return None
    found = _nearest(times, stamps)
    n_found = len(stamps) - found.count(None)
    between = _between(rows, times, stamps)
    n_between = sum(pose is not None for pose in between)
    # Where most rows are an image's own, images between them are those that a tracker lost.
    is_own = 2 * n_found >= min(len(stamps), len(rows)) or n_found >= n_between
    if max(n_found, n_between) < MIN_SHARE_OF_STAMPS * len(stamps):
        return None
    if is_own:
        return Matched(found, "by stamp", is_certain=True)
    how = "by stamp, between the two poses next to it"
    return Matched([None] * len(stamps), how, is_certain=True, between=between)


def _nearest(times: Sequence[int], stamps: Sequence[int | None]) -> list[int | None]:
    order = np.argsort(np.array(times, np.int64), kind="stable")
    ordered = np.array(times, np.int64)[order]
    found: list[int | None] = []
    for stamp in stamps:
        if stamp is None:
            found.append(None)
            continue
        place = int(np.searchsorted(ordered, stamp))
        near = [p for p in (place - 1, place) if 0 <= p < len(times)]
        best = min(near, key=lambda p, stamp=stamp: abs(int(ordered[p]) - stamp))  # type: ignore[misc]
        found.append(int(order[best]) if abs(int(ordered[best]) - stamp) <= SAME_STAMP_NS else None)
    return found


def _between(
    rows: Sequence[PoseRow], times: Sequence[int], stamps: Sequence[int | None]
) -> list[Pose | None]:
    known = {time: row.pose for row, time in zip(rows, times, strict=True) if row.pose is not None}
    if not known:
        return [None] * len(stamps)
    ordered = sorted(known)
    matrices = np.array([known[time] for time in ordered])
    trajectory = Trajectory(
        np.array(ordered, np.int64),
        matrices[:, :3, 3],
        quaternion_of(matrices[:, :3, :3]),
    )
    # A stamp that is not known lies before any time, where no pose is.
    poses = trajectory.interpolated([-1 if stamp is None else stamp for stamp in stamps])
    return [None if s is None else pose for s, pose in zip(stamps, poses, strict=True)]


def _is_clock(stamps: Sequence[int]) -> bool:
    """Tell whether nanoseconds are times rather than the numbers of frames."""
    return max(stamps) >= MIN_CLOCK_NS or any(stamp % NS_PER_SECOND for stamp in stamps)


def _by_number(keys: Sequence[str | None], names: Sequence[str]) -> Matched | None:
    """Match the numbers in names to those that stand first in rows, or to the rows' places."""
    places = [row if key is None else _whole(key) for row, key in enumerate(keys)]
    if None in places or len(set(places)) != len(places):
        return None
    row_of_number = {place: row for row, place in enumerate(places)}
    has_keys = keys[0] is not None
    # Names that count from 1 meet nearly all rows that count from 0, each the wrong one. Rows
    # without numbers that are fewer than the images may have gaps anywhere.
    is_strict = len(keys) == len(names) or not has_keys
    share = 1.0 if is_strict else MIN_SHARE_OF_NUMBERS
    for numbers in varying_numbers(names):
        rows = [row_of_number.get(number) for number in numbers]
        if len(names) - rows.count(None) >= share * len(names):
            return Matched(rows, "by number", is_certain=False)
    return None


def _whole(key: str) -> int | None:
    number = float(key)
    return int(number) if number.is_integer() else None


def _in_order(rows: Sequence[PoseRow], names: Sequence[str]) -> Matched | None:
    if len(rows) != len(names):
        return None
    return Matched(range(len(rows)), "line by line", is_certain=False)


def match_stamps(
    path: Path, stamps_ns: Sequence[int], names: Sequence[str]
) -> tuple[Sequence[int | None], bool]:
    """Return each image's row of a trajectory, and whether that is by order alone.

    By the exact stamp in the image's name; raises `DataError` where neither that nor the count
    of rows tells which is whose.
    """
    row_of_stamp = {int(stamp): row for row, stamp in enumerate(stamps_ns)}
    stamps = [stamp_or_none(name) for name in names]
    rows = [None if stamp is None else row_of_stamp.get(stamp) for stamp in stamps]
    n_poses, n_matched = len(stamps_ns), len(names) - rows.count(None)
    share = MIN_SHARE_OF_STAMPS
    if all(name.isdecimal() for name in names):
        # Names that count from 1 meet nearly all stamps that count from 0, each the wrong one.
        share = 1.0 if n_poses == len(names) else MIN_SHARE_OF_NUMBERS
    if n_matched >= share * len(names):
        return rows, False
    if n_poses == len(names):
        return range(len(names)), None not in stamps
    raise DataError(
        path,
        f"holds {n_poses} poses for {len(names)} colour images, "
        f"and its stamps are the names of {n_matched or 'none'} of them",
        "give one line a frame, or name the images by their stamps",
    )
