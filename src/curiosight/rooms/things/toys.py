"""What children leave about."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import textures
from curiosight.rooms.materials import (
    chrome,
    colour,
    near,
    plastic,
    rubber,
    shade,
    shining,
    timber,
)
from curiosight.rooms.mesh import Material, Mesh, Texture, join
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, ellipsoid, tube
from curiosight.rooms.shapes import box, rounded_box
from curiosight.rooms.surfaces import Points, scaled, stretched, turned, unit, warped
from curiosight.rooms.things.kind import ANYWHERE, FLOOR, TABLE, Kind, assembled, at

Triple = tuple[float, float, float]

GOLDEN = (1 + 5**0.5) / 2


def draw_ball(rng: np.random.Generator) -> Mesh:
    """Return a football, a basketball, or a ball of coloured segments."""
    draw_cover = (_beach_ball, _football, _football, _basketball)[rng.integers(4)]
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
    fur = Material(textures.carpet(rng, hue), (0.4, 0.4))
    pale = Material(textures.carpet(rng, shade(hue, 1.3)), (0.4, 0.4))
    black = plastic(colour(24, 22, 22), 0.5)
    ear = (0.1, 0.06, 0.36) if rng.random() < 0.35 else (0.16, 0.08, 0.16)
    # Radii, centre, material; in units of the bear's size.
    blobs: list[tuple[Triple, Triple, Material]] = [
        ((0.5, 0.42, 0.55), (0, 0, 0.52), fur),
        ((0.34, 0.3, 0.36), (0, -0.16, 0.5), pale),
        ((0.4, 0.36, 0.36), (0, -0.02, 1.3), fur),
        ((0.18, 0.16, 0.13), (0, -0.34, 1.22), pale),
        ((0.06, 0.05, 0.045), (0, -0.49, 1.27), black),
    ]
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
        n_around = 8 if max(radii) < 0.1 else 14
        blob = ellipsoid(radii, stuff, n_around=n_around)
        parts.append(at(blob, centre[0], centre[1], centre[2] - radii[2]))
    return assembled([scaled(part, size) for part in parts])


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
    """Return a car or a lorry on four wheels, its front towards -x."""
    paint = plastic(draw_colour(rng, vivid=0.85), 0.45)
    window = plastic(colour(40, 48, 58), 0.7)
    body = rounded_box((1, 0.46, 0.2), 0.04, paint, lift=0.084, spacing=0.3)
    if rng.random() < 0.5:
        top = _lorry_top(paint, window, plastic(draw_colour(rng, vivid=0.85)))
    else:
        top = _car_top(paint, window)
    light = plastic(colour(240, 230, 190), 0.6)
    lamp = ellipsoid((0.02, 0.03, 0.03), light, n_around=10, lift=0.17)
    lamps = [at(lamp, -0.5, y) for y in (-0.15, 0.15)]
    whole = join([body, *top, *_wheels(chrome(rng)), *lamps])
    return assembled([scaled(whole, rng.uniform(0.16, 0.34))])


def _lorry_top(paint: Material, window: Material, load: Material) -> list[Mesh]:
    bed = box((0.6, 0.46, 0.22), load, lift=0.274, spacing=0.3)
    cab = rounded_box((0.28, 0.46, 0.24), 0.03, paint, lift=0.274, spacing=0.3)
    sides = box((0.2, 0.465, 0.1), window, lift=0.36, spacing=0.3)
    front = box((0.03, 0.37, 0.1), window, lift=0.36, spacing=0.3)
    return [at(bed, 0.18, 0), at(cab, -0.34, 0), at(sides, -0.34, 0), at(front, -0.475, 0)]


def _car_top(paint: Material, window: Material) -> list[Mesh]:
    def slanted(points: Points) -> Points:
        share = 1 - 0.25 * np.clip((points[:, 2] - 0.274) / 0.16, 0, 1)
        return stretched(points, x=share, y=share**0.5)

    cabin = warped(box((0.55, 0.405, 0.16), window, lift=0.274, spacing=0.3), slanted)
    roof = rounded_box((0.4, 0.37, 0.03), 0.012, paint, lift=0.424, spacing=0.3)
    return [at(cabin, 0.05, 0), at(roof, 0.05, 0)]


def _wheels(hub: Material) -> list[Mesh]:
    tyre = at(cylinder(0.12, 0.07, rubber(), n_around=20, spacing=0.2), 0, 0, -0.07)
    cap = at(cylinder(0.06, 0.075, hub, n_around=12, spacing=0.2), 0, 0, -0.07)
    wheel = join([tyre, cap])
    return [
        wheel.moved(turned((1, 0, 0), -side * np.pi / 2, (x, side * 0.25, 0.12)))
        for x in (-0.3, 0.3)
        for side in (-1, 1)
    ]


def draw_robot(rng: np.random.Generator) -> Mesh:
    """Return a toy robot with lit eyes."""
    size = rng.uniform(0.2, 0.34)
    paint = plastic(draw_colour(rng, vivid=0.7), 0.4)
    trim = plastic(draw_colour(rng, vivid=0.7), 0.3)
    metal = chrome(rng)
    glow = shining(draw_colour(rng, vivid=1.0), 1.2)
    parts = [
        rounded_box((0.44, 0.3, 0.36), 0.04, paint, lift=0.34, spacing=0.2),
        rounded_box((0.3, 0.26, 0.22), 0.04, trim, lift=0.75, spacing=0.2),
        cylinder(0.06, 0.06, metal, n_around=12, lift=0.69),
        at(box((0.26, 0.01, 0.16), metal, lift=0.46), 0, -0.152),
        tube([(0, 0, 0.96), (0, 0, 1.08)], 0.012, metal, n_around=6),
        ellipsoid((0.03, 0.03, 0.03), glow, n_around=10, lift=1.07),
    ]
    arm = [(0.22, 0, 0.62), (0.32, -0.02, 0.5), (0.32, -0.14, 0.4)]
    dial = cylinder(0.035, 0.02, glow, n_around=12, spacing=0.2).moved(turned((1, 0, 0), np.pi / 2))
    for side in (-1, 1):
        parts += [
            at(dial, side * 0.07, -0.125, 0.87),
            at(dial, side * 0.06, -0.155, 0.54),
            at(rounded_box((0.15, 0.26, 0.1), 0.03, trim), side * 0.12, -0.03),
            at(cylinder(0.055, 0.28, metal, n_around=12, spacing=0.2), side * 0.12, 0, 0.08),
            tube(np.array(arm) * [side, 1, 1], 0.04, metal, n_around=8),
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
