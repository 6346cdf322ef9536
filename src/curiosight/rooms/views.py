"""The views of a room as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import count, islice

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose
from curiosight.rooms.drawn_views import CAMERA, DrawnViews, Look, Standing
from curiosight.rooms.free_space import FreeSpace, Polygon
from curiosight.rooms.overhead import HEIGHTS, TILTS_DEG, OverTables, looking_at
from curiosight.rooms.renderer import Renderer, Rendering
from curiosight.rooms.room import VIEWS, Room, stream
from curiosight.rooms.settings import MAST_TILT
from curiosight.rooms.tours import HandHeld, drive, find_orbit, tested_path
from curiosight.rooms.truth import draw_instances, draw_truth
from curiosight.rooms.viewpoints import camera_pose, draw_poses

__all__ = ["CAMERA", "Look", "RoomViews"]

# An exploration of a room is tested on so many.
N_TEST_VIEWS = 40


class RoomViews(DrawnViews):
    """Look around in a room; a `Dataset`.

    poses: T_room_camera of each viewpoint; None = those that the room's seed gives.
    """

    def __init__(self, room: Room, poses: Sequence[Pose] | None = None) -> None:
        settings = room.settings
        self.room = room
        self._free_space = _space_of(room)
        chosen = self._drawn_poses() if poses is None else poses
        digits = max(3, len(str(len(chosen) - 1)))
        ids = [f"{settings.split}-{index:0{digits}}" for index in range(len(chosen))]
        super().__init__(settings, chosen, ids)
        self.remarks = (_sentence(room),)

    @property
    def free_space(self) -> FreeSpace | OverTables | HandHeld:
        return self._free_space

    @property
    def outlines(self) -> Sequence[Polygon]:
        return (self.room.plan.outline,)

    @property
    def footprints(self) -> Sequence[Standing]:
        return standing_in(self.room)

    def _drawn_poses(self) -> list[Pose]:
        settings, rng, space = self.room.settings, self._stream(VIEWS), self._free_space
        height, tilt, roll = settings.height, settings.tilt, settings.mount
        if isinstance(space, OverTables):
            return space.draw_poses(
                settings.views, rng, height=height, tilt_deg=tilt, roll_deg=roll
            )
        assert height is not None
        if isinstance(space, HandHeld):
            orbit = find_orbit(self.room, height)
            if orbit is None:
                raise ValueError(f"path: expected a room with a table, got {settings}")
            return orbit.poses(settings.views, rng, height=height, roll_deg=roll)
        assert tilt is not None
        if settings.path == "drive":
            space = space.routable()
            stops = (space.draw_places(1, rng)[0] for _ in count())
            return [
                camera_pose(*place, height=height, tilt_deg=tilt, roll_deg=roll)
                for place in islice(drive(space, stops), settings.views)
            ]
        outline = self.room.plan.outline
        return draw_poses(
            settings.views, space, outline, rng, height=height, tilt_deg=tilt, roll_deg=roll
        )

    def pose_at(self, x: float, y: float, heading_deg: float) -> Pose:
        """Return the pose of a camera at a place, or, over tables, of one that looks at it.

        Raises ValueError for a place where a robot cannot stand, or that is on no table.
        """
        settings, space, place = self.room.settings, self.free_space, np.array([x, y])
        height, tilt, roll = settings.height, settings.tilt, settings.mount
        if isinstance(space, OverTables):
            height = sum(HEIGHTS) / 2 if height is None else height
            tilt = sum(TILTS_DEG) / 2 if tilt is None else tilt
            target = space.target(place)
            return looking_at(target, heading_deg, height=height, tilt_deg=tilt, roll_deg=roll)
        space.check(place)
        assert height is not None
        tilt = MAST_TILT if tilt is None else tilt
        return camera_pose(x, y, heading_deg, height=height, tilt_deg=tilt, roll_deg=roll)

    def _stream(self, number: int, *more: int) -> np.random.Generator:
        """Return a source of chance that differs between splits and arrangements too."""
        settings = self.room.settings
        arrangement = 0 if settings.rearrange is None else settings.rearrange + 1
        return stream(settings, number, settings.split == "test", arrangement, *more)

    def test_views(self, n_views: int) -> RoomViews:
        path = tested_path(self.room.settings.path)
        settings = replace(self.room.settings, split="test", views=n_views, path=path)
        views = RoomViews(replace(self.room, settings=settings))
        views.renderer = self.renderer
        return views

    @cached_property
    def renderer(self) -> Renderer:
        """What draws the room; its light takes some seconds."""
        return Renderer(self.room.scene, n_threads=2)

    def let_go(self) -> None:
        super().let_go()
        vars(self).pop("renderer", None)

    def own_test_views(self, *, is_after: bool = False) -> RoomViews:
        return self.test_views(N_TEST_VIEWS)

    def is_place_of(self, other: DrawnViews) -> bool:
        return isinstance(other, RoomViews) and self.room.shell is other.room.shell

    def instance_truth(self, index: int) -> npt.NDArray[np.int32]:
        return draw_instances(self.look(index).ids, self.room.scene.parts)

    def _render(
        self, camera: Camera, T_world_camera: Pose, rng: np.random.Generator, n_looks: int
    ) -> tuple[Rendering, npt.NDArray[np.uint8]]:
        rendering = self.renderer.render(camera, T_world_camera)
        return rendering, draw_truth(rendering.ids, self.room.scene.parts)

    def at_places(self, places: Sequence[tuple[float, float, float]]) -> RoomViews:
        return RoomViews(self.room, [self.pose_at(*place) for place in places])


def _space_of(room: Room) -> FreeSpace | OverTables | HandHeld:
    if room.settings.over is not None:
        return OverTables(room)
    if room.settings.path == "orbit":
        return HandHeld([room.plan.outline])
    return room.free_space()


def standing_in(room: Room) -> list[Standing]:
    """Return what stands on the floor of a room, furniture first."""
    furniture = [
        Standing(placed.furniture.name, placed.footprint, is_object=False)
        for placed in room.furniture
    ]
    return furniture + [
        Standing(thing.kind.name, thing.footprint(), is_object=True)
        for thing in room.things
        if thing.is_on_floor
    ]


def _sentence(room: Room) -> str:
    low, high = room.plan.outline.min(0), room.plan.outline.max(0)
    width, depth = high - low
    return f"a room of {width:.1f} x {depth:.1f} m with {len(room.things)} things, drawn by seed"
