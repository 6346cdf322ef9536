"""Check that a world keeps the contract; for ours and for a user's own."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np

from curiosight.datasets.check import check_depth_unit, check_readings
from curiosight.frame import Frame, Viewpoint, is_rigid
from curiosight.worlds.travel import travel
from curiosight.worlds.world import World


def check_world(
    world: World,
    *,
    n_captures: int = 3,
    max_metres_off: float = 0.05,
    max_degrees_off: float = 3.0,
) -> None:
    """Raise ValueError where a world breaks the contract of `World`.

    It must offer views that differ in index, have sensible regions and rigid poses, say what
    the way to each costs, and show a frame taken from there, with depth in metres and NaN where
    there is no reading. A frame of bad data, with a `problem`, is no breach.

    n_captures: views looked from, spread over all. max_metres_off, max_degrees_off: how far a
    frame's pose may be from its viewpoint's; a robot never stands quite where it was sent.
    """
    _require(n_captures >= 1, "n_captures", "1 or more", n_captures)
    for member in ("views", "move_to", "capture"):
        _require(hasattr(world, member), member, "a member of the world", "none")
    views = world.views
    _check_views(views)
    frames = []
    for number in np.linspace(0, len(views) - 1, n_captures).round().astype(int).tolist():
        cost: object = world.move_to(views[number])
        is_number = isinstance(cost, Real) and not isinstance(cost, bool)
        is_cost = is_number and 0 <= cost < np.inf  # type: ignore[operator]
        _require(is_cost, "move_to", "finite seconds, 0 or more", repr(cost))
        frame: object = world.capture()
        if not isinstance(frame, Frame):
            raise ValueError(f"capture: expected a Frame, got {type(frame).__name__}")
        _check_pose(frame, views[number], max_metres_off, max_degrees_off)
        check_readings(frame)
        frames.append(frame)
    check_depth_unit(frames)


def _require(is_kept: bool, what: str, expected: str, got: object) -> None:
    if not is_kept:
        raise ValueError(f"{what}: expected {expected}, got {got}")


def _check_views(views: Sequence[Viewpoint]) -> None:
    is_sequence = hasattr(views, "__len__") and hasattr(views, "__getitem__")
    _require(is_sequence, "views", "a sequence of viewpoints", type(views).__name__)
    _require(len(views) > 0, "views", "at least one viewpoint", "none")
    seen: set[int] = set()
    for view in views:
        _require(isinstance(view, Viewpoint), "views", "Viewpoints", type(view).__name__)
        index, region = view.index, view.region
        _require(isinstance(index, Integral), "views", "whole numbers as index", repr(index))
        _require(index not in seen, "views", "an index of its own for each", f"{index} twice")
        seen.add(index)
        is_region = isinstance(region, Integral) and region >= -1
        _require(is_region, "views", "region -1 or more", repr(region))
        expected = f"None or a rigid pose at viewpoint {index}"
        _require(_is_pose(view), "views", expected, view.T_world_camera)


def _is_pose(view: Viewpoint) -> bool:
    if view.T_world_camera is None:
        return True
    try:
        return is_rigid(np.asarray(view.T_world_camera, np.float64))
    except (TypeError, ValueError):  # no numbers
        return False


def _check_pose(frame: Frame, view: Viewpoint, max_metres: float, max_degrees: float) -> None:
    if frame.T_world_camera is None or view.T_world_camera is None:
        return
    what = f"capture of {frame.id}"
    there = np.asarray(view.T_world_camera, np.float64)
    here = np.asarray(frame.T_world_camera, np.float64)
    _require(is_rigid(here), what, "a rigid pose", here)
    metres, degrees = travel(there, here)
    expected = f"viewpoint {view.index}'s pose within {max_metres:g} m and {max_degrees:g} degrees"
    is_there = metres <= max_metres and degrees <= max_degrees
    _require(is_there, what, expected, f"{metres:.3g} m and {degrees:.3g} degrees off")
