"""The room from above: walls and furniture, the views in their regions' colours, the path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from curiosight.viewing.report.content import Footprint, RoomMap
from curiosight.viewing.report.markup import NOTHING, Markup, element, number, path_of, thinned

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MAX_VIEWS = 1500  # of those that were not looked at; more would be one line
_HALF_VIEW = np.deg2rad(28.5)  # of a Kinect; only a picture of where it looked
_GRIDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0)
_REACH = 0.11  # of a wedge, as a share of the map's size
_DECIMALS = 3


def floor_plan(room: RoomMap, region_names: Sequence[str]) -> Markup:
    """Return the map as SVG, in metres with y upwards; empty where no view has a pose."""
    if not np.isfinite(room.views.positions).any():
        return NOTHING
    corners = _corners(room)
    size = float(np.ptp(corners, axis=0).max()) or 1.0
    reach = _REACH * size
    # Walls hold nearly every wedge; without them the outermost may open outwards.
    margin = (0.2 if room.outlines else 1.1) * reach
    low, high = corners.min(0) - margin, corners.max(0) + margin
    width, height = high - low
    drawing = element(
        "svg",
        {"viewBox": " ".join(_metres(v) for v in (low[0], -high[1], width, height))},
        _grid(low, high, grid_of(room)),
        *_walls_and_things(room),
        *_views(room, reach),
    )
    look = f"aspect-ratio:{number(width / height, 3)};--ratio:{number(width / height, 3)}"
    names = [_name_of(footprint, low, high) for footprint in room.footprints]
    n_looked = len(set(room.visited))
    described = f"The room from above: {n_looked} views in {len(region_names)} regions."
    label = {"class": "map", "role": "img", "aria-label": described, "style": look}
    return element("svg", label, drawing, *names)


def grid_of(room: RoomMap) -> float:
    """Return the side of the map's squares in metres: at most eight of them across."""
    size = float(np.ptp(_corners(room), axis=0).max())
    return next((side for side in _GRIDS if size / side <= 8), _GRIDS[-1])


def _corners(room: RoomMap) -> Floats:
    """Return all that the map must hold, (n, 2) metres."""
    positions = room.views.positions
    polygons = [footprint.polygon for footprint in room.footprints]
    return np.concatenate([positions[np.isfinite(positions[:, 0])], *room.outlines, *polygons])


def _grid(low: Floats, high: Floats, side: float) -> Markup:
    left, bottom, right, top = map(_metres, (low[0], -low[1], high[0], -high[1]))
    across = (_metres(x) for x in _multiples(side, low[0], high[0]))
    upwards = (_metres(-y) for y in _multiples(side, low[1], high[1]))
    lines = [f"M{x} {bottom}V{top}" for x in across] + [f"M{left} {y}H{right}" for y in upwards]
    return element("path", {"class": "grid", "d": "".join(lines)})


def _multiples(side: float, low: float, high: float) -> Floats:
    """Return the multiples of a length between two others."""
    return np.arange(np.ceil(low / side), np.floor(high / side) + 1) * side


def _walls_and_things(room: RoomMap) -> Iterator[Markup]:
    for outline in room.outlines:
        yield element("path", {"class": "walls", "d": _path(outline) + "z"})
    for footprint in room.footprints:
        kind = "object" if footprint.is_object else "furniture"
        shape = {"class": kind, "d": _path(footprint.polygon) + "z"}
        yield element("path", shape, element("title", {}, footprint.name))


def _views(room: RoomMap, reach: float) -> Iterator[Markup]:
    """Yield ticks for all views, the way, wedges for those looked at, and dots on top."""
    positions, headings = room.views.positions, room.views.headings
    is_known = np.isfinite(headings)
    for region in np.unique(room.region_of_view):
        inside = np.flatnonzero((room.region_of_view == region) & is_known)
        ticks = thinned(inside, max(1, MAX_VIEWS * len(inside) // len(headings)))
        yield _ticks(f"view r{region}", positions[ticks], headings[ticks], 0.35 * reach)
    looks = np.array(room.visited, np.int64)
    looks = looks[is_known[looks]]
    if len(looks):
        yield element("path", {"class": "way", "d": _path(thinned(positions[looks], MAX_VIEWS))})
    looked_at, counts = np.unique(looks, return_counts=True)
    order = thinned(np.argsort(counts, kind="stable"), MAX_VIEWS)
    for view in looked_at[order]:
        wedge = _wedge(positions[view], headings[view], reach)
        yield element("path", {"class": f"wedge r{room.region_of_view[view]}", "d": wedge})
    for view, count in zip(looked_at[order], counts[order], strict=True):
        yield _dot(positions[view], room.region_of_view[view], 0.07 * reach * np.sqrt(count))


def _ticks(kind: str, positions: Floats, headings: Floats, length: float) -> Markup:
    ends = positions + length * _directions(headings)
    lines = [_path(np.stack(pair)) for pair in zip(positions, ends, strict=True)]
    return element("path", {"class": kind, "d": "".join(lines)})


def _wedge(position: Floats, heading: float, length: float) -> str:
    left, right = position + length * _directions(heading + np.array([_HALF_VIEW, -_HALF_VIEW]))
    radius, end = _metres(length), f"{_metres(right[0])} {_metres(-right[1])}"
    return f"{_path(np.stack([position, left]))}A{radius} {radius} 0 0 1 {end}z"


def _dot(position: Floats, region: int, radius: float) -> Markup:
    centre = {"cx": _metres(position[0]), "cy": _metres(-position[1])}
    return element("circle", {"class": f"dot r{region}", **centre, "r": _metres(radius)})


def _name_of(footprint: Footprint, low: Floats, high: Floats) -> Markup:
    """Write the name of a piece of furniture in its middle; objects are too small for one."""
    if footprint.is_object:
        return NOTHING
    x, y = 100 * (footprint.polygon.mean(axis=0) - low) / (high - low)
    place = {"class": "thing", "x": f"{number(x)}%", "y": f"{number(100 - y)}%", "dy": "0.35em"}
    return element("text", place, footprint.name)


def _directions(headings: Floats) -> Floats:
    directions: Floats = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    return directions


def _path(points: npt.NDArray[np.floating]) -> str:
    return path_of(points * [1, -1], _DECIMALS)


def _metres(value: float) -> str:
    return number(value, _DECIMALS)
