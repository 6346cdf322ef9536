"""Cupboard bodies with doors and drawers, and what furniture is painted with."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from curiosight.rooms import round_shapes, textures
from curiosight.rooms.blocks import Range, block, upright_grain
from curiosight.rooms.materials import colour, near, plastic, steel, timber
from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.surfaces import turned

# Between the fronts of a cupboard, and their thickness, metres.
GAP, THICKNESS = 0.004, 0.018
TOP_SPACING = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """The materials of one piece of furniture; handle: "bar", "knob" or "none"."""

    body: Material
    front: Material
    metal: Material
    handle: str


def draw_look(rng: np.random.Generator) -> Look:
    """Draw a piece's materials: wood or paint, its fronts the same or another."""
    body = draw_board(rng)
    front = body if rng.random() < 0.5 else draw_board(rng, vivid=0.75)
    metal = steel(rng) if rng.random() < 0.7 else plastic(colour(46, 46, 48))
    return Look(body, front, metal, str(rng.choice(["bar", "knob", "none"], p=[0.5, 0.35, 0.15])))


def draw_board(rng: np.random.Generator, vivid: float = 0.35) -> Material:
    """Draw wood, or paint of which a share is vivid."""
    kind = rng.random()
    if kind < 0.55:
        return timber(rng)
    if kind < 0.7:
        return plastic(near(rng, (236, 234, 228), 4), gloss=0.2)
    paint = textures.plaster(rng, draw_colour(rng, vivid=vivid))
    return Material(paint, (1.0, 1.0), gloss=0.15, sharpness=25.0)


def fronts(x: Range, z: Range, y: float, n_columns: int, n_rows: int, look: Look) -> list[Mesh]:
    """Return doors (one row) or drawers (more), before the plane y, with their handles."""
    material = upright_grain(look.front) if n_rows == 1 else look.front
    columns, rows = np.linspace(*x, n_columns + 1), np.linspace(*z, n_rows + 1)
    meshes = []
    for column, row in product(range(n_columns), range(n_rows)):
        left, right = columns[column] + GAP / 2, columns[column + 1] - GAP / 2
        low, high = rows[row] + GAP / 2, rows[row + 1] - GAP / 2
        meshes.append(block((left, right), (y - THICKNESS, y), (low, high), material))
        if n_rows > 1:
            at = ((left + right) / 2, high - min(0.06, (high - low) / 2))
        else:
            # Doors open in pairs: their handles are beside each other.
            at = (right - 0.05 if column % 2 == 0 else left + 0.05, _reachable(low, high))
        if look.handle != "none":
            meshes.append(_handle(at, y - THICKNESS, n_rows == 1, look))
    return meshes


def _reachable(low: float, high: float) -> float:
    """Return the height of a door's handle: near the edge that a hand comes to first."""
    if low > 1.2:
        return low + 0.1
    return min(high - 0.12, 1.05)


def _handle(at: tuple[float, float], y: float, is_upright: bool, look: Look) -> Mesh:
    x, z = at
    if look.handle == "knob":
        knob = round_shapes.cylinder(0.016, 0.022, look.metal, n_around=10)
        return knob.moved(turned((1, 0, 0), np.pi / 2, (x, y, z)))
    half = 0.07
    if is_upright:
        return block((x - 0.006, x + 0.006), (y - 0.028, y), (z - half, z + half), look.metal)
    return block((x - half, x + half), (y - 0.028, y), (z - 0.006, z + 0.006), look.metal)
