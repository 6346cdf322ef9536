"""Doors and windows: where they are, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from curiosight.rooms import pictures, round_shapes, shapes, surfaces
from curiosight.rooms.blocks import block, frame
from curiosight.rooms.materials import chrome, cloth, near, plastic, timber
from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.plan import FloorPlan, Wall
from curiosight.rooms.scene import Light
from curiosight.rooms.shell.finish import Finish
from curiosight.rooms.shell.walls import Opening

RECESS = 0.16
# What fills an open doorway in its room's picture, where the next room's begins.
DOORWAY = "doorway"
DAYLIGHT = (0.90, 0.97, 1.06)


def draw_openings(plan: FloorPlan, rng: np.random.Generator) -> tuple[Opening, ...]:
    """Draw one or two doors near corners, and windows in one to three other walls."""
    long_enough = [wall for wall in plan.walls if wall.length > 1.9]
    order = [long_enough[number] for number in rng.permutation(len(long_enough))]
    n_doors = int(rng.integers(1, 3))
    doors = [_draw_door(wall, rng) for wall in order[:n_doors]]
    n_lit = int(rng.integers(1, min(3, len(order) - n_doors) + 1))
    windows = [
        w for wall in order[n_doors : n_doors + n_lit] for w in draw_windows(plan, wall, rng)
    ]
    return (*doors, *windows)


def _draw_door(wall: Wall, rng: np.random.Generator) -> Opening:
    width, height = rng.uniform(0.82, 0.95), rng.uniform(2.0, 2.1)
    left = float(rng.uniform(0.2, 0.6))
    if rng.random() < 0.5:
        left = wall.length - left - width
    return Opening("door", wall, left, left + width, 0.0, height)


def draw_windows(plan: FloorPlan, wall: Wall, rng: np.random.Generator) -> tuple[Opening, ...]:
    """Draw one to three windows in a wall."""
    n_windows = int(np.clip(wall.length // 2.6, 1, 3))
    width = float(min(rng.uniform(0.9, 2.0), wall.length / n_windows - 0.8))
    bottom, top = float(rng.uniform(0.8, 1.05)), plan.height - float(rng.uniform(0.25, 0.4))
    middles = (np.arange(n_windows) + 0.5) * wall.length / n_windows
    return tuple(
        Opening("window", wall, float(x - width / 2), float(x + width / 2), bottom, top)
        for x in middles
    )


def door_mesh(opening: Opening, finish: Finish, leaf: Material, rng: np.random.Generator) -> Mesh:
    """Return a closed door with its frame and handle."""
    x, top = (opening.left, opening.right), opening.top
    panels = [
        block((x[0] + 0.14, x[1] - 0.14), (0.012, 0.03), z, leaf)
        for z in _door_panels(top, int(rng.integers(0, 4)))
    ]
    side = 0.09 if rng.random() < 0.5 else opening.width - 0.09
    inwards = 0.11 if side < opening.width / 2 else -0.11
    metal, at = chrome(rng), opening.left + side
    lever = [(at, 0.02, 1.02), (at, -0.04, 1.02), (at + inwards, -0.045, 1.02)]
    meshes = [
        block(x, (0.02, 0.06), (0, top), leaf, spacing=0.1),
        *panels,
        block(x, (-0.005, 0.06), (0, 0.008), finish.trim),
        block((x[0] - 0.07, x[0]), (-0.02, 0.06), (0, top + 0.07), finish.trim),
        block((x[1], x[1] + 0.07), (-0.02, 0.06), (0, top + 0.07), finish.trim),
        block(x, (-0.02, 0.06), (top, top + 0.07), finish.trim),
        block((at - 0.02, at + 0.02), (0.01, 0.02), (0.92, 1.1), metal),
        round_shapes.tube(lever, 0.01, metal),
    ]
    return join(meshes).moved(opening.wall.T_room_wall)


def door_frame(opening: Opening, depth: float, finish: Finish) -> Mesh:
    """Return the frame and the sides of an open doorway, `depth` metres into the wall."""
    x, top = (opening.left, opening.right), opening.top
    width, side = opening.width, (0.0, depth, 0.0)
    meshes = [
        shapes.panel((x[0], 0, 0), side, (0, 0, top), finish.trim),
        shapes.panel((x[1], depth, 0), (0, -depth, 0), (0, 0, top), finish.trim),
        shapes.panel((x[0], depth, top), (width, 0, 0), (0, -depth, 0), finish.trim),
        shapes.panel((x[0], 0, 0), (width, 0, 0), side, finish.trim),
        block((x[0] - 0.07, x[0]), (-0.02, 0.005), (0, top + 0.07), finish.trim),
        block((x[1], x[1] + 0.07), (-0.02, 0.005), (0, top + 0.07), finish.trim),
        block(x, (-0.02, 0.005), (top, top + 0.07), finish.trim),
    ]
    return join(meshes).moved(opening.wall.T_room_wall)


def doorway_mesh(opening: Opening, depth: float) -> Mesh:
    """Return the plane through which one looks on, `depth` metres into the wall."""
    grey = plastic(np.array((120, 116, 110), np.uint8), gloss=0.0)
    plane = shapes.panel(
        (opening.left, depth, 0), (opening.width, 0, 0), (0, 0, opening.top), grey, spacing=0.25
    )
    return plane.moved(opening.wall.T_room_wall)


def _door_panels(top: float, n_panels: int) -> list[tuple[float, float]]:
    """Return the heights of a leaf's raised fields."""
    edges = np.linspace(0.2, top - 0.14, n_panels + 1)
    gap = 0.06
    return [(low + gap, high - gap) for low, high in pairwise(edges)]


def window_mesh(
    opening: Opening,
    wall: Material,
    finish: Finish,
    rng: np.random.Generator,
    *,
    daylight: float = 1.0,
) -> Mesh:
    """Return a recessed window: its reveal and sill, the frame, and the view outside."""
    x, z, depth = (opening.left, opening.right), (opening.bottom, opening.top), RECESS
    width, height = opening.width, opening.height
    view = pictures.outdoors(rng, (256, round(256 * width / height)))
    sky = Material(view, emission=2.4 * daylight, infrared=0.0, gloss=0.3, sharpness=100.0)
    y = (depth - 0.06, depth - 0.01)
    n_panes = max(1, round(width / float(rng.uniform(0.5, 0.9))))
    bars = [
        block((middle - 0.025, middle + 0.025), y, z, finish.trim)
        for middle in np.linspace(*x, n_panes + 1)[1:-1]
    ]
    if rng.random() < 0.4:
        line = z[1] - 0.3 * height
        bars.append(block(x, y, (line - 0.02, line + 0.02), finish.trim))
    meshes = [
        shapes.panel((x[0], 0, z[0]), (0, depth, 0), (0, 0, height), wall),
        shapes.panel((x[1], depth, z[0]), (0, -depth, 0), (0, 0, height), wall),
        shapes.panel((x[0], depth, z[1]), (width, 0, 0), (0, -depth, 0), wall),
        shapes.panel(
            (x[0], depth, z[0]), (width, 0, 0), (0, 0, height), sky, spacing=9.0, fit=True
        ),
        block((x[0] - 0.05, x[1] + 0.05), (-0.07, depth), (z[0] - 0.03, z[0]), finish.trim),
        *frame(x, y, z, 0.06, finish.trim),
        *bars,
    ]
    return join(meshes).moved(opening.wall.T_room_wall)


def window_light(opening: Opening, brightness: float) -> Light:
    """Return the daylight of a window; brightness: linear radiance."""
    T = opening.wall.T_room_wall
    centre = (opening.middle, RECESS - 0.07, (opening.bottom + opening.top) / 2)
    return Light(
        centre=T[:3, :3] @ centre + T[:3, 3],
        along=T[:3, 0] * opening.width,
        across=T[:3, 2] * opening.height,
        rgb=brightness * np.asarray(DAYLIGHT),
    )


def radiator_mesh(opening: Opening, rng: np.random.Generator) -> Mesh:
    """Return a ribbed radiator under a window."""
    n_ribs = int(opening.width * rng.uniform(0.7, 1.0) / 0.06)
    bottom, top = 0.12, opening.bottom - float(rng.uniform(0.12, 0.25))
    paint = plastic(near(rng, (236, 234, 228), 5), gloss=0.2)
    middle = opening.middle
    left, right = middle - 0.03 * n_ribs, middle + 0.03 * n_ribs
    ribs = [
        block((x - 0.018, x + 0.018), (-0.105, -0.03), (bottom, top), paint)
        for x in np.linspace(left + 0.03, right - 0.03, n_ribs)
    ]
    rails = [
        block((left, right), (-0.075, -0.045), (z, z + 0.04), paint)
        for z in (bottom + 0.04, top - 0.08)
    ]
    return join([*ribs, *rails]).moved(opening.wall.T_room_wall)


@dataclass(frozen=True, slots=True, eq=False)
class Curtains:
    """How the windows of one room are curtained; reach: width of each side, metres."""

    stuff: Material
    rod: Material
    reach: float
    is_long: bool


def draw_curtains(rng: np.random.Generator) -> Curtains:
    """Draw the curtains of a room."""
    stuff = cloth(rng) if rng.random() < 0.4 else cloth(rng, draw_colour(rng, vivid=0.6))
    return Curtains(stuff, timber(rng), float(rng.uniform(0.25, 0.4)), bool(rng.random() < 0.6))


def curtain_mesh(opening: Opening, curtains: Curtains) -> Mesh:
    """Return a rod with a curtain drawn to each side of a window."""
    z = (0.03 if curtains.is_long else opening.bottom - 0.12, opening.top + 0.1)
    inwards, outwards = 0.4 * curtains.reach, 0.6 * curtains.reach
    left = (opening.left - outwards, opening.left + inwards)
    right = (opening.right - inwards, opening.right + outwards)
    ends = (left[0] - 0.1, right[1] + 0.1)
    rod = round_shapes.tube([(end, -0.08, z[1] + 0.01) for end in ends], 0.011, curtains.rod)
    sides = [_hanging(side, z, curtains.stuff) for side in (left, right)]
    return join([rod, *sides]).moved(opening.wall.T_room_wall)


def _hanging(x: tuple[float, float], z: tuple[float, float], stuff: Material) -> Mesh:
    """Return a curtain in folds; its texture keeps its scale along the cloth."""
    across, heights = np.linspace(*x, 33), np.linspace(*z, 12)
    folds = -0.08 + 0.03 * np.sin(2 * np.pi * (across - x[0]) / 0.085)
    shape = (len(heights), len(across))
    points = np.stack(
        [
            np.broadcast_to(across, shape),
            np.broadcast_to(folds, shape),
            np.broadcast_to(heights[:, None], shape),
        ],
        -1,
    )
    sheet = surfaces.sheet(points, stuff)
    cloth_size = np.array((1.8 * (x[1] - x[0]), z[1] - z[0]), np.float32)
    return replace(sheet, uv=sheet.uv * cloth_size)
