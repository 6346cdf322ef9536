"""The views of a room as a recording: rendered when asked for, with the truth of every pixel."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Frame, Pose
from curiosight.rooms.colour_sensor import develop, draw_look
from curiosight.rooms.free_space import FreeSpace
from curiosight.rooms.overhead import HEIGHTS, TILTS_DEG, OverTables, looking_at
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.room import LOOKS, VIEWS, Room, stream
from curiosight.rooms.sensing import Readings, sense
from curiosight.rooms.truth import draw_instances, draw_truth
from curiosight.rooms.viewpoints import camera_pose, draw_poses

# A Kinect's colour camera, depth registered to it.
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
_N_KEPT = 16


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What a camera in a room gets to see, and what is really there.

    truth: (H, W) uint8, 255 salient, 0 not salient, 125 ignored.
    true_depth: (H, W) float32 metres along z. ids: (H, W) int32 number of the part.
    readings: what the depth sensor gives, of its own size; `frame.depth` is made of it.
    """

    frame: Frame
    truth: npt.NDArray[np.uint8]
    true_depth: Depth
    ids: npt.NDArray[np.int32]
    readings: Readings


class RoomViews:
    """Look around in a room; a `Dataset`.

    poses: T_room_camera of each viewpoint; None = those that the room's seed gives.
    """

    name = "room"
    has_depth = True
    camera = CAMERA

    def __init__(self, room: Room, poses: Sequence[Pose] | None = None) -> None:
        settings = room.settings
        self.room = room
        self.path = str(settings)
        self.remarks = (_sentence(room),)
        self.free_space: FreeSpace | OverTables = (
            room.free_space() if settings.over is None else OverTables(room)
        )
        self.poses = tuple(self._drawn_poses() if poses is None else poses)
        digits = max(3, len(str(len(self.poses) - 1)))
        self.ids = tuple(f"{settings.split}-{index:0{digits}}" for index in range(len(self.poses)))
        self._looks: OrderedDict[int, Look] = OrderedDict()
        self._lock = threading.Lock()

    def _drawn_poses(self) -> list[Pose]:
        settings, rng, space = self.room.settings, self._stream(VIEWS), self.free_space
        height, tilt, roll = settings.height, settings.tilt, settings.mount
        if isinstance(space, OverTables):
            return space.draw_poses(
                settings.views, rng, height=height, tilt_deg=tilt, roll_deg=roll
            )
        assert height is not None
        assert tilt is not None
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
        assert tilt is not None
        return camera_pose(x, y, heading_deg, height=height, tilt_deg=tilt, roll_deg=roll)

    def _stream(self, number: int, *more: int) -> np.random.Generator:
        """Return a source of chance that differs between splits and arrangements too."""
        settings = self.room.settings
        arrangement = 0 if settings.rearrange is None else settings.rearrange + 1
        return stream(settings, number, settings.split == "test", arrangement, *more)

    def test_views(self, n_views: int) -> RoomViews:
        """Return other viewpoints of the same room, for testing."""
        settings = replace(self.room.settings, split="test", views=n_views)
        views = RoomViews(replace(self.room, settings=settings))
        views.renderer = self.renderer
        return views

    @cached_property
    def renderer(self) -> Renderer:
        """What draws the room; its light takes some seconds."""
        return Renderer(self.room.scene, n_threads=2)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        return self.look(index).frame

    def has_ground_truth(self, index: int) -> bool:
        return True

    def ground_truth(self, index: int) -> npt.NDArray[np.uint8]:
        return self.look(index).truth

    def true_depth(self, index: int) -> Depth:
        """Return the real distances of a view, (H, W) metres along z."""
        return self.look(index).true_depth

    def instance_truth(self, index: int) -> npt.NDArray[np.int32]:
        """Return a view's objects, (H, W) int32: a number each, 0 = none, -1 = ignored."""
        return draw_instances(self.look(index).ids, self.room.scene.parts)

    def look(self, index: int) -> Look:
        """Return a view and its truth; the last few are kept."""
        index = range(len(self))[index]
        with self._lock:
            if index not in self._looks:
                rng = self.looks_stream(index)
                self._looks[index] = self.look_from(self.poses[index], self.ids[index], rng)
            self._looks.move_to_end(index)
            while len(self._looks) > _N_KEPT:
                self._looks.popitem(last=False)
            return self._looks[index]

    def looks_stream(self, index: int) -> np.random.Generator:
        """Return the chance in a view's exposure and noise."""
        return self._stream(LOOKS, index)

    def look_from(
        self, T_room_camera: Pose, id: str, rng: np.random.Generator, *, camera: Camera = CAMERA
    ) -> Look:
        """Look from anywhere; chance is in the exposure and in the sensors' noise."""
        settings = self.room.settings
        rendering = self.renderer.render(camera, T_room_camera)
        rgb = develop(rendering.radiance, draw_look(rng, blur=settings.blur), rng)
        readings = sense(settings.sensor, rendering, camera, rng)
        return Look(
            Frame(id, rgb, readings.registered(camera), camera, T_room_camera),
            draw_truth(rendering.ids, self.room.scene.parts),
            rendering.depth,
            rendering.ids,
            readings,
        )


def _sentence(room: Room) -> str:
    low, high = room.plan.outline.min(0), room.plan.outline.max(0)
    width, depth = high - low
    return f"a room of {width:.1f} x {depth:.1f} m with {len(room.things)} things, drawn by seed"
