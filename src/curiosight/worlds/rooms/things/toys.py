"""What children leave about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from curiosight.worlds.rooms import textures
from curiosight.worlds.rooms.mesh import Material, Mesh, Texture
from curiosight.worlds.rooms.palette import draw_colour
from curiosight.worlds.rooms.shapes import box, cylinder, ellipsoid, rounded_box, tube
from curiosight.worlds.rooms.surfaces import Points, scaled, turned, unit, warped
from curiosight.worlds.rooms.things.kind import ANYWHERE, FLOOR, TABLE, Kind, assembled, at
from curiosight.worlds.rooms.things.materials import (
    chrome,
    colour,
    near,
    plastic,
    rubber,
    shade,
    shining,
    timber,
)

Radii = tuple[float, float, float]

GOLDEN = (1 + 5**0.5) / 2


def draw_ball(rng: np.random.Generator) -> Mesh:
    """Return a football, a basketball, or a ball of coloured segments."""
    draw_cover = (_football, _basketball, _beach_ball)[rng.integers(3)]
    radius = rng.uniform(0.09, 0.125)
    cover = Material(draw_cover(rng), gloss=0.2, sharpness=20.0)
    ball = at(ellipsoid((radius,) * 3, cover, n_around=32), 0, 0, -radius)
    turn = turned(rng.normal(size=3), rng.uniform(0, np.pi))
    # Its lowest facet, turned anyhow, is not quite as low as its radius.
    return assembled([ball.moved(turn)])


def _directions(shape: tuple[int, int]) -> Points:
    """Return (h, w, 3) unit vectors of a texture that covers a sphere once."""
    around = (np.arange(shape[1]) + 0.5) / shape[1] * 2 * np.pi
    polar = ((np.arange(shape[0]) + 0.5) / shape[0] * np.pi)[:, None]
    x, y, z = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)
    return np.stack([x, y, np.broadcast_to(z, x.shape)], -1)


def _football(rng: np.random.Generator) -> Texture:
    signs = np.array([(a, b) for a in (-1, 1) for b in (-1, 1)], float)
    corner = np.column_stack([np.zeros(4), signs * [1, GOLDEN]])
    pentagons = unit(np.concatenate([np.roll(corner, k, axis=1) for k in range(3)]))
    inverse = np.column_stack([np.zeros(4), signs * [1 / GOLDEN, GOLDEN]])
    cube = np.array([(a, *pair) for a in (-1, 1) for pair in signs])
    hexagons = unit(np.concatenate([cube, *(np.roll(inverse, k + 1, axis=1) for k in range(3))]))
    directions = _directions((128, 256))
    nearest_pentagon = (directions @ pentagons.T).max(-1)
    by_hexagon = np.sort(directions @ hexagons.T, axis=-1)
    is_pentagon = nearest_pentagon > by_hexagon[..., -1] + 0.012
    is_seam = (by_hexagon[..., -1] - by_hexagon[..., -2] < 0.016) & ~is_pentagon
    dark, light = near(rng, (34, 34, 38)), near(rng, (234, 234, 230), 4)
    patch = dark if rng.random() < 0.6 else draw_colour(rng, vivid=1.0)
    image = np.where(is_pentagon[..., None], patch, light)
    return np.where(is_seam[..., None], shade(light, 0.45), image).astype(np.uint8)


def _basketball(rng: np.random.Generator) -> Texture:
    directions = _directions((128, 256))
    x, y, z = np.moveaxis(directions, -1, 0)
    curved = np.abs(np.abs(x) - 0.55 - 0.35 * z**2)
    is_line = (np.abs(y) < 0.02) | (np.abs(z) < 0.02) | (curved < 0.022)
    pebbles = textures.plaster(rng, near(rng, (196, 98, 44), 12))[::2]
    return np.where(is_line[..., None], np.uint8(30), pebbles).astype(np.uint8)


def _beach_ball(rng: np.random.Generator) -> Texture:
    n_colours = int(rng.integers(2, 5))
    colours = np.array([draw_colour(rng, vivid=0.8) for _ in range(n_colours)])
    segment = np.arange(240) * 2 * n_colours // 240 % n_colours
    image = np.broadcast_to(colours[segment], (128, 240, 3)).copy()
    image[:10] = image[-10:] = 232
    return image


def draw_teddy(rng: np.random.Generator) -> Mesh:
    """Return a sitting bear, or a rabbit by its ears."""
    size = rng.uniform(0.11, 0.17)
    hue = near(
        rng, ((150, 104, 62), (196, 160, 116), (120, 84, 62), (200, 196, 188))[rng.integers(4)], 12
    )
    fur = Material(textures.carpet(rng, hue), (0.25, 0.25))
    pale = Material(textures.carpet(rng, shade(hue, 1.3)), (0.25, 0.25))
    black = plastic(colour(24, 22, 22), 0.5)
    is_rabbit = rng.random() < 0.35
    ear = (0.1, 0.06, 0.36) if is_rabbit else (0.16, 0.08, 0.16)
    # Radii, centre, material; in units of the bear's size.
    blobs: list[tuple[Radii, Radii, Material]] = [
        ((0.5, 0.42, 0.55), (0, 0, 0.52), fur),
        ((0.34, 0.3, 0.36), (0, -0.16, 0.5), pale),
    ]
    blobs += [
        ((0.4, 0.36, 0.36), (0, -0.02, 1.3), fur),
        ((0.18, 0.16, 0.13), (0, -0.34, 1.22), pale),
    ]
    blobs += [((0.06, 0.05, 0.045), (0, -0.49, 1.27), black)]
    for side in (-1, 1):
        blobs += [
            (ear, (side * 0.24, 0.02, 1.62 + ear[2] / 3), fur),
            ((0.04, 0.03, 0.045), (side * 0.15, -0.34, 1.4), black),
            ((0.15, 0.3, 0.15), (side * 0.5, -0.22, 0.72), fur),
            ((0.18, 0.36, 0.18), (side * 0.32, -0.5, 0.18), fur),
            ((0.14, 0.05, 0.15), (side * 0.32, -0.84, 0.2), pale),
        ]
    parts = []
    for radii, centre, stuff in blobs:
        n_around = 10 if max(radii) < 0.1 else 16
        blob = _tiled(ellipsoid(radii, stuff, n_around=n_around), 3.0)
        parts.append(at(blob, centre[0], centre[1], centre[2] - radii[2]))
    return assembled([scaled(part, size) for part in parts])


def _tiled(mesh: Mesh, repeats: float) -> Mesh:
    """Return the mesh with its uv stretched to this part of a metre."""
    return replace(mesh, uv=(mesh.uv * np.float32(0.25 * repeats)))


def draw_block_tower(rng: np.random.Generator) -> Mesh:
    """Return wooden building blocks, piled by a child."""
    side = rng.uniform(0.04, 0.055)
    parts = []
    level = 0.0
    for _ in range(int(rng.integers(3, 7))):
        paint = plastic(draw_colour(rng, vivid=0.85)) if rng.random() < 0.75 else timber(rng)
        width = side * rng.choice([1, 1, 2])
        block = rounded_box((width, side, side), 0.003, paint, n_bevel=1)
        x, y, turn = rng.normal(0, [0.1 * side, 0.1 * side, 0.2])
        parts.append(at(block, x, y, level, turn))
        level += side
    if rng.random() < 0.6:
        roof = cylinder(0.7 * side, side, plastic(draw_colour(rng, vivid=0.9)), top_radius=0.002)
        parts.append(at(roof, 0, 0, level))
    for angle in rng.uniform(0, 2 * np.pi, int(rng.integers(0, 4))):
        paint = plastic(draw_colour(rng, vivid=0.85))
        x, y = 2.2 * side * np.cos(angle), 2.2 * side * np.sin(angle)
        parts.append(at(rounded_box((side,) * 3, 0.003, paint, n_bevel=1), x, y, 0, angle))
    return assembled(parts)


def draw_toy_car(rng: np.random.Generator) -> Mesh:
    """Return a car or a lorry on four wheels."""
    length = rng.uniform(0.16, 0.34)
    width, wheel = 0.46 * length, 0.12 * length
    paint, window = plastic(draw_colour(rng, vivid=0.85), 0.45), plastic(colour(40, 48, 58), 0.7)
    is_lorry = rng.random() < 0.5
    body = rounded_box((length, width, 0.2 * length), 0.04 * length, paint, lift=0.7 * wheel)
    floor = 0.7 * wheel + 0.19 * length
    if is_lorry:
        bed = box(
            (0.6 * length, width, 0.22 * length), plastic(draw_colour(rng, vivid=0.85)), lift=floor
        )
        cab = rounded_box((0.28 * length, width, 0.24 * length), 0.03 * length, paint, lift=floor)
        glazing = box(
            (0.2 * length, 1.01 * width, 0.1 * length), window, lift=floor + 0.09 * length
        )
        front = at(
            box((0.03 * length, 0.8 * width, 0.1 * length), window, lift=floor + 0.09 * length),
            -0.475 * length,
            0,
        )
        top = [
            at(bed, 0.18 * length, 0),
            at(cab, -0.34 * length, 0),
            at(glazing, -0.34 * length, 0),
            front,
        ]
    else:
        cabin = box((0.55 * length, 0.88 * width, 0.16 * length), window, lift=floor)
        roof = rounded_box(
            (0.4 * length, 0.8 * width, 0.03 * length),
            0.012 * length,
            paint,
            lift=floor + 0.15 * length,
        )

        def slanted(points: Points) -> Points:
            share = 1 - 0.25 * np.clip((points[:, 2:] - floor) / (0.16 * length), 0, 1)
            return points * np.concatenate([share, share**0.5, np.ones_like(share)], 1)

        top = [at(warped(cabin, slanted), 0.05 * length, 0), at(roof, 0.05 * length, 0)]
    hub = chrome(rng)
    parts = [body, *top]
    for x in (-0.3, 0.3):
        for side in (-1, 1):
            lying = turned(
                (1, 0, 0), side * np.pi / 2, (x * length, side * (width / 2 - 0.05 * length), wheel)
            )
            tyre = cylinder(wheel, 0.07 * length, rubber(), n_around=20)
            cap = cylinder(0.5 * wheel, 0.075 * length, hub, n_around=12)
            parts += [at(part, 0, 0, -0.07 * length).moved(lying) for part in (tyre, cap)]
    lamp = ellipsoid(
        (0.02 * length, 0.03 * length, 0.03 * length),
        plastic(colour(240, 230, 190), 0.6),
        n_around=10,
    )
    parts += [at(lamp, -0.5 * length, y * width, wheel + 0.05 * length) for y in (-0.33, 0.33)]
    return assembled(parts)


def draw_robot(rng: np.random.Generator) -> Mesh:
    """Return a toy robot with lit eyes."""
    size = rng.uniform(0.2, 0.34)
    paint, trim = (
        plastic(draw_colour(rng, vivid=0.7), 0.4),
        plastic(draw_colour(rng, vivid=0.7), 0.3),
    )
    metal = chrome(rng)
    glow = shining(draw_colour(rng, vivid=1.0), 1.2)
    parts = [
        rounded_box((0.44, 0.3, 0.36), 0.04, paint, lift=0.34),
        rounded_box((0.3, 0.26, 0.22), 0.04, trim, lift=0.75),
        cylinder(0.06, 0.06, metal, n_around=12, lift=0.69),
        at(box((0.26, 0.01, 0.16), metal, lift=0.46), 0, -0.152),
        tube([(0, 0, 0.96), (0, 0, 1.08)], 0.012, metal, n_around=6),
        ellipsoid((0.03, 0.03, 0.03), glow, n_around=10, lift=1.07),
    ]
    dial = cylinder(0.035, 0.02, glow, n_around=12).moved(turned((1, 0, 0), np.pi / 2))
    for side in (-1, 1):
        parts += [
            at(dial, side * 0.07, -0.125, 0.87),
            at(dial, side * 0.06, -0.155, 0.54),
            at(rounded_box((0.15, 0.26, 0.1), 0.03, trim), side * 0.12, -0.03),
            at(cylinder(0.055, 0.28, metal, n_around=12), side * 0.12, 0, 0.08),
            tube(
                [(side * 0.22, 0, 0.62), (side * 0.32, -0.02, 0.5), (side * 0.32, -0.14, 0.4)],
                0.04,
                metal,
                n_around=8,
            ),
            at(ellipsoid((0.055, 0.055, 0.055), trim, n_around=12), side * 0.32, -0.16, 0.34),
        ]
    return assembled([scaled(part, size) for part in parts])


KINDS = (
    Kind("ball", draw_ball, FLOOR),
    Kind("teddy", draw_teddy, ANYWHERE),
    Kind("building blocks", draw_block_tower, ANYWHERE),
    Kind("toy car", draw_toy_car, ANYWHERE),
    Kind("toy robot", draw_robot, TABLE),
)
