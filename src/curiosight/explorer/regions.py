"""Divide a recording's views into regions: by pose (sec. III-B), by time, or as a file says."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from curiosight.explorer.division import Regions as Regions
from curiosight.explorer.division import numbered
from curiosight.explorer.from_above import seen_from_above
from curiosight.explorer.grouping import MetresFrom, group_by_ways
from curiosight.explorer.region_files import file_regions
from curiosight.frame import Pose

PositionSplit = Literal["median", "midpoint"]
OrientationSplit = Literal["count", "sector"]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_PAPER_GRID = "pose:2x2x4"
_N_SLICES = 5  # the paper's number for a recording without poses
# Rooms are told apart only where there are some.
MIN_ROOMS = 3
_ROOMS = r"(auto|growing|places)(?::([1-9]\d{0,2}))?"
_FORMS = (
    "auto, auto:4, growing, places, places:4, pose, pose:3x2x4, time:5, or the path of a file "
    "of `id,region` lines or the authors' region map"
)


def make_regions(
    spec: str | None,
    poses: Sequence[Pose | None],
    ids: Sequence[str],
    *,
    metres: MetresFrom | None = None,
    places: Ints | None = None,
    position_split: PositionSplit = "median",
    orientation_split: OrientationSplit = "count",
    up: npt.ArrayLike | None = None,
) -> Regions:
    """Make the regions that `spec` asks for.

    spec: "pose" (2x2 positions x 4 orientations), "pose:3x2x4", "time:5", "auto" (see
        `way_regions`) or "auto:4" (each of those by as many headings), "places" or "places:4"
        likewise, "growing" = "auto" to begin with (see `Living`), or the path of a file
        (`file_regions`); None = "auto" where the ways are known and there are rooms to tell
        apart, else "pose" where at least half of the views have a pose and there are more of
        them than regions, else "time:5", with fewer slices where there are fewer frames.
    metres: of the ways between views: (n_views, n_views), or whatever gives its rows one by
        one; None = not known.
    places: (n_views,) the learner's place of each view, -1 = in none; None = not known.
    position_split, orientation_split, up: see `pose_regions`.

    Raises ValueError for any other spec, or poses asked for where there are none; DataError
    for a bad file.
    """
    n_posed = sum(pose is not None for pose in poses)
    if spec is None and metres is not None and n_posed == len(poses):
        found = way_regions(metres)
        if found.n_regions >= MIN_ROOMS:
            return found
    if match := re.fullmatch(_ROOMS, spec or ""):
        kind, n_headings = match[1], match[2]
        if n_posed < len(poses) and (kind != "places" or n_headings):
            raise ValueError(f"regions: expected poses of all views for `{spec}`; use time:5")
        found = _rooms(kind, metres, places)
        if not n_headings:
            return found
        headings = seen_from_above(poses, up).headings
        return _by_headings(found, headings, int(n_headings), orientation_split, spec or "")
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
    return numbered(labels, f"pose:{positions[0]}x{positions[1]}x{orientations}")


def needs_ways(spec: str | None) -> bool:
    """Tell whether regions of that spec are made of the ways between views."""
    return spec is None or _kind(spec) in ("auto", "growing")


def needs_places(spec: str | None) -> bool:
    """Tell whether regions of that spec are the learner's places."""
    return _kind(spec or "") == "places"


def is_living(spec: str | None) -> bool:
    """Tell whether regions of that spec change during a run, see `Living`."""
    return _kind(spec or "") == "growing"


def _kind(spec: str) -> str | None:
    match = re.fullmatch(_ROOMS, spec)
    return match[1] if match else None


def _rooms(kind: str, metres: MetresFrom | None, places: Ints | None) -> Regions:
    """Return regions that are told apart by more than a grid."""
    if kind != "places":
        if metres is None:
            raise ValueError(f"regions: expected the ways between views for `{kind}`; use time:5")
        return replace(way_regions(metres), kind=kind)
    if places is None or not (places >= 0).any():
        raise ValueError("regions: expected views with a place for `places`; use time:5")
    return numbered([f"place {place}" if place >= 0 else "" for place in places], kind)


def _by_headings(
    regions: Regions, headings: Floats, n_headings: int, split: OrientationSplit, kind: str
) -> Regions:
    """Divide each region by where views look; headings: (n_views,) radians."""
    sectors = _orientation_sectors(headings, regions.of_view, n_headings, split)
    labels = [
        f"{regions.names[region]} heading {sector}" if region >= 0 else ""
        for region, sector in zip(regions.of_view, sectors, strict=True)
    ]
    return numbered(labels, kind)


def way_regions(metres: MetresFrom) -> Regions:
    """Put views together that are a short way apart, see `group_by_ways`."""
    of_view = group_by_ways(metres)
    names = tuple(f"area {number}" for number in range(int(of_view.max()) + 1))
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
