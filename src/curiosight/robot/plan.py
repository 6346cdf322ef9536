"""The map from above: where each region's views stand, and the walls where they are known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Viewpoint

Floats = npt.NDArray[np.floating]
# Of a region so many views are drawn.
MOST_POINTS = 150


class Plan:
    """Look at views from above. up: see `seen_from_above`; outlines: (n, 2) metres each."""

    def __init__(
        self,
        views: Sequence[Viewpoint],
        names: Sequence[str],
        *,
        up: npt.ArrayLike | None = None,
        outlines: Sequence[Floats] = (),
    ) -> None:
        self._views = views
        self._place_of = {view.index: place for place, view in enumerate(views)}
        self._above = seen_from_above([view.T_world_camera for view in views], up)
        self._names = names
        self._outlines = outlines

    def content(self) -> dict[str, Any]:
        """Return it JSON-able, metres."""
        regions = np.array([view.region for view in self._views])
        is_placed = np.isfinite(self._above.positions).all(axis=1)
        found = []
        for region in sorted(set(regions[regions >= 0].tolist())):
            places = self._above.positions[(regions == region) & is_placed]
            step = max(1, -(-len(places) // MOST_POINTS))
            points = np.round(places[::step], 3).tolist()
            found.append({"id": region, "name": self._names[region], "points": points})
        outlines = [np.round(outline, 3).tolist() for outline in self._outlines]
        return {"outlines": outlines, "regions": found}

    def robot(self, index: int | None) -> list[float] | None:
        """Return x, y (metres) and heading (radians) at a view; None where it is not known."""
        place = None if index is None else self._place_of.get(index)
        if place is None or not np.isfinite(self._above.positions[place]).all():
            return None
        x, y = self._above.positions[place].tolist()
        return [round(x, 3), round(y, 3), round(float(self._above.headings[place]), 4)]
