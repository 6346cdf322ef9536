"""The views of a home as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose
from curiosight.rooms.drawn_views import CAMERA, DrawnViews, Look, Standing, take_look
from curiosight.rooms.free_space import FreeSpace, Polygon
from curiosight.rooms.home.home import Home
from curiosight.rooms.home.settings import HomeSettings
from curiosight.rooms.room import LOOKS, VIEWS, stream
from curiosight.rooms.truth import instances_of, with_outlines
from curiosight.rooms.viewpoints import camera_pose, draw_poses

# An exploration of a home is tested on so many in each room.
N_TEST_VIEWS = 12


class HomeViews(DrawnViews):
    """Look around in a home, room by room; a `Dataset`.

    poses: T_world_camera of each viewpoint; None = those that the home's seed gives.
    home: already drawn from the same settings but for views and split; None = it is drawn.
    """

    name = "home"

    def __init__(
        self,
        settings: HomeSettings,
        poses: Sequence[Pose] | None = None,
        *,
        home: Home | None = None,
    ) -> None:
        self._settings = settings
        self.home = Home(settings) if home is None else home
        chosen = self._drawn_poses() if poses is None else poses
        prefix = "" if settings.split == "train" else f"{settings.split}-"
        ids = [f"{prefix}{index:06}" for index in range(len(chosen))]
        super().__init__(settings, chosen, ids)
        self.remarks = (_sentence(self.home),)

    @property
    def free_space(self) -> FreeSpace:
        return self.home.free_space

    @property
    def outlines(self) -> Sequence[Polygon]:
        return self.home.outlines

    @property
    def footprints(self) -> Sequence[Standing]:
        numbers = range(self.home.n_rooms)
        return [one for number in numbers for one in self.home.standing(number)]

    def place(self, index: int) -> int:
        """Return the number of the room that a view is in: truth, for scoring only."""
        return self.home.place_of(self.poses[index][:2, 3])

    def pose_at(self, x: float, y: float, heading_deg: float) -> Pose:
        """Return the pose of a camera at a place of the home.

        Raises ValueError for a place where a robot cannot stand.
        """
        self.free_space.check(np.array([x, y]))
        settings = self._settings
        height, tilt, roll = settings.height, settings.tilt, settings.mount
        return camera_pose(x, y, heading_deg, height=height, tilt_deg=tilt, roll_deg=roll)

    def at_places(self, places: Sequence[tuple[float, float, float]]) -> HomeViews:
        poses = [self.pose_at(*place) for place in places]
        return HomeViews(self._settings, poses, home=self.home)

    def test_views(self, n_views: int) -> HomeViews:
        settings = replace(self._settings, split="test", views=n_views)
        return HomeViews(settings, home=self.home)

    def own_test_views(self) -> HomeViews:
        return self.test_views(N_TEST_VIEWS)

    def is_place_of(self, other: DrawnViews) -> bool:
        return isinstance(other, HomeViews) and self.home is other.home

    def looks_stream(self, index: int) -> np.random.Generator:
        return self._stream(LOOKS, index)

    def look_from(
        self,
        T_world_camera: Pose,
        id: str,
        rng: np.random.Generator,
        *,
        camera: Camera = CAMERA,
        n_looks: int = 0,
    ) -> Look:
        rendering = self.home.render(camera, T_world_camera)
        truth = with_outlines(self.home.greys(rendering.ids))
        return take_look(rendering, truth, self.settings, (id, camera, T_world_camera), rng)

    def instance_truth(self, index: int) -> npt.NDArray[np.int32]:
        ids = self.look(index).ids
        return instances_of(ids, self.home.greys(ids))

    def _drawn_poses(self) -> list[Pose]:
        settings, poses = self._settings, []
        for number, lot in enumerate(self.home.plan.lots):
            poses += draw_poses(
                settings.views,
                self.home.free_space.within(lot.outline),
                lot.outline,
                self._stream(VIEWS, number),
                height=settings.height,
                tilt_deg=settings.tilt,
                roll_deg=settings.mount,
            )
        return poses

    def _stream(self, number: int, *more: int) -> np.random.Generator:
        """Return a source of chance that differs between splits and arrangements too."""
        settings = self._settings
        arrangement = 0 if settings.rearrange is None else settings.rearrange + 1
        return stream(settings, number, settings.split == "test", arrangement, *more)


def _sentence(home: Home) -> str:
    width, depth = np.ptp(np.concatenate(home.outlines), axis=0)
    rooms = f"{home.n_rooms} room" + "s" * (home.n_rooms > 1)
    return f"a home of {rooms} and a corridor, {width:.1f} x {depth:.1f} m, drawn by seed"
