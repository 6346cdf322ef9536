"""The fixed part of a room: its surfaces, openings, lamps, and what hangs on the walls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from curiosight.rooms import prints, shapes
from curiosight.rooms.blocks import upright_grain
from curiosight.rooms.materials import near, plastic, timber
from curiosight.rooms.mesh import Material, Mesh, standing
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.plan import FloorPlan, Rectangle
from curiosight.rooms.scene import Light, Part, Role
from curiosight.rooms.shell import openings, walls
from curiosight.rooms.shell.decoration import hang
from curiosight.rooms.shell.finish import WHITE, Finish, draw_finish
from curiosight.rooms.shell.lamps import draw_lamp
from curiosight.rooms.shell.mood import USUAL, Mood
from curiosight.rooms.shell.walls import Opening

# Radiance times area that the lights have together, for each square metre of floor: with it
# a white wall is about 1 at its brightest.
LIGHT_PER_FLOOR = 1.1
DOOR_SWING = 0.95
# Metres of the shorter side of a floor that a rug fits on.
SMALLEST_WITH_RUG = 2.8
# A lamp for each so many metres of a long room.
LAMP_EVERY = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class Shell:
    """A room without furniture.

    openings: its doors and windows.
    """

    parts: tuple[Part, ...]
    lights: tuple[Light, ...]
    openings: tuple[Opening, ...]

    @property
    def kept_free(self) -> tuple[Rectangle, ...]:
        """Places of the floor before the doors, where nothing may stand."""
        return tuple(o.front(DOOR_SWING, 0.1) for o in self.openings if o.is_door)


def draw_shell(
    plan: FloorPlan,
    rng: np.random.Generator,
    holes: tuple[Opening, ...] | None = None,
    mood: Mood = USUAL,
) -> Shell:
    """Draw the fixed part of a room, all of it `Role.STRUCTURE`.

    holes: its doors and windows; None = drawn, too.
    """
    finish = draw_finish(rng, len(plan.walls))
    holes = openings.draw_openings(plan, rng) if holes is None else holes
    fitted, lights = _fit_openings(holes, plan, finish, mood, rng)
    lamps, lamp_lights = _hang_lamps(plan, mood, rng)
    lowest = 0.9 if finish.panelling is None else finish.panelling_height + 0.1
    hung = hang(plan, holes, lowest, rng)
    named = [*_surfaces(plan, holes, finish), *fitted, *lamps, *hung]
    if rng.random() < 0.6 and min(_largest(plan)) > SMALLEST_WITH_RUG:
        named.append(("rug", _rug(plan, rng)))
    parts = tuple(Part(name, Role.STRUCTURE, mesh) for name, mesh in named)
    return Shell(parts, (*lights, *lamp_lights), holes)


def _surfaces(
    plan: FloorPlan, holes: Sequence[Opening], finish: Finish
) -> Iterator[tuple[str, Mesh]]:
    yield "floor", walls.floor_surface(plan, finish.floor)
    yield "ceiling", walls.ceiling_surface(plan, finish.ceiling)
    for wall, material in zip(plan.walls, finish.walls, strict=True):
        own = [hole for hole in holes if hole.wall is wall]
        if finish.panelling is None:
            yield "wall", walls.wall_surface(wall, 0.0, plan.height, own, material)
        else:
            line = finish.panelling_height
            yield "wall", walls.wall_surface(wall, 0.0, line, own, finish.panelling)
            yield "wall", walls.wall_surface(wall, line, plan.height, own, material)
            rail = walls.strips(wall, own, finish.trim, bottom=line, size=(0.02, 0.05))
            if rail is not None:
                yield "rail", rail
        skirting = walls.strips(wall, own, finish.trim, bottom=0.0, size=(0.014, 0.085))
        if skirting is not None:
            yield "skirting", skirting


def _fit_openings(
    holes: Sequence[Opening],
    plan: FloorPlan,
    finish: Finish,
    mood: Mood,
    rng: np.random.Generator,
) -> tuple[list[tuple[str, Mesh]], list[Light]]:
    named: list[tuple[str, Mesh]] = []
    lights = []
    leaf = _draw_leaf(rng)
    glass_area = sum(hole.width * hole.height for hole in holes if hole.kind == "window")
    usual = 0.6 * LIGHT_PER_FLOOR * plan.area / max(glass_area, 1e-9) * float(rng.uniform(0.7, 1.3))
    daylight = mood.daylight * usual
    has_radiators = rng.random() < 0.7
    curtains = openings.draw_curtains(rng) if rng.random() < 0.6 else None
    material_of = dict(zip(plan.walls, finish.walls, strict=True))
    for hole in holes:
        if hole.kind == "door":
            named.append(("door", openings.door_mesh(hole, finish, leaf, rng)))
            continue
        if hole.kind == openings.DOORWAY:
            named.append(("door frame", openings.door_frame(hole, hole.depth, finish)))
            named.append((openings.DOORWAY, openings.doorway_mesh(hole, hole.depth)))
            continue
        wall = material_of[hole.wall]
        mesh = openings.window_mesh(hole, wall, finish, rng, daylight=mood.daylight)
        named.append(("window", mesh))
        lights.append(openings.window_light(hole, daylight))
        if has_radiators:
            named.append(("radiator", openings.radiator_mesh(hole, rng)))
        if curtains is not None:
            named.append(("curtain", openings.curtain_mesh(hole, curtains)))
    return named, lights


def _draw_leaf(rng: np.random.Generator) -> Material:
    """Draw what doors are made of: paint or wood."""
    kind = rng.random()
    if kind < 0.35:
        return upright_grain(timber(rng))
    rgb = near(rng, WHITE, 4) if kind < 0.75 else draw_colour(rng, vivid=0.7)
    return plastic(rgb, gloss=0.15)


def _hang_lamps(
    plan: FloorPlan, mood: Mood, rng: np.random.Generator
) -> tuple[list[tuple[str, Mesh]], list[Light]]:
    """Hang a lamp in the middle of each large part of the room, in a long one a row of them."""
    named, lights = [], []
    seed = int(rng.integers(2**32))  # lamps of one room are alike
    for x_min, y_min, x_max, y_max in plan.rectangles:
        area = (x_max - x_min) * (y_max - y_min)
        n_lamps = max(1, round(max(x_max - x_min, y_max - y_min) / LAMP_EVERY))
        is_along_x = x_max - x_min >= y_max - y_min
        for share in (np.arange(n_lamps) + 0.5) / n_lamps:
            along, across = (share, 0.5) if is_along_x else (0.5, share)
            mesh, light = draw_lamp(
                float(x_min + along * (x_max - x_min)),
                float(y_min + across * (y_max - y_min)),
                plan.height,
                0.4 * LIGHT_PER_FLOOR * area * mood.lamps / n_lamps,
                np.random.default_rng(seed),
            )
            named.append(("ceiling lamp", mesh))
            lights.append(replace(light, rgb=light.rgb * mood.tint))
    return named, lights


def _largest(plan: FloorPlan) -> tuple[float, float]:
    """Return width and depth of the largest rectangle of the floor."""
    x_min, y_min, x_max, y_max = max(plan.rectangles, key=lambda r: (r[2] - r[0]) * (r[3] - r[1]))
    return x_max - x_min, y_max - y_min


def _rug(plan: FloorPlan, rng: np.random.Generator) -> Mesh:
    """Return a rug on the floor of the largest part of the room."""
    area = max(plan.rectangles, key=lambda r: (r[2] - r[0]) * (r[3] - r[1]))
    size = np.array((rng.uniform(1.6, 2.6), rng.uniform(1.1, 1.8)))
    room = np.array(area).reshape(2, 2)
    x, y = rng.uniform(room[0] + size / 2 + 0.5, room[1] - size / 2 - 0.5)
    weave = Material(prints.rug(rng))
    top = shapes.box((*size, 0.008), weave, spacing=0.1, fit=True)
    return top.moved(standing(float(x), float(y)))
