"""Check that a world keeps the contract; for ours and for a user's own."""

from __future__ import annotations

import numpy as np

from curiosight.frame import Frame, Viewpoint, is_rigid
from curiosight.worlds.world import World


def check_world(world: World, *, n_captures: int = 3) -> None:
    """Raise ValueError where a world breaks the contract of `World`.

    It must offer views that differ in index, have sensible regions and rigid poses, say what
    the way to each costs, and show a frame taken from there. n_captures: views looked from.
    """
    views = world.views
    if not len(views):
        raise ValueError("views: expected at least one viewpoint, got none")
    if len({view.index for view in views}) != len(views):
        raise ValueError("views: expected an index of its own for each viewpoint")
    for view in views:
        if view.region < -1:
            raise ValueError(f"views: expected region -1 or more, got {view.region}")
        if view.T_world_camera is not None and not is_rigid(view.T_world_camera):
            raise ValueError(f"views: expected a rigid pose at viewpoint {view.index}")
    for number in np.linspace(0, len(views) - 1, n_captures).astype(int):
        cost = world.move_to(views[number])
        if not (np.isfinite(cost) and cost >= 0):
            raise ValueError(f"move_to: expected finite seconds, 0 or more, got {cost}")
        _check_frame(world.capture(), views[number])


def _check_frame(frame: object, view: Viewpoint) -> None:
    if not isinstance(frame, Frame):
        raise ValueError(f"capture: expected a Frame, got {type(frame).__name__}")
    poses = (frame.T_world_camera, view.T_world_camera)
    if poses[0] is not None and poses[1] is not None and not np.allclose(poses[0], poses[1]):
        raise ValueError(f"capture: expected viewpoint {view.index}'s pose in its frame")
