"""The entries of a catalogue seen from above."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue import Entry
from curiosight.explorer.from_above import horizontal_axes
from curiosight.viewing.report.markup import NOTHING, Markup, element, join, number

Floats = npt.NDArray[np.floating[Any]]
# Metres of floor around the outermost entries.
MARGIN = 0.5


def plan_of(entries: Sequence[Entry]) -> Markup:
    """Return a map of the entries: each as large as it is, and for those that moved the way."""
    up = entries[0].T_world_centre[:3, 2]
    axes = horizontal_axes(up).T
    shown = [_Shown(entry, axes) for entry in entries]
    every = np.concatenate([one.reach for one in shown])
    low, high = every.min(0) - MARGIN, every.max(0) + MARGIN
    width, height = high - low
    # SVG counts downwards.
    view = f"{number(low[0])} {number(-high[1])} {number(width)} {number(height)}"
    inside = element("svg", {"viewBox": view}, *[one.way() for one in shown], *map(_link, shown))
    text = {"class": "measured"}
    metres = f"{number(width, 1)} × {number(height, 1)} m, seen from above"
    ratio = f"--ratio:{number(width / height)};aspect-ratio:{number(width)}/{number(height)}"
    kind = {"class": "map things", "role": "img", "aria-label": metres, "style": ratio}
    return join((element("div", kind, inside), element("p", text, metres)))


class _Shown:
    """An entry as it lies on the map. reach: (n, 2) metres, all that must be in view."""

    def __init__(self, entry: Entry, axes: Floats) -> None:
        self.entry = entry
        self.centre = axes @ entry.T_world_centre[:3, 3]
        sides = axes @ entry.T_world_centre[:3, :2] * (np.array(entry.size_m[:2]) / 2)
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        self.corners: Floats = self.centre + signs @ sides.T
        before = entry.T_world_before
        self.before = None if before is None else axes @ before[:3, 3]
        more = [] if self.before is None else [self.before[None]]
        self.reach: Floats = np.concatenate([self.corners, *more])

    def way(self) -> Markup:
        if self.before is None:
            return NOTHING
        return element("path", {"class": f"way {self.entry.change}", "d": self._line()})

    def _line(self) -> str:
        assert self.before is not None
        return _path(np.stack([self.before, self.centre]))


def _link(shown: _Shown) -> Markup:
    """Return an entry's outline, which leads to its card."""
    entry = shown.entry
    title = element("title", {}, f"{entry.id}, {entry.change}")
    outline = element("path", {"class": f"thing-{entry.change}", "d": _path(shown.corners) + "Z"})
    kind = {"href": f"#entry-{entry.id}", "class": f"spot {entry.change}"}
    return element("a", kind, title, outline)


def _path(points: Floats) -> str:
    return "M" + "L".join(f"{number(x, 3)} {number(-y, 3)}" for x, y in points)
