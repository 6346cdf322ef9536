"""Sofas, armchairs and beds."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import round_shapes, shapes, textures
from curiosight.rooms.blocks import block
from curiosight.rooms.furniture.fronts import draw_board
from curiosight.rooms.furniture.kind import Furniture
from curiosight.rooms.materials import cloth, leather, near
from curiosight.rooms.mesh import Material, Mesh, join, standing
from curiosight.rooms.palette import draw_colour

# Cushions are drawn coarser than tables: no small things cast shadows on them.
SPACING = 0.15


def sofa(rng: np.random.Generator) -> Furniture:
    """Draw a sofa of two or three seats."""
    return _seats("sofa", int(rng.integers(2, 4)), rng)


def armchair(rng: np.random.Generator) -> Furniture:
    """Draw an armchair."""
    return _seats("armchair", 1, rng)


def bed(rng: np.random.Generator) -> Furniture:
    """Draw a bed with its bedding; its head is at the wall."""
    width, length = float(rng.uniform(0.95, 1.65)), 2.08
    x, y, wood = width / 2, length / 2, draw_board(rng)
    head = float(rng.uniform(0.8, 1.05))
    linen = Material(textures.fabric(rng, near(rng, (232, 230, 226), 5)), (0.12, 0.12))
    duvet = shapes.rounded_box(
        (width - 0.01, 1.42, 0.2), 0.05, _bedding(rng), spacing=SPACING, lift=0.35
    )
    meshes = [
        block((-x, x), (-y, -y + 0.03), (0.05, 0.42), wood),
        block((-x, x), (y - 0.04, y), (0.05, head), wood),
        block((-x, -x + 0.03), (-y, y), (0.15, 0.36), wood),
        block((x - 0.03, x), (-y, y), (0.15, 0.36), wood),
        *_feet(width, length, 0.15, wood),
        shapes.rounded_box(
            (width - 0.06, length - 0.08, 0.2), 0.04, linen, spacing=SPACING, lift=0.29
        ),
        duvet.moved(standing(0, -y + 0.76)),
        *_bed_pillows(width, y - 0.3, linen),
    ]
    return Furniture("bed", join(meshes), (width, length, head))


def _seats(name: str, n_seats: int, rng: np.random.Generator) -> Furniture:
    seat = float(rng.uniform(0.56, 0.68))
    arm, back = float(rng.uniform(0.12, 0.2)), float(rng.uniform(0.14, 0.2))
    width, depth = n_seats * seat + 2 * arm, float(rng.uniform(0.8, 0.95))
    height, foot = float(rng.uniform(0.74, 0.9)), float(rng.uniform(0.05, 0.14))
    cover = _cover(rng)
    y, arm_height = depth / 2, float(rng.uniform(0.54, 0.64))
    arms = shapes.rounded_box(
        (arm, depth - 0.02, arm_height - foot), 0.045, cover, spacing=SPACING, lift=foot
    )
    rest = shapes.rounded_box(
        (width - 2 * arm, back, height - foot), 0.05, cover, spacing=SPACING, lift=foot
    )
    x = width / 2 - arm / 2
    meshes = [
        shapes.box((width - 2 * arm, depth - 0.06, 0.30 - foot), cover, spacing=SPACING, lift=foot),
        rest.moved(standing(0, y - back / 2)),
        arms.moved(standing(-x, 0)),
        arms.moved(standing(x, 0)),
        *_feet(width, depth, foot, draw_board(rng)),
    ]
    cushion = shapes.rounded_box(
        (seat - 0.008, depth - back, 0.15), 0.04, cover, spacing=SPACING, lift=0.29
    )
    behind = shapes.rounded_box(
        (seat - 0.015, 0.14, height - 0.46), 0.05, cover, spacing=SPACING, lift=0.43
    )
    for number in range(n_seats):
        middle = (number + 0.5) * seat - n_seats * seat / 2
        meshes.append(cushion.moved(standing(middle, -back / 2)))
        meshes.append(behind.moved(standing(middle, y - back - 0.06)))
    return Furniture(name, join(meshes), (width, depth, height))


def _cover(rng: np.random.Generator) -> Material:
    kind = rng.random()
    if kind < 0.2:
        return leather(rng, draw_colour(rng, vivid=0.2))
    return cloth(rng) if kind < 0.35 else cloth(rng, draw_colour(rng, vivid=0.5))


def _bedding(rng: np.random.Generator) -> Material:
    colours = [draw_colour(rng, vivid=0.5), draw_colour(rng, vivid=0.3)]
    kind = rng.integers(4)
    if kind == 0:
        return Material(textures.checks(rng, colours), (0.35, 0.35))
    if kind == 1:
        return Material(textures.stripes(rng, colours), (0.5, 0.5))
    if kind == 2:
        return Material(textures.wallpaper(rng, colours), (0.3, 0.3))
    return Material(textures.fabric(rng, colours[0]), (0.12, 0.12))


def _bed_pillows(width: float, y: float, linen: Material) -> list[Mesh]:
    n_pillows = 1 if width < 1.3 else 2
    size = (min(0.7, width / n_pillows - 0.1), 0.4, 0.14)
    pillow = shapes.rounded_box(size, 0.06, linen, spacing=SPACING, lift=0.47)
    places = (np.arange(n_pillows) - (n_pillows - 1) / 2) * width / n_pillows
    return [pillow.moved(standing(float(x), y)) for x in places]


def _feet(width: float, depth: float, height: float, wood: Material) -> list[Mesh]:
    x, y = width / 2 - 0.06, depth / 2 - 0.06
    foot = round_shapes.cylinder(0.018, height, wood, top_radius=0.028, n_around=10)
    return [foot.moved(standing(a, b)) for a in (-x, x) for b in (-y, y)]
