"""Pictures of a home: its rooms are lit when they are first seen, and looked at through doors.

Each room is a scene of its own, and so is the corridor. A ray that meets the plane of a doorway
goes on in the scene behind it; light does not.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose
from curiosight.rooms.disguise import Disguise
from curiosight.rooms.home.home import Home
from curiosight.rooms.mesh import Floats
from curiosight.rooms.renderer import Renderer, Rendering, Seen, take_picture
from curiosight.rooms.room import stream
from curiosight.rooms.shading import Rays
from curiosight.rooms.shell import DOORWAY
from curiosight.rooms.truth import greys_of

# The number of a part of a home is its number in its room, and so much for each room before.
MAX_PARTS = 4096
N_THREADS = 2
_DISGUISE = 1_000_033  # a random stream of its own

RendererOf = Callable[[int], Renderer]


@dataclass(frozen=True, slots=True, eq=False)
class LitRoom:
    """A room, or the corridor, ready to be looked at.

    greys: (MAX_PARTS,) of its parts in the truth, by number. doors: to which room each of its
    doorways leads, by the number of the doorway's part.
    """

    renderer: Renderer
    greys: npt.NDArray[np.uint8]
    doors: dict[int, int]


class HomeRenderer:
    """Draws a home from any place in it.

    before: of the home before its change, for the rooms that stay as they were.
    """

    def __init__(self, home: Home, *, before: HomeRenderer | None = None) -> None:
        self._home = home
        self._before = before
        self._lit: dict[int, LitRoom] = {}
        self._lock = threading.RLock()
        self._disguise: Disguise | None = None

    def render(
        self, camera: Camera, T_world_camera: Pose, disguise: np.random.Generator | None = None
    ) -> Rendering:
        """Draw what a camera sees, of the next rooms too; for ids see `MAX_PARTS`.

        disguise: the chance in the looks of the room that nobody can learn; None = it looks as
        it is.
        """
        here = self._home.place_of(T_world_camera[:2, 3])
        renderer_of = self._renderers(disguise)

        def see(rays: Rays) -> Seen:
            return self._see(here, rays, None, renderer_of)

        return take_picture(see, renderer_of(here).each, camera, T_world_camera)

    def greys(self, ids: npt.NDArray[np.int32]) -> npt.NDArray[np.uint8]:
        """Return (H, W) the truth of the parts in a picture, up to the outlines."""
        rooms, parts = np.divmod(ids, MAX_PARTS)
        greys = np.zeros(ids.shape, np.uint8)
        for number in np.flatnonzero(np.bincount(rooms.ravel())).tolist():
            greys = np.where(rooms == number, self.lit(number).greys[parts], greys)
        return greys

    def lit(self, number: int) -> LitRoom:
        """Return a room, or the corridor, with its light worked out, now if it was not yet."""
        if self._before is not None and not self._home.is_changed(number):
            return self._before.lit(number)
        with self._lock:
            if number not in self._lit:
                self._lit[number] = self._light(number)
            return self._lit[number]

    def forget(self, after: Home) -> None:
        """Let go of the rooms that are other in the home after its change."""
        with self._lock:
            for number in [number for number in self._lit if after.is_changed(number)]:
                del self._lit[number]

    def _see(self, number: int, rays: Rays, start: Floats | None, renderer_of: RendererOf) -> Seen:
        """Return what rays meet that begin in a room; those through a doorway go on behind it."""
        seen = renderer_of(number).see(rays, start)
        ids = seen.ids + np.int32(number * MAX_PARTS)
        columns = (seen.radiance, seen.depth, ids, seen.cosine, seen.infrared)
        for door, beyond in self.lit(number).doors.items():
            through = np.flatnonzero(seen.ids == door)
            if len(through):
                farther = rays._replace(directions=np.ascontiguousarray(rays.directions[through]))
                behind = self._see(beyond, farther, seen.depth[through], renderer_of)
                for column, other in zip(columns, behind, strict=True):
                    column[through] = other
        return seen._replace(ids=ids)

    def _renderers(self, disguise: np.random.Generator | None) -> RendererOf:
        """Return what gives each room's renderer for one look."""
        if disguise is None:
            return lambda number: self.lit(number).renderer
        unlearnable = self._home.unlearnable
        disguised: dict[int, Renderer] = {}

        def renderer_of(number: int) -> Renderer:
            if number != unlearnable:
                return self.lit(number).renderer
            with self._lock:
                if number not in disguised:
                    if self._disguise is None:
                        self._disguise = Disguise(stream(self._home.settings, _DISGUISE))
                    renderer = self.lit(number).renderer
                    disguised[number] = renderer.disguised(self._disguise, disguise)
                return disguised[number]

        return renderer_of

    def _light(self, number: int) -> LitRoom:
        home = self._home
        if number == home.n_rooms:
            scene, beyond = home.corridor(), list(range(home.n_rooms))
        else:
            pose = home.plan.lots[number].T_world_room
            scene, beyond = home.room(number).scene.moved(pose), [home.n_rooms]
            home.forget(number)  # the renderer keeps what it needs
        greys = np.zeros(MAX_PARTS, np.uint8)
        greys[1 : len(scene.parts) + 1] = greys_of(scene.parts)
        ids = [id for id, part in enumerate(scene.parts, 1) if part.name == DOORWAY]
        renderer = Renderer(scene, n_threads=N_THREADS)
        return LitRoom(renderer, greys, dict(zip(ids, beyond, strict=True)))


class HomeRenderers:
    """Draws a home before and after its change, when it lets go of the rooms as they were."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._before = HomeRenderer(home)
        self._after: HomeRenderer | None = None
        self._lock = threading.Lock()

    def of(self, *, is_after: bool) -> HomeRenderer:
        """Return what draws the home as it is at first, or after its change."""
        if not is_after or self._home.after is None:
            return self._before
        with self._lock:
            if self._after is None:
                self._before.forget(self._home.after)
                self._after = HomeRenderer(self._home.after, before=self._before)
            return self._after
