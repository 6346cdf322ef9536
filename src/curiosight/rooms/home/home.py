"""A home: its floor plan, and the rooms on it, drawn when they are asked for."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from curiosight.rooms.brief import Brief
from curiosight.rooms.drawn_views import Standing
from curiosight.rooms.free_space import FreeSpace, Place, Polygon
from curiosight.rooms.home.floor_plan import HomePlan, draw_home_plan, in_world
from curiosight.rooms.home.purposes import draw_moods, draw_purposes
from curiosight.rooms.home.settings import HomeSettings
from curiosight.rooms.palette import draw_palette, painted_with
from curiosight.rooms.room import LIGHTS, Room, draw_room, other_lights, stream
from curiosight.rooms.scene import Scene
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.shell import draw_shell
from curiosight.rooms.views import standing_in

# A home's streams of chance are others than those of the room of the same seed.
_HOME = 1_000_003
PLAN, CORRIDOR, ROOMS, UNLEARNABLE = range(4)


class Home:
    """The rooms of one home, numbered from 0; the corridor's number is the last.

    before: the same home before its change; None = this is how it is at first. `after` is the
    home after the change, None where it does not change.
    """

    def __init__(self, settings: HomeSettings, *, before: Home | None = None) -> None:
        self.settings = settings
        self._before = before
        rng = stream(settings, _HOME, PLAN)
        self.plan: HomePlan = draw_home_plan(settings.rooms, rng)
        purposes = draw_purposes(settings.rooms, rng, settings.empty)
        moods = draw_moods(settings.rooms, rng)
        self.briefs = tuple(
            Brief(lot.plan, lot.openings, purpose, mood, draw_palette(rng))
            for lot, purpose, mood in zip(self.plan.lots, purposes, moods, strict=True)
        )
        seeds = stream(settings, _HOME, ROOMS).integers(2**62, size=settings.rooms)
        self._seeds: list[int] = seeds.tolist()
        self._drawn: dict[int, Room] = {}
        self._standing: dict[int, list[Standing]] = {}
        self._lock = threading.RLock()
        changes = before is None and settings.change is not None
        self.after = Home(settings, before=self) if changes else None

    @property
    def n_rooms(self) -> int:
        """How many rooms there are beside the corridor, whose number this is."""
        return len(self.plan.lots)

    @property
    def unlearnable(self) -> int:
        """The number of the room that looks different at every look, where one is asked for."""
        # One of those in which there is most to learn.
        n_things = [brief.purpose.n_on_floor for brief in self.briefs]
        candidates = np.argsort(n_things, kind="stable")[-max(1, self.n_rooms // 2) :]
        rng = stream(self.settings, _HOME, UNLEARNABLE)
        return int(candidates[rng.integers(len(candidates))])

    def is_changed(self, number: int) -> bool:
        """Tell whether a room, or the corridor, is other than before the change."""
        change = self.settings.change
        if self._before is None or change is None:
            return False
        if number == self.n_rooms:
            return change.room is None and change.lights is not None
        return change.room in (None, number)

    def room_settings(self, number: int) -> RoomSettings:
        """Return what a room is drawn from."""
        settings, change = self.settings.of_room(self._seeds[number]), self.settings.change
        if change is None or not self.is_changed(number):
            return settings
        rearrange = settings.rearrange if change.rearrange is None else change.rearrange
        return replace(settings, rearrange=rearrange, lights=self._lights_seed)

    def room(self, number: int) -> Room:
        """Return a room in its own frame; where it lies say the lots of the plan."""
        with self._lock:
            if number not in self._drawn:
                self._drawn[number] = self._draw(number)
            return self._drawn[number]

    def forget(self, number: int) -> None:
        """Let go of a room's memory; it is drawn again when it is asked for."""
        with self._lock:
            self._drawn.pop(number, None)

    def standing(self, number: int) -> Sequence[Standing]:
        """Return what stands on the floor of a room, in the home's frame."""
        with self._lock:
            if number not in self._standing:
                pose, was_drawn = self.plan.lots[number].T_world_room, number in self._drawn
                self._standing[number] = [
                    replace(one, polygon=in_world(pose, one.polygon))
                    for one in standing_in(self.room(number))
                ]
                if self._before is not None and not was_drawn:
                    self.forget(number)  # it is long before it is seen
            return self._standing[number]

    def corridor(self) -> Scene:
        """Return what there is to see of the corridor, in the home's frame."""
        rng = stream(self.settings, _HOME, CORRIDOR)
        with painted_with(draw_palette(rng)):
            shell = draw_shell(self.plan.corridor, rng, self.plan.corridor_openings)
        seed, lights = self._lights_seed, shell.lights
        if seed is not None:
            lights = other_lights(lights, stream(self.settings, _HOME, LIGHTS, seed))
        return Scene(shell.parts, lights)

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

    @property
    def _lights_seed(self) -> int | None:
        """The seed of the lights of what changes; None = they are as first drawn."""
        change = self.settings.change if self._before is not None else None
        if change is None or change.lights is None:
            return self.settings.lights
        return change.lights

    def _draw(self, number: int) -> Room:
        settings = self.room_settings(number)
        if self._before is not None and number in self._before._drawn:
            room = self._before._drawn[number]
            return room.rearranged(settings.rearrange, lights=settings.lights)
        return draw_room(settings, self.briefs[number])
