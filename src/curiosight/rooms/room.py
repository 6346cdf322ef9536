"""A room: its walls and furniture, the things in it, and where a robot can stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from curiosight.rooms.arrangement import Arrangement, Surface, Thing, rearranged
from curiosight.rooms.brief import Brief
from curiosight.rooms.free_space import FreeSpace, Polygon
from curiosight.rooms.furniture import Placed, furnish
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.palette import EVERYTHING, painted_with
from curiosight.rooms.plan import FloorPlan, draw_plan
from curiosight.rooms.scene import Light, Role, Scene
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.shell import Shell, draw_shell
from curiosight.rooms.sweet_home import Entry, SweetHomeLibrary
from curiosight.rooms.things import KINDS, Kind
from curiosight.rooms.things.kind import FLOOR, TABLE
from curiosight.rooms.truth import role_of_furniture, role_of_thing

N_ON_FLOOR = 16
# Share of the floor that a robot reaches in the fullest room of a home.
LEAST_REACH = 0.5
MAX_TABLE_SIZE = 0.5  # metres; what is larger stands on the floor
# Numbers of the random streams that a seed is split into.
PLAN, THINGS, REARRANGEMENT, LIGHTS, VIEWS, LOOKS, VISITS = range(7)


@dataclass(frozen=True, eq=False)
class Room:
    """A room to look around in; metres, z up, the floor at z = 0.

    first_things: where the things stood when the room was drawn. things: where they stand.
    brief: what it was asked to be; None = as its seed has it.
    """

    settings: RoomSettings
    plan: FloorPlan
    shell: Shell
    furniture: tuple[Placed, ...]
    first_things: tuple[Thing, ...]
    things: tuple[Thing, ...]
    brief: Brief | None = None

    @cached_property
    def scene(self) -> Scene:
        """All that a camera can see."""
        if self.settings.over is None:
            seen_as = self.settings.scene
            roles = [role_of_furniture(placed, self.things, seen_as) for placed in self.furniture]
        else:
            # An arm works on its tables, with things or without.
            seen_as, roles = "table", len(self.furniture) * [Role.SUPPORT]
        both = zip(self.furniture, roles, strict=True)
        furniture = (part for placed, role in both for part in placed.parts(role))
        things = (thing.part(role_of_thing(thing, seen_as)) for thing in self.things)
        return Scene((*self.shell.parts, *furniture, *things), self._lights())

    @property
    def footprints(self) -> tuple[Polygon, ...]:
        """What stands on the floor, seen from above: (4, 2) corners each."""
        on_floor = [thing.footprint() for thing in self.things if thing.is_on_floor]
        return (*(placed.footprint for placed in self.furniture), *on_floor)

    def free_space(self) -> FreeSpace:
        """Return where a robot can stand."""
        return FreeSpace(self.plan.outline, self.footprints)

    def rearranged(self, seed: int | None, *, lights: int | None = None) -> Room:
        """Return the room after its things were moved, some taken away and others brought.

        seed: of the new arrangement; None = the first one. lights: seed of other lights; None =
        the first ones.
        """
        settings = replace(self.settings, rearrange=seed, lights=lights)
        if seed is None:
            return replace(self, settings=settings, things=self.first_things)
        rng = stream(settings, REARRANGEMENT, seed)
        least_reach = 0.0 if self.brief is None else LEAST_REACH
        empty = _places(self.plan, self.shell, self.furniture, least_reach)
        with painted_with(EVERYTHING if self.brief is None else self.brief.palette):
            things = rearranged(self.first_things, empty, self._kinds, rng)
        return replace(self, settings=settings, things=things)

    @property
    def _kinds(self) -> Sequence[Kind]:
        """The kinds of things that are brought in."""
        if self.brief is None:
            return _kinds(self.settings)
        return (*self.brief.purpose.things, *_kinds(self.settings)[len(KINDS) :])

    def _lights(self) -> tuple[Light, ...]:
        """Return the lights, or others."""
        first, seed = self.shell.lights, self.settings.lights
        if seed is None:
            return first
        return other_lights(first, stream(self.settings, LIGHTS, seed))


def draw_room(settings: RoomSettings, brief: Brief | None = None) -> Room:
    """Draw the room of a seed: always the same for the same settings.

    brief: what the room is asked to be, one of a home; None = as its seed has it.
    """
    if brief is not None:
        with painted_with(brief.palette):
            return _draw_as_asked(settings, brief)
    rng = stream(settings, PLAN)
    plan = draw_plan(rng, settings.plan)
    shell = draw_shell(plan, rng)
    furniture = furnish(plan, shell, rng)
    arrangement = _places(plan, shell, furniture)
    arrangement.fill(_kinds(settings), N_ON_FLOOR, stream(settings, THINGS))
    things = tuple(arrangement.things)
    room = Room(settings, plan, shell, furniture, things, things)
    return room.rearranged(settings.rearrange, lights=settings.lights)


def _draw_as_asked(settings: RoomSettings, brief: Brief) -> Room:
    rng, purpose = stream(settings, PLAN), brief.purpose
    shell = draw_shell(brief.plan, rng, brief.openings, brief.mood)
    furniture = furnish(brief.plan, shell, rng, purpose.furniture)
    arrangement = _places(brief.plan, shell, furniture, LEAST_REACH)
    arrangement.fill(
        (*purpose.things, *_kinds(settings)[len(KINDS) :]),
        purpose.n_on_floor,
        stream(settings, THINGS),
        per_square_metre=purpose.per_square_metre,
    )
    things = tuple(arrangement.things)
    room = Room(settings, brief.plan, shell, furniture, things, things, brief)
    return room.rearranged(settings.rearrange, lights=settings.lights)


def other_lights(first: Sequence[Light], rng: np.random.Generator) -> tuple[Light, ...]:
    """Return lights each in another brightness and tint, one of them off."""
    kept = sorted(rng.permutation(len(first))[: max(1, len(first) - 1)])
    changed = []
    for number in kept:
        brightness, warmth = rng.uniform(0.4, 1.6), rng.uniform(-0.2, 0.2)
        rgb = first[number].rgb * brightness * np.array([1 + warmth, 1, 1 - warmth])
        changed.append(replace(first[number], rgb=rgb))
    return tuple(changed)


class Seeded(Protocol):
    """What has a seed."""

    @property
    def seed(self) -> int: ...


def stream(settings: Seeded, number: int, *more: int) -> np.random.Generator:
    """Return one of the independent sources of chance that a room's seed gives."""
    return np.random.default_rng((settings.seed, number, *more))


def _kinds(settings: RoomSettings) -> tuple[Kind, ...]:
    """Return the kinds of things to choose from, a furniture library's among them."""
    if settings.furniture is None:
        return KINDS
    library = SweetHomeLibrary(settings.furniture)
    return KINDS + tuple(_kind_of(library, entry) for entry in library.things())


def _kind_of(library: SweetHomeLibrary, entry: Entry) -> Kind:
    """Return a model of a library as a kind of which all are alike."""

    def draw(rng: np.random.Generator) -> Mesh:
        return library.mesh(entry)

    return Kind(entry.name, draw, TABLE if entry.diagonal < MAX_TABLE_SIZE else FLOOR)


def _places(
    plan: FloorPlan, shell: Shell, furniture: Sequence[Placed], least_reach: float = 0.0
) -> Arrangement:
    """Return where things can stand, nothing of it taken."""
    surfaces = [
        Surface(T_room_surface, box) for placed in furniture for T_room_surface, box in placed.tops
    ]
    footprints = [placed.footprint for placed in furniture]
    kept_free = [np.asarray(area) for area in shell.kept_free]
    return Arrangement(plan, surfaces, footprints, kept_free, least_reach)
