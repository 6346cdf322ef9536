"""Tables to sit at, to put a cup on, to work at."""

from __future__ import annotations

from itertools import product

import numpy as np

from curiosight.rooms import round_shapes, shapes
from curiosight.rooms.blocks import block, upright_grain
from curiosight.rooms.furniture.fronts import TOP_SPACING, draw_board, draw_look, fronts
from curiosight.rooms.furniture.kind import Furniture, Top, centred
from curiosight.rooms.materials import plastic, steel
from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.surfaces import Points, warped

# What may not stand on: a top's rim; and how thick side panels are.
RIM, THICK = 0.03, 0.025


def table(rng: np.random.Generator) -> Furniture:
    """Draw a dining table: four legs, trestles, or round on a foot."""
    height = float(rng.uniform(0.72, 0.76))
    if rng.random() < 0.25:
        return _round_table("table", float(rng.uniform(0.48, 0.62)), height, rng)
    size = (float(rng.uniform(1.2, 1.8)), float(rng.uniform(0.75, 0.95)), height)
    return _long_table("table", size, rng)


def coffee_table(rng: np.random.Generator) -> Furniture:
    """Draw a low table."""
    height = float(rng.uniform(0.40, 0.48))
    if rng.random() < 0.35:
        return _round_table("coffee table", float(rng.uniform(0.35, 0.45)), height, rng)
    size = (float(rng.uniform(0.8, 1.15)), float(rng.uniform(0.5, 0.65)), height)
    return _long_table("coffee table", size, rng)


def desk(rng: np.random.Generator) -> Furniture:
    """Draw a desk: two side panels or a steel frame, and drawers on one side."""
    width, depth = float(rng.uniform(1.1, 1.6)), float(rng.uniform(0.6, 0.75))
    height, board = float(rng.uniform(0.72, 0.76)), 0.028
    look, half, under = draw_look(rng), width / 2, height - board
    y = (-depth / 2 + 0.02, depth / 2 - 0.01)
    chest = (half - 0.45, half - 0.03) if rng.random() < 0.5 else (0.03 - half, 0.45 - half)
    has_panels = rng.random() < 0.6
    meshes = [
        _board(width, depth, under, height, look.body),
        block(chest, (y[0] + THICK, y[1]), (0.08 if has_panels else 0.15, under), look.body),
        *fronts(chest, (0.1 if has_panels else 0.16, under - 0.01), y[0] + THICK, 1, 3, look),
    ]
    if has_panels:
        sides = ((-half, THICK - half), (half - THICK, half))
        meshes += [block(x, y, (0, under), upright_grain(look.body)) for x in sides]
        meshes.append(block((-half, half), (y[1] - THICK, y[1]), (0.25, under), look.body))
    else:
        meshes += _legs(width, depth, under, 0.02, steel(rng))
    area = centred(width, depth, RIM)
    return Furniture("desk", join(meshes), (width, depth, height), (Top(height, area),))


def _long_table(name: str, size: tuple[float, float, float], rng: np.random.Generator) -> Furniture:
    width, depth, height = size
    board, wood = float(rng.uniform(0.022, 0.045)), draw_board(rng)
    under = height - board
    frame = wood if rng.random() < 0.65 else draw_board(rng, vivid=0.6)
    meshes = [_board(width, depth, under, height, wood)]
    if rng.random() < 0.75:
        half = float(rng.uniform(0.022, 0.042))
        meshes += _legs(width, depth, under, half, upright_grain(frame))
        meshes += _apron(width - 0.1, depth - 0.1, under, frame)
    else:
        meshes += _trestles(width, depth, under, frame)
    if name == "coffee table" and rng.random() < 0.5:
        shelf = (-width / 2 + 0.06, width / 2 - 0.06), (-depth / 2 + 0.06, depth / 2 - 0.06)
        meshes.append(block(*shelf, (0.12, 0.14), wood))
    top = Top(height, centred(width, depth, RIM))
    return Furniture(name, join(meshes), size, (top,), against_wall=False)


def _round_table(name: str, radius: float, height: float, rng: np.random.Generator) -> Furniture:
    wood = draw_board(rng)
    foot = wood if rng.random() < 0.6 else plastic(np.array((52, 52, 56), np.uint8))
    under = height - 0.03
    edge = [(0.0, under), (radius, under), (radius, height)]
    stem = [(0.0, 0.0), (0.55 * radius, 0.0), (0.55 * radius, 0.02), (0.06, 0.06), (0.04, 0.2)]
    meshes = [
        shapes.disc(radius, wood, n_around=40, lift=height),
        round_shapes.lathe(edge, wood, n_around=40, fit=False),
        round_shapes.lathe([*stem, (0.05, under)], foot, fit=False),
    ]
    side = 2 * radius
    area = centred(side, side, radius * (1 - np.sqrt(0.5)) + RIM)
    size = (side, side, height)
    return Furniture(name, join(meshes), size, (Top(height, area),), against_wall=False)


def _board(width: float, depth: float, low: float, high: float, wood: Material) -> Mesh:
    x, y = (-width / 2, width / 2), (-depth / 2, depth / 2)
    return block(x, y, (low, high), wood, spacing=TOP_SPACING)


def _legs(width: float, depth: float, top: float, half: float, material: Material) -> list[Mesh]:
    """Return four square legs, each 2 `half` thick."""
    x, y = width / 2 - half - 0.02, depth / 2 - half - 0.02
    return [
        block((a - half, a + half), (b - half, b + half), (0, top), material)
        for a, b in product((-x, x), (-y, y))
    ]


def _apron(width: float, depth: float, top: float, material: Material) -> list[Mesh]:
    """Return the four rails under a table top."""
    x, y, z = width / 2, depth / 2, (top - 0.08, top)
    return [
        block((-x, x), (-y, -y + 0.02), z, material),
        block((-x, x), (y - 0.02, y), z, material),
        block((-x, -x + 0.02), (-y, y), z, material),
        block((x - 0.02, x), (-y, y), z, material),
    ]


def _trestles(width: float, depth: float, top: float, material: Material) -> list[Mesh]:
    """Return two pairs of slanting legs, and the beam that joins them."""
    x, y = width / 2 - 0.2, depth / 2 - 0.09

    def slanted(points: Points) -> Points:
        lean = 1 - 0.75 * points[:, 2:] / top
        return np.hstack([points[:, :1], points[:, 1:2] * lean, points[:, 2:]])

    legs = [
        warped(block((a - 0.025, a + 0.025), (b - 0.03, b + 0.03), (0, top), material), slanted)
        for a, b in product((-x, x), (-y, y))
    ]
    heads = [block((a - 0.03, a + 0.03), (-y, y), (top - 0.05, top), material) for a in (-x, x)]
    beam = block((-x, x), (-0.02, 0.02), (top - 0.12, top - 0.05), material)
    return [*legs, *heads, beam]
