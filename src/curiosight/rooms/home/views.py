"""The views of a home as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose
from curiosight.rooms.drawn_views import DrawnViews, Standing
from curiosight.rooms.free_space import FreeSpace, Polygon
from curiosight.rooms.home.home import Home
from curiosight.rooms.home.renderer import HomeRenderer, HomeRenderers
from curiosight.rooms.home.settings import N_ORBIT, N_VIEWS, HomeSettings
from curiosight.rooms.home.ways import draw_orbit, drive_around
from curiosight.rooms.renderer import Rendering
from curiosight.rooms.room import VIEWS, stream
from curiosight.rooms.settings import MAST_TILT
from curiosight.rooms.tours import HandHeld, tested_path
from curiosight.rooms.truth import instances_of, with_outlines
from curiosight.rooms.viewpoints import camera_pose, draw_poses
from curiosight.rooms.views import N_TEST_VIEWS as N_ROOM_TEST_VIEWS

# An exploration of a home is tested on so many in each room.
N_TEST_VIEWS = 12


class HomeViews(DrawnViews):
    """Look around in a home, room by room; a `Dataset`.

    Where the home changes, the first views show it as it was, and test views as it is then.

    poses: T_world_camera of each viewpoint; None = those that the home's seed gives.
    like: views of the same home, which is not drawn again.
    """

    name = "home"

    def __init__(
        self,
        settings: HomeSettings,
        poses: Sequence[Pose] | None = None,
        *,
        like: HomeViews | None = None,
    ) -> None:
        self._settings = settings
        self.home: Home = Home(settings) if like is None else like.home
        self._renderers: HomeRenderers = (
            HomeRenderers(self.home) if like is None else like._renderers
        )
        chosen = self._drawn_poses() if poses is None else poses
        prefix = "" if settings.split == "train" else f"{settings.split}-"
        ids = [f"{prefix}{index:06}" for index in range(len(chosen))]
        super().__init__(settings, chosen, ids)
        self.remarks = (_sentence(self.home),)

    @cached_property
    def free_space(self) -> FreeSpace | HandHeld:
        """Where the camera can be brought; where the home changes, before and after it."""
        if self._settings.path == "orbit":
            return HandHeld([*self.outlines, *(lot.door_area for lot in self.home.plan.lots)])
        return self._floor

    @cached_property
    def _floor(self) -> FreeSpace:
        """The floor that a robot can reach."""
        before, after = self.home.free_space, self.home.after
        if self._settings.change is None or after is None:
            return before
        if self._settings.split == "test":
            return after.free_space
        return before.shared_with(after.free_space)

    @property
    def outlines(self) -> Sequence[Polygon]:
        return self.home.outlines

    @property
    def footprints(self) -> Sequence[Standing]:
        home = self._home_after(0)
        return [one for number in range(home.n_rooms) for one in home.standing(number)]

    @property
    def n_before_change(self) -> int | None:
        change = self._settings.change
        return None if change is None or self._settings.split == "test" else change.look

    def place(self, index: int) -> int:
        """Return the number of the room that a view is in: truth, for scoring only."""
        return self.home.place_of(self.poses[index][:2, 3])

    def pose_at(self, x: float, y: float, heading_deg: float) -> Pose:
        """Return the pose of a camera at a place of the home.

        Raises ValueError for a place where a robot cannot stand.
        """
        self.free_space.check(np.array([x, y]))
        settings = self._settings
        assert settings.height is not None
        tilt = MAST_TILT if settings.tilt is None else settings.tilt
        return camera_pose(
            x, y, heading_deg, height=settings.height, tilt_deg=tilt, roll_deg=settings.mount
        )

    def at_places(self, places: Sequence[tuple[float, float, float]]) -> HomeViews:
        return HomeViews(self._settings, [self.pose_at(*place) for place in places], like=self)

    def test_views(self, n_views: int, *, is_after: bool = False) -> HomeViews:
        change = self._settings.change if is_after else None
        path = tested_path(self._settings.path)
        settings = replace(self._settings, split="test", views=n_views, change=change, path=path)
        return HomeViews(settings, like=self)

    def own_test_views(self, *, is_after: bool = False) -> HomeViews:
        n_views = N_ROOM_TEST_VIEWS if self._settings.path == "orbit" else N_TEST_VIEWS
        return self.test_views(n_views, is_after=is_after)

    def let_go(self) -> None:
        super().let_go()
        self._renderers = HomeRenderers(self.home)
        for home in filter(None, (self.home, self.home.after)):
            for number in range(home.n_rooms):
                home.forget(number)

    def is_place_of(self, other: DrawnViews) -> bool:
        return isinstance(other, HomeViews) and self.home is other.home

    def _render(
        self, camera: Camera, T_world_camera: Pose, rng: np.random.Generator, n_looks: int
    ) -> tuple[Rendering, npt.NDArray[np.uint8]]:
        renderer = self._renderer_after(n_looks)
        # Of its own: how many draws it takes depends on what is in view.
        disguise = rng.spawn(1)[0] if self._settings.unlearnable else None
        rendering = renderer.render(camera, T_world_camera, disguise)
        return rendering, with_outlines(renderer.greys(rendering.ids))

    def instance_truth(self, index: int) -> npt.NDArray[np.int32]:
        ids = self.look(index).ids
        return instances_of(ids, self._renderer_after(index).greys(ids))

    @property
    def is_drawn_anew(self) -> bool:
        return self._settings.unlearnable

    def _is_after(self, n_looks: int) -> bool:
        """Tell whether the home has changed after so many looks."""
        if self._settings.change is None:
            return False
        return self._settings.split == "test" or n_looks >= self._settings.change.look

    def _home_after(self, n_looks: int) -> Home:
        return self.home.after if self._is_after(n_looks) and self.home.after else self.home

    def _renderer_after(self, n_looks: int) -> HomeRenderer:
        return self._renderers.of(is_after=self._is_after(n_looks))

    def _drawn_poses(self) -> list[Pose]:
        settings = self._settings
        assert settings.height is not None
        held = {"height": settings.height, "roll_deg": settings.mount}
        if settings.path == "orbit":
            n_views = N_ORBIT if settings.views is None else settings.views
            return draw_orbit(self._home_after(0), n_views, self._stream(VIEWS), **held)
        assert settings.tilt is not None
        held["tilt_deg"] = settings.tilt
        if settings.path == "drive":
            places = drive_around(
                self.home.plan, self._floor.routable(), self._stream(VIEWS), settings.views
            )
            return [camera_pose(*place, **held) for place in places]
        n_views = N_VIEWS if settings.views is None else settings.views
        poses: list[Pose] = []
        for number, lot in enumerate(self.home.plan.lots):
            free, rng = self._floor.within(lot.outline), self._stream(VIEWS, number)
            poses += draw_poses(n_views, free, lot.outline, rng, **held)
        return poses

    def _stream(self, number: int, *more: int) -> np.random.Generator:
        """Return a source of chance that differs between splits and arrangements too."""
        settings, rearrange = self._settings, self._settings.rearrange
        is_test = settings.split == "test"
        if is_test and settings.change is not None and settings.change.rearrange is not None:
            rearrange = settings.change.rearrange
        arrangement = 0 if rearrange is None else rearrange + 1
        return stream(settings, number, is_test, arrangement, *more)


def _sentence(home: Home) -> str:
    width, depth = np.ptp(np.concatenate(home.outlines), axis=0)
    rooms = f"{home.n_rooms} room" + "s" * (home.n_rooms > 1)
    return f"a home of {rooms} and a corridor, {width:.1f} x {depth:.1f} m, drawn by seed"
