"""A kitchen along a wall: cupboards below and above, a worktop, a sink and a stove."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from curiosight.rooms import round_shapes, shapes, textures
from curiosight.rooms.blocks import block
from curiosight.rooms.furniture.fronts import THICKNESS, TOP_SPACING, Look, draw_look, fronts
from curiosight.rooms.furniture.kind import Furniture, Top
from curiosight.rooms.materials import chrome, colour, near, plastic, steel, timber
from curiosight.rooms.mesh import Material, Mesh, join, standing
from curiosight.rooms.palette import draw_colour, draw_muted

UNIT, DEPTH, HEIGHT = 0.6, 0.62, 0.90
WORKTOP, PLINTH = 0.04, 0.1
UPPER_BOTTOM, UPPER_DEPTH = 1.45, 0.34
FRONT, BACK = -DEPTH / 2, DEPTH / 2


def kitchen_counter(rng: np.random.Generator) -> Furniture:
    """Draw a kitchen of three to five units, 60 cm wide each."""
    n_units = int(rng.integers(3, 6))
    kinds = ["cupboard"] * n_units
    kinds[rng.integers(n_units)] = "sink"
    free = [number for number, kind in enumerate(kinds) if kind == "cupboard"]
    kinds[free[rng.integers(len(free))]] = "stove"
    look, half = draw_look(rng), n_units * UNIT / 2
    upper = UPPER_BOTTOM + float(rng.uniform(0.55, 0.7))
    meshes = [
        block((-half, half), (FRONT + 0.03, BACK), (PLINTH, HEIGHT - WORKTOP), look.body),
        block((-half, half), (FRONT + 0.08, BACK), (0, PLINTH), plastic(colour(70, 70, 72))),
        _worktop(half, rng),
        _splashback(half, rng),
    ]
    for number, kind in enumerate(kinds):
        x = number * UNIT - half
        meshes += _unit(x, kind, int(rng.choice([1, 1, 3])), look, rng)
        if kind != "stove" and rng.random() < 0.8:
            meshes += _upper_cupboard((x, x + UNIT), upper, look)
    if "stove" in kinds:
        x = kinds.index("stove") * UNIT - half
        hood = (x, x + UNIT), (BACK - 0.3, BACK), (UPPER_BOTTOM + 0.05, UPPER_BOTTOM + 0.15)
        meshes.append(block(*hood, steel(rng)))
    size = (2 * half, DEPTH, upper)
    return Furniture("kitchen counter", join(meshes), size, _free_tops(kinds, half))


def _worktop(half: float, rng: np.random.Generator) -> Mesh:
    kind = rng.integers(3)
    if kind == 0:
        material = timber(rng)
    else:
        rgb = near(rng, draw_muted(rng))
        texture = textures.speckled(rng, rgb) if kind == 1 else textures.stone(rng, rgb)
        material = Material(texture, (0.5, 0.5), gloss=0.45, sharpness=50.0)
    z = (HEIGHT - WORKTOP, HEIGHT)
    return block((-half, half), (FRONT, BACK), z, material, spacing=TOP_SPACING)


def _splashback(half: float, rng: np.random.Generator) -> Mesh:
    """Return the tiled or painted strip of wall above the worktop."""
    rgb = draw_colour(rng, vivid=0.4)
    tiles = Material(textures.tiles(rng, rgb, 4), (0.5, 0.5), gloss=0.4, sharpness=60.0)
    return block((-half, half), (BACK - 0.01, BACK), (HEIGHT, UPPER_BOTTOM), tiles, spacing=0.15)


def _unit(x: float, kind: str, n_rows: int, look: Look, rng: np.random.Generator) -> list[Mesh]:
    """Return the front of a unit whose left edge is at x, and what is let into the worktop."""
    edges = (x, x + UNIT)
    below = (PLINTH, HEIGHT - WORKTOP - 0.005)
    if kind == "stove":
        return _stove(edges, below, rng)
    meshes = fronts(edges, below, FRONT + 0.03, 1, n_rows, look)
    return meshes + _sink(edges, rng) if kind == "sink" else meshes


def _sink(x: tuple[float, float], rng: np.random.Generator) -> list[Mesh]:
    """Return a steel basin, drawn as its rim and dark floor, with a tap."""
    metal, left, right = steel(rng), x[0] + 0.06, x[1] - 0.06
    front, back = FRONT + 0.1, BACK - 0.12
    rim, top = 0.03, HEIGHT + 0.006
    meshes = [
        block((left, right), (front, front + rim), (HEIGHT, top), metal),
        block((left, right), (back - rim, back), (HEIGHT, top), metal),
        block((left, left + rim), (front + rim, back - rim), (HEIGHT, top), metal),
        block((right - rim, right), (front + rim, back - rim), (HEIGHT, top), metal),
    ]
    basin = (left + rim, right - rim), (front + rim, back - rim), (HEIGHT, HEIGHT + 0.001)
    meshes.append(block(*basin, steel(rng, (92, 94, 98))))
    middle = (left + right) / 2
    angles = np.linspace(0, np.pi, 9)
    bow = [
        (middle, back - 0.02 - 0.08 * (1 - np.cos(a)), top + 0.22 + 0.07 * np.sin(a))
        for a in angles
    ]
    tap = [(middle, back + 0.0, HEIGHT), (middle, back - 0.01, top + 0.15), *bow]
    return [*meshes, round_shapes.tube(tap, 0.013, chrome(rng), n_around=8)]


def _stove(x: tuple[float, float], z: tuple[float, float], rng: np.random.Generator) -> list[Mesh]:
    """Return an oven with its window, and a hob of four plates."""
    black = Material(textures.plain(colour(26, 26, 28)), gloss=0.8, sharpness=90.0, infrared=0.1)
    body = steel(rng) if rng.random() < 0.5 else plastic(near(rng, (236, 234, 228), 4))
    y = (FRONT + 0.01, FRONT + 0.03)
    meshes = [
        block((x[0] + 0.002, x[1] - 0.002), y, z, body),
        block((x[0] + 0.07, x[1] - 0.07), (y[0] - 0.003, y[0]), (z[0] + 0.15, z[1] - 0.24), black),
        block((x[0] + 0.06, x[1] - 0.06), (y[0] - 0.035, y[0]), (z[1] - 0.19, z[1] - 0.17), body),
        block(
            (x[0] + 0.03, x[1] - 0.03), (FRONT + 0.06, BACK - 0.06), (HEIGHT, HEIGHT + 0.006), black
        ),
    ]
    plate = plastic(colour(66, 64, 64), gloss=0.4)
    meshes += [
        block((u - 0.014, u + 0.014), (y[0] - 0.02, y[0]), (z[1] - 0.09, z[1] - 0.06), plate)
        for u in np.linspace(x[0] + 0.1, x[1] - 0.1, 5)
    ]
    for u in (x[0] + 0.18, x[1] - 0.18):
        for v in (FRONT + 0.2, BACK - 0.2):
            disc = shapes.disc(0.085, plate, lift=HEIGHT + 0.0065)
            meshes.append(disc.moved(standing(u, v)))
    return meshes


def _upper_cupboard(x: tuple[float, float], top: float, look: Look) -> list[Mesh]:
    y, z = (BACK - UPPER_DEPTH + THICKNESS, BACK), (UPPER_BOTTOM, top)
    return [block(x, y, z, look.body, spacing=0.2), *fronts(x, z, y[0], 1, 1, look)]


def _free_tops(kinds: list[str], half: float) -> tuple[Top, ...]:
    """Return the stretches of worktop without sink and stove."""
    tops = []
    for kind, run in groupby(enumerate(kinds), key=lambda unit: unit[1]):
        numbers = [number for number, _ in run]
        if kind == "cupboard":
            left, right = numbers[0] * UNIT - half, (numbers[-1] + 1) * UNIT - half
            tops.append(Top(HEIGHT, (left + 0.02, FRONT + 0.02, right - 0.02, BACK - 0.03)))
    return tuple(tops)
