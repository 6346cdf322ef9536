"""A day of a home as episodes: morning, evening, rearranged, and a room that is new."""

from __future__ import annotations

import numpy as np

from curiosight.config import Config
from curiosight.experiments.continual import Episode
from curiosight.rooms import HomeViews
from curiosight.worlds.sources import open_source

# Of the seeds of light and arrangement any would do.
LIGHTS, REARRANGE = 1, 1


def day_of(source: str, config: Config) -> list[Episode]:
    """Return the episodes of a home of two rooms or more.

    The last room stays closed until the end. In the evening the others are lit otherwise; then all
    things are moved, in that light. Raises as `open_source`, and ValueError for what is no such
    home or is lit or arranged by its own options.
    """
    morning = open_source(source, reading=config.reading)
    if not isinstance(morning, HomeViews) or morning.home.n_rooms < 2:
        raise ValueError(f"sources: expected one home of several rooms, got {source!r}")
    if any(option in source for option in ("lights=", "rearrange=", "change=", "split=")):
        found = f"got {source!r}"
        raise ValueError(f"sources: expected a home that changes by none of its options, {found}")
    evening = open_source(f"{source},lights={LIGHTS}", reading=config.reading)
    moved = open_source(f"{source},lights={LIGHTS},rearrange={REARRANGE}", reading=config.reading)
    assert isinstance(evening, HomeViews)
    assert isinstance(moved, HomeViews)
    new = morning.home.n_rooms - 1
    return [
        _episode("morning", morning, range(new), ""),
        _episode("evening", evening, range(new), "light"),
        _episode("rearranged", moved, range(new), "things"),
        _episode("a new room", moved, range(new, new + 1), ""),
    ]


def _episode(name: str, views: HomeViews, rooms: range, change: str) -> Episode:
    tests = views.own_test_views()
    return Episode(name, views, _in(views, rooms), tests, _in(tests, rooms), change)


def _in(views: HomeViews, rooms: range) -> list[int]:
    """Return the views of some rooms."""
    return np.flatnonzero([views.place(index) in rooms for index in range(len(views))]).tolist()
