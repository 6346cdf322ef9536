"""A home: its rooms, drawn and lit when they are first seen, and looked at through the doors."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Pose
from curiosight.rooms.brief import Brief
from curiosight.rooms.drawn_views import Standing
from curiosight.rooms.free_space import FreeSpace, Place, Polygon
from curiosight.rooms.home.floor_plan import HomePlan, draw_home_plan, in_world
from curiosight.rooms.home.purposes import draw_moods, draw_purposes
from curiosight.rooms.home.settings import HomeSettings
from curiosight.rooms.palette import draw_palette, painted_with
from curiosight.rooms.renderer import Renderer, Rendering, Seen, take_picture
from curiosight.rooms.room import Room, draw_room, stream
from curiosight.rooms.scene import Scene
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.shading import Rays
from curiosight.rooms.shell import DOORWAY, Shell, draw_shell
from curiosight.rooms.truth import greys_of
from curiosight.rooms.views import standing_in

# Numbers of the random streams of a home.
PLAN, CORRIDOR, ROOMS = range(3)
# The number of a part of a home is its number in its room, and so much for each room before.
MAX_PARTS = 4096
N_THREADS = 2


@dataclass(frozen=True, slots=True, eq=False)
class LitRoom:
    """A room, or the corridor, ready to be looked at.

    greys: (MAX_PARTS,) of its parts in the truth, by number. doors: to which room each of its
    doorways leads, by the number of the doorway's part.
    """

    renderer: Renderer
    greys: npt.NDArray[np.uint8]
    doors: dict[int, int]


class Home:
    """The rooms of one home, numbered from 0; the corridor's number is the last.

    Rooms are drawn when they are asked for, and lit when they are first seen.
    """

    def __init__(self, settings: HomeSettings) -> None:
        self.settings = settings
        rng = stream(settings, PLAN, _HOME)
        self.plan: HomePlan = draw_home_plan(settings.rooms, rng)
        purposes, moods = draw_purposes(settings.rooms, rng), draw_moods(settings.rooms, rng)
        self._briefs = [
            Brief(lot.plan, lot.openings, purpose, mood, draw_palette(rng))
            for lot, purpose, mood in zip(self.plan.lots, purposes, moods, strict=True)
        ]
        self._seeds = [
            int(seed)
            for seed in stream(settings, ROOMS, _HOME).integers(2**62, size=settings.rooms)
        ]
        self._drawn: dict[int, Room] = {}
        self._standing: dict[int, list[Standing]] = {}
        self._lit: dict[int, LitRoom] = {}
        self._lock = threading.RLock()

    @property
    def n_rooms(self) -> int:
        """How many rooms there are beside the corridor, whose number this is."""
        return len(self.plan.lots)

    def room_settings(self, number: int) -> RoomSettings:
        """Return what a room is drawn from."""
        return self.settings.of_room(self._seeds[number], number)

    def room(self, number: int) -> Room:
        """Return a room in its own frame; where it lies say the lots of the plan."""
        with self._lock:
            if number not in self._drawn:
                room = draw_room(self.room_settings(number), self._briefs[number])
                self._drawn[number] = room
                self._standing[number] = [
                    replace(one, polygon=in_world(self.plan.lots[number].T_world_room, one.polygon))
                    for one in standing_in(room)
                ]
            return self._drawn[number]

    def standing(self, number: int) -> Sequence[Standing]:
        """Return what stands on the floor of a room, in the home's frame."""
        with self._lock:
            if number not in self._standing:
                self.room(number)
            return self._standing[number]

    @property
    def outlines(self) -> tuple[Polygon, ...]:
        """The walls of each room and of the corridor, seen from above, in the home's frame."""
        return (*(lot.outline for lot in self.plan.lots), self.plan.corridor.outline)

    @cached_property
    def free_space(self) -> FreeSpace:
        """The floor that a robot can reach, through the doors."""
        corridor, lots = self.plan.corridor.outline, self.plan.lots
        more = [polygon for lot in lots for polygon in (lot.outline, lot.door_area)]
        numbers = range(self.n_rooms)
        obstacles = [one.polygon for number in numbers for one in self.standing(number)]
        return FreeSpace(corridor, obstacles, more=more)

    def place_of(self, place: Place) -> int:
        """Return the number of the room where (x, y) is; raises ValueError outside of the home."""
        for number, lot in enumerate(self.plan.lots):
            if lot.contains(place):
                return number
        if not self.plan.corridor.contains(np.asarray(place)):
            x, y = place
            raise ValueError(f"viewpoint: expected a place in the home, got ({x:.2f}, {y:.2f})")
        return self.n_rooms

    def render(self, camera: Camera, T_world_camera: Pose) -> Rendering:
        """Draw what a camera sees, of the next rooms too; for ids see `MAX_PARTS`."""
        here = self.place_of(T_world_camera[:2, 3])

        def see(rays: Rays) -> Seen:
            return self._see(here, rays, None)

        return take_picture(see, self._lit_room(here).renderer.each, camera, T_world_camera)

    def greys(self, ids: npt.NDArray[np.int32]) -> npt.NDArray[np.uint8]:
        """Return (H, W) the truth of the parts in a picture, up to the outlines."""
        greys = np.empty(ids.shape, np.uint8)
        for number in np.unique(ids // MAX_PARTS).tolist():
            is_here = ids // MAX_PARTS == number
            greys[is_here] = self._lit_room(number).greys[ids[is_here] % MAX_PARTS]
        return greys

    def _see(self, number: int, rays: Rays, start: npt.NDArray[np.float32] | None) -> Seen:
        """Return what rays meet that begin in a room; those through a doorway go on behind it."""
        lit = self._lit_room(number)
        seen = lit.renderer.see(rays, start)
        ids = seen.ids + np.int32(number * MAX_PARTS)
        for door, beyond in lit.doors.items():
            through = np.flatnonzero(seen.ids == door)
            if not len(through):
                continue
            farther = rays._replace(directions=np.ascontiguousarray(rays.directions[through]))
            behind = self._see(beyond, farther, seen.depth[through])
            for column, other in zip(
                (seen.radiance, seen.depth, ids, seen.cosine, seen.infrared), behind, strict=True
            ):
                column[through] = other
        return seen._replace(ids=ids)

    def _lit_room(self, number: int) -> LitRoom:
        with self._lock:
            if number not in self._lit:
                self._lit[number] = self._light(number)
            return self._lit[number]

    def _light(self, number: int) -> LitRoom:
        if number == self.n_rooms:
            shell = self._corridor()
            scene, beyond = Scene(shell.parts, shell.lights), list(range(self.n_rooms))
        else:
            pose = self.plan.lots[number].T_world_room
            scene, beyond = self.room(number).scene.moved(pose), [self.n_rooms]
            del self._drawn[number]  # its textures are in the renderer, too
        greys = np.zeros(MAX_PARTS, np.uint8)
        greys[1 : len(scene.parts) + 1] = greys_of(scene.parts)
        ids = [id for id, part in enumerate(scene.parts, 1) if part.name == DOORWAY]
        renderer = Renderer(scene, n_threads=N_THREADS)
        return LitRoom(renderer, greys, dict(zip(ids, beyond, strict=True)))

    def _corridor(self) -> Shell:
        rng = stream(self.settings, CORRIDOR, _HOME)
        with painted_with(draw_palette(rng)):
            return draw_shell(self.plan.corridor, rng, self.plan.corridor_openings)


_HOME = 1_000_003
