"""A room: its walls and furniture, the things in it, and where a robot can stand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from curiosight.worlds.rooms.arrangement import Arrangement, Box, Surface, Thing, rearranged
from curiosight.worlds.rooms.free_space import FreeSpace, Polygon
from curiosight.worlds.rooms.furniture import Placed, furnish
from curiosight.worlds.rooms.mesh import Mesh
from curiosight.worlds.rooms.plan import FloorPlan, draw_plan
from curiosight.worlds.rooms.scene import Light, Scene
from curiosight.worlds.rooms.settings import RoomSettings
from curiosight.worlds.rooms.shell import draw_shell
from curiosight.worlds.rooms.sweet_home import Entry, SweetHomeLibrary
from curiosight.worlds.rooms.things import KINDS, Kind
from curiosight.worlds.rooms.things.kind import FLOOR, TABLE

_N_ON_FLOOR = 16
MAX_TABLE_SIZE = 0.5  # metres; what is larger stands on the floor
# Numbers of the random streams that a seed is split into.
PLAN, THINGS, REARRANGEMENT, LIGHTS, VIEWS, LOOKS = range(6)


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """A room to look around in; metres, z up, the floor at z = 0."""

    settings: RoomSettings
    plan: FloorPlan
    furniture: tuple[Placed, ...]
    things: tuple[Thing, ...]
    scene: Scene

    @property
    def footprints(self) -> tuple[Polygon, ...]:
        """What stands on the floor, seen from above: (4, 2) corners each."""
        on_floor = [thing.footprint() for thing in self.things if thing.is_on_floor]
        return (*(placed.footprint for placed in self.furniture), *on_floor)

    def free_space(self) -> FreeSpace:
        """Return where a robot can stand."""
        return FreeSpace(self.plan.outline, self.footprints)


def draw_room(settings: RoomSettings) -> Room:
    """Draw the room of a seed: always the same for the same settings."""
    rng = stream(settings, PLAN)
    plan = draw_plan(rng, settings.plan)
    shell = draw_shell(plan, rng)
    furniture = furnish(plan, shell, rng)
    kinds = _kinds(settings)
    kept_free = [np.asarray(area) for area in shell.kept_free]
    things = _draw_things(settings, kinds, lambda: _places(plan, furniture, kept_free))
    fixed = [*shell.parts, *(part for placed in furniture for part in placed.parts())]
    parts = (*fixed, *(thing.part() for thing in things))
    return Room(settings, plan, furniture, things, Scene(parts, _lights(settings, shell.lights)))


def stream(settings: RoomSettings, number: int, *more: int) -> np.random.Generator:
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


def _draw_things(
    settings: RoomSettings, kinds: Sequence[Kind], empty: Callable[[], Arrangement]
) -> tuple[Thing, ...]:
    """Arrange things in the empty room; then, if asked for, once more."""
    arrangement = empty()
    arrangement.fill(kinds, _N_ON_FLOOR, stream(settings, THINGS))
    if settings.rearrange is None:
        return tuple(arrangement.things)
    rng = stream(settings, REARRANGEMENT, settings.rearrange)
    return rearranged(arrangement.things, empty(), kinds, rng)


def _places(plan: FloorPlan, furniture: Sequence[Placed], kept_free: Sequence[Box]) -> Arrangement:
    surfaces = [
        Surface(T_room_surface, box) for placed in furniture for T_room_surface, box in placed.tops
    ]
    footprints = [placed.footprint for placed in furniture]
    return Arrangement(plan.outline, surfaces, footprints, kept_free)


def _lights(settings: RoomSettings, lights: Sequence[Light]) -> tuple[Light, ...]:
    """Return the lights, or other ones: each brighter or darker, warmer or cooler, or off."""
    if settings.lights is None:
        return tuple(lights)
    rng = stream(settings, LIGHTS, settings.lights)
    changed = []
    for light in lights:
        brightness = rng.uniform(0.4, 1.6)
        warmth = rng.uniform(-0.2, 0.2)
        changed.append(
            replace(light, rgb=light.rgb * brightness * np.array([1 + warmth, 1, 1 - warmth]))
        )
    if len(changed) > 1:
        changed.pop(int(rng.integers(len(changed))))
    return tuple(changed)
