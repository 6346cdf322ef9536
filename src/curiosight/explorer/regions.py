"""Divide a recording's views into regions: by pose (sec. III-B), by time, or as a file says."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from curiosight.datasets.listing import natural_key
from curiosight.errors import DataError
from curiosight.explorer.from_above import seen_from_above
from curiosight.explorer.grouping import MetresFrom, group_by_ways
from curiosight.frame import Pose

PositionSplit = Literal["median", "midpoint"]
OrientationSplit = Literal["count", "sector"]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_PAPER_GRID = "pose:2x2x4"
_N_SLICES = 5  # the paper's number for a recording without poses
# Rooms are told apart only where there are some.
MIN_ROOMS = 3
_AUTO = r"auto(?::(\d{1,3}))?"
_FORMS = "auto, auto:4, pose, pose:3x2x4, time:5, or the path of a file of `id,region` lines"


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """The region of every view, none of them empty.

    of_view: (n_views,) int64 region numbers; -1 = in no region (a view without a pose, say).
    names: what to call regions 0, 1, ... in logs and figures.
    kind: the spec that makes them: "pose:2x2x4", "time:5", "file".
    """

    of_view: Ints
    names: tuple[str, ...]
    kind: str

    @property
    def n_regions(self) -> int:
        return len(self.names)


def make_regions(
    spec: str | None,
    poses: Sequence[Pose | None],
    ids: Sequence[str],
    *,
    metres: MetresFrom | None = None,
    position_split: PositionSplit = "median",
    orientation_split: OrientationSplit = "count",
    up: npt.ArrayLike | None = None,
) -> Regions:
    """Make the regions that `spec` asks for.

    spec: "pose" (2x2 positions x 4 orientations), "pose:3x2x4", "time:5", "auto" (see
        `way_regions`) or "auto:4" (each of those by as many headings), or the path of a file;
        None = "auto" where the ways are known and there are rooms to tell apart, else "pose"
        where at least half of the views have a pose and there are more of them than regions,
        else "time:5", with fewer slices where there are fewer frames.
    metres: of the ways between views: (n_views, n_views), or whatever gives its rows one by
        one; None = not known.
    position_split, orientation_split, up: see `pose_regions`.

    Raises ValueError for any other spec, or poses asked for where there are none; DataError
    for a bad file.
    """
    n_posed = sum(pose is not None for pose in poses)
    if spec is None and metres is not None and n_posed == len(poses):
        found = way_regions(metres)
        if found.n_regions >= MIN_ROOMS:
            return found
    if match := re.fullmatch(_AUTO, spec or ""):
        if metres is None or n_posed < len(poses):
            raise ValueError("regions: expected poses of all views for `auto`; use time:5")
        found = way_regions(metres)
        if not match[1]:
            return found
        above = seen_from_above(poses, up)
        sectors = _orientation_sectors(
            above.headings, found.of_view, int(match[1]), orientation_split
        )
        pairs = zip(found.of_view, sectors, strict=True)
        return _number([f"room {room} heading {sector}" for room, sector in pairs], spec or "")
    if spec is None:
        has_poses = 2 * n_posed >= len(poses) and n_posed > 2 * 2 * 4
        spec = "pose" if has_poses else f"time:{max(1, min(_N_SLICES, len(ids)))}"
    if spec == "pose":
        spec = _PAPER_GRID
    if match := re.fullmatch(r"pose:(\d{1,3})x(\d{1,3})x(\d{1,3})", spec):
        if not n_posed:
            raise ValueError("regions: expected poses for `pose`, got none; use time:5")
        n_x, n_y, n_orientations = (int(number) for number in match.groups())
        return pose_regions(
            poses,
            positions=(n_x, n_y),
            orientations=n_orientations,
            position_split=position_split,
            orientation_split=orientation_split,
            up=up,
        )
    if match := re.fullmatch(r"time:(\d+)", spec):
        return time_regions(len(ids), int(match[1]))
    if Path(spec).is_file():
        return file_regions(spec, ids)
    raise ValueError(f"regions: expected {_FORMS}; got {spec!r}, which is no file either")


def pose_regions(
    poses: Sequence[Pose | None],
    *,
    positions: tuple[int, int] = (2, 2),
    orientations: int = 4,
    position_split: PositionSplit = "median",
    orientation_split: OrientationSplit = "count",
    up: npt.ArrayLike | None = None,
) -> Regions:
    """Divide views by where the camera stands, then by where it looks (sec. III-B).

    The paper: 4 quadrants of the map, 4 orientation clusters inside each. A view without a
    pose is in no region; regions without views are left out, so there may be fewer.

    positions: cells along the two horizontal axes.
    position_split: "median" = equal counts, along the first axis and then inside each strip
        along the second; "midpoint" = equal cells of the trajectory's bounding box.
    orientation_split: "count" = equal counts of headings, the circle cut open at the largest
        gap; "sector" = equal angles, the first centred on the first horizontal axis.
    up: (3,) world vector against gravity; None = the cameras' mean up axis.
    """
    if min(*positions, orientations) < 1:
        grid = f"{positions[0]}x{positions[1]}x{orientations}"
        raise ValueError(f"positions, orientations: expected 1 or more of each, got {grid}")
    if position_split not in ("median", "midpoint"):
        raise ValueError(f"position_split: expected median or midpoint, got {position_split!r}")
    if orientation_split not in ("count", "sector"):
        raise ValueError(f"orientation_split: expected count or sector, got {orientation_split!r}")
    posed = np.flatnonzero([pose is not None for pose in poses])
    if not len(posed):
        raise ValueError("poses: expected at least one known pose, got none")
    above = seen_from_above(poses, up)
    cells = _position_cells(above.positions[posed], positions, position_split)
    sectors = _orientation_sectors(above.headings[posed], cells, orientations, orientation_split)
    labels = [""] * len(poses)
    for view, cell, sector in zip(posed, cells, sectors, strict=True):
        x, y = divmod(int(cell), positions[1])
        labels[view] = f"x{x} y{y} heading {sector}"
    return _number(labels, f"pose:{positions[0]}x{positions[1]}x{orientations}")


def needs_ways(spec: str | None) -> bool:
    """Tell whether regions of that spec are made of the ways between views."""
    return spec is None or re.fullmatch(_AUTO, spec) is not None


def way_regions(metres: MetresFrom) -> Regions:
    """Put views together that are a short way apart, see `group_by_ways`."""
    of_view = group_by_ways(metres)
    names = tuple(f"room {number}" for number in range(int(of_view.max()) + 1))
    return Regions(of_view, names, "auto")


def time_regions(n_views: int, n_regions: int) -> Regions:
    """Divide a recording into slices of equal length, in order (sec. III-B)."""
    if not 1 <= n_regions <= n_views:
        raise ValueError(
            f"regions: expected time:1 to time:{n_views} for {n_views} frames, got time:{n_regions}"
        )
    of_view = np.arange(n_views) * n_regions // n_views
    names = tuple(f"slice {number}" for number in range(n_regions))
    return Regions(of_view, names, f"time:{n_regions}")


def file_regions(path: Path | str, ids: Sequence[str]) -> Regions:
    """Read regions from lines `id,region`; frames that are not listed are in no region.

    A region is any word: regions are numbered in the natural order of their names. Blank
    lines and what follows a # are skipped. Raises DataError with the line's number for a
    malformed line, an unknown id, or an id that is given two regions.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        remedy = "write lines `id,region` in UTF-8"
        raise DataError(path, f"cannot be read as text ({error})", remedy) from error
    view_of_id = {id_: view for view, id_ in enumerate(ids)}
    labels = [""] * len(ids)
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        id_, comma, region = (part.strip() for part in text.rpartition(","))
        if not (id_ and comma and region):
            raise DataError(path, f"line {number} is {line!r}", "write `id,region`")
        if id_ not in view_of_id:
            remedy = f"use the recording's ids, such as {ids[0]}" if ids else "it has no frames"
            raise DataError(path, f"line {number} names the unknown frame {id_!r}", remedy)
        if labels[view_of_id[id_]] not in ("", region):
            raise DataError(path, f"line {number} gives {id_!r} two regions", "keep one of them")
        labels[view_of_id[id_]] = region
    if not any(labels):
        raise DataError(path, "no frame is in any region", "write lines `id,region`")
    return _number(labels, "file")


def _position_cells(positions: Floats, n_cells: tuple[int, int], split: PositionSplit) -> Ints:
    """Return the cell of each (n, 2) position, row-major: x * n_y + y."""
    if split == "midpoint":
        x, y = (_equal_widths(positions[:, axis], n_cells[axis]) for axis in (0, 1))
        return x * n_cells[1] + y
    x = _equal_counts(positions[:, 0], n_cells[0])
    y = np.empty_like(x)
    for strip in np.unique(x):
        inside = x == strip
        y[inside] = _equal_counts(positions[inside, 1], n_cells[1])
    return x * n_cells[1] + y


def _orientation_sectors(
    headings: Floats, cells: Ints, n_sectors: int, split: OrientationSplit
) -> Ints:
    """Return the cluster of each heading (radians) among those of its position cell."""
    width = 2 * np.pi / n_sectors
    if split == "sector":
        return np.floor((headings + width / 2) / width).astype(np.int64) % n_sectors
    sectors = np.empty_like(cells)
    for cell in np.unique(cells):
        inside = cells == cell
        sectors[inside] = _equal_counts(_cut_at_largest_gap(headings[inside]), n_sectors)
    return sectors


def _cut_at_largest_gap(angles: Floats) -> Floats:
    """Return angles (radians) counted from the first one after the widest empty arc."""
    turned = angles % (2 * np.pi)
    around = np.sort(turned)
    gaps = np.diff(around, prepend=around[-1] - 2 * np.pi)
    counted: Floats = (turned - around[np.argmax(gaps)]) % (2 * np.pi)
    return counted


def _equal_counts(values: Floats, n_parts: int) -> Ints:
    """Cut values at their quantiles; equal values stay together."""
    cuts = np.quantile(values, np.arange(1, n_parts) / n_parts)
    return np.searchsorted(cuts, values, side="right")


def _equal_widths(values: Floats, n_parts: int) -> Ints:
    """Cut the range of the values into parts of equal width."""
    cuts = np.linspace(values.min(), values.max(), n_parts + 1)[1:-1]
    return np.searchsorted(cuts, values, side="right")


def _number(labels: Sequence[str], kind: str) -> Regions:
    """Number the regions that occur, in natural order of their labels; "" = no region."""
    names = sorted({label for label in labels if label}, key=natural_key)
    number = {name: region for region, name in enumerate(names)} | {"": -1}
    return Regions(np.array([number[label] for label in labels], np.int64), tuple(names), kind)
