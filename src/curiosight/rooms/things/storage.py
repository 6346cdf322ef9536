"""What other things are put into."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from curiosight.rooms import textures
from curiosight.rooms.materials import (
    black_plastic,
    chrome,
    cloth,
    colour,
    glass,
    near,
    plastic,
    shade,
    steel,
    timber,
)
from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe, ring, tube
from curiosight.rooms.shapes import box, rounded_box
from curiosight.rooms.surfaces import Points, arc, scaled, turned, warped
from curiosight.rooms.things.kind import ANYWHERE, FLOOR, Kind, assembled, at

THIN = 0.004


def tub(base: float, brim: float, height: float, wall: Material) -> Mesh:
    """Return an open round vessel with a rolled brim."""
    roll = 0.012
    profile = [(0, 0), (base, 0), (brim, height - roll), (brim + roll / 2, height - roll / 2)]
    profile += [(brim, height), (brim - THIN, height - roll), (base - THIN, THIN), (0, THIN)]
    return lathe(profile, wall, n_around=28, spacing=0.08, fit=False)


def draw_bucket(rng: np.random.Generator) -> Mesh:
    """Return a bucket, its bail hanging or raised."""
    brim, height = rng.uniform(0.13, 0.16), rng.uniform(0.24, 0.3)
    is_zinc = rng.random() < 0.3
    wall = steel(rng) if is_zinc else plastic(draw_colour(rng, vivid=0.75), 0.25)
    wire = chrome(rng)
    bow = arc(0, np.pi, (brim + 0.008, brim + 0.008), n_points=15)
    raise_by = rng.choice([0.0, np.pi / 2 + 0.15])
    hinge = turned((1, 0, 0), raise_by, (0, 0, height - 0.03))
    bail = tube(bow, 0.004, wire, n_around=6).moved(hinge)
    parts = [tub(0.72 * brim, brim, height, wall), bail]
    if rng.random() < 0.4:
        water = cylinder(0.93 * brim, 0.003, plastic(colour(96, 118, 128), 0.8), lift=0.75 * height)
        parts.append(water)
    return assembled(parts)


def draw_waste_bin(rng: np.random.Generator) -> Mesh:
    """Return a paper basket, or a bin with a pedal and a lid."""
    radius, height = rng.uniform(0.12, 0.17), rng.uniform(0.28, 0.42)
    if rng.random() < 0.5:
        hue = draw_colour(rng, vivid=0.4)
        cane = Material(textures.wicker(rng, hue), (0.12, 0.12))
        basket = tub(0.78 * radius, radius, height, cane if rng.random() < 0.3 else plastic(hue))
        return assembled([basket, *_crumpled_papers(rng, 0.7 * radius, 0.72 * height)])
    wall = chrome(rng) if rng.random() < 0.5 else plastic(draw_colour(rng), 0.4)
    black = black_plastic(rng)
    dome = [(1.0, 0.0), (1.01, 0.05), (0.9, 0.22), (0.5, 0.36), (0, 0.4)]
    lid = lathe(np.array(dome) * radius, wall, fit=False)
    pedal = rounded_box((0.07, 0.06, 0.014), 0.006, black, lift=0.01)
    return assembled(
        [
            cylinder(1.02 * radius, 0.025, black),
            cylinder(radius, height, wall, lift=0.02),
            cylinder(1.01 * radius, 0.02, black, lift=height + 0.01),
            at(lid, 0, 0, height + 0.03),
            at(pedal, 0, -radius - 0.025),
        ]
    )


def _crumpled_papers(rng: np.random.Generator, reach: float, level: float) -> list[Mesh]:
    papers = []
    for i in range(int(rng.integers(2, 6))):
        size = rng.uniform(0.035, 0.05)
        sheet = plastic(near(rng, (228, 226, 218), 10), 0.0)
        ball = warped(ellipsoid((size,) * 3, sheet, n_around=16), _creased(rng, size))
        x, y = 0.5 * reach * np.cos(2.4 * i), 0.5 * reach * np.sin(2.4 * i)
        papers.append(at(ball, x, y, level))
    return papers


def _creased(rng: np.random.Generator, size: float) -> Callable[[Points], Points]:
    """Return a map that dents a soft thing of this radius."""
    waves = rng.normal(0, 1.5 / size, (4, 3))

    def dented(points: Points) -> Points:
        dent: Points = 0.09 * np.sin(points @ waves.T).sum(1, keepdims=True)
        return points * (1 + dent)

    return dented


def _slatted(size: tuple[float, float, float], n_slats: int, wood: Material) -> list[Mesh]:
    """Return boards around an open crate, with posts in its corners and a floor."""
    width, depth, height = size
    board, pitch = 0.75 * height / n_slats, height / n_slats
    parts = [box((width, depth, 0.01), wood)]
    for i in range(n_slats):
        low = i * pitch + 0.005
        long = box((width, 0.01, board), wood, lift=low)
        short = box((0.01, depth, board), wood, lift=low)
        parts += [at(long, 0, side * depth / 2) for side in (-1, 1)]
        parts += [at(short, side * width / 2, 0) for side in (-1, 1)]
    post = box((0.025, 0.025, height), wood)
    x, y = width / 2 - 0.018, depth / 2 - 0.018
    return parts + [at(post, sx * x, sy * y) for sx in (-1, 1) for sy in (-1, 1)]


def draw_crate(rng: np.random.Generator) -> Mesh:
    """Return a wooden crate of slats or a stackable plastic one, sometimes with bottles in it."""
    size = rng.uniform(0.36, 0.5), rng.uniform(0.27, 0.36), rng.uniform(0.2, 0.3)
    width, depth, height = size
    is_wood = rng.random() < 0.55
    stuff = timber(rng) if is_wood else plastic(draw_colour(rng, vivid=0.85), 0.2)
    parts = _slatted(size, int(rng.integers(3, 5)) if is_wood else 2, stuff)
    if not is_wood:
        front = box((width + 0.03, 0.03, 0.03), stuff, lift=height - 0.02)
        side = box((0.03, depth + 0.03, 0.03), stuff, lift=height - 0.02)
        parts += [at(front, 0, y * depth / 2) for y in (-1, 1)]
        parts += [at(side, x * width / 2, 0) for x in (-1, 1)]
    if rng.random() < 0.5:
        bottle = _plain_bottle(rng)
        columns, rows = 0.22 * width * (np.arange(4) - 1.5), 0.29 * depth * (np.arange(3) - 1)
        parts += [at(bottle, x, y, 0.012) for x in columns for y in rows]
    return assembled(parts)


def _plain_bottle(rng: np.random.Generator) -> Mesh:
    stuff, cap = glass(near(rng, (52, 72, 44))), plastic(draw_colour(rng, vivid=0.8), 0.4)
    profile = [(0, 0), (0.034, 0), (0.034, 0.16), (0.014, 0.21), (0.013, 0.26), (0, 0.26)]
    body = lathe(profile, stuff, n_around=12, spacing=0.1, fit=False)
    return join([body, cylinder(0.015, 0.012, cap, n_around=10, lift=0.255)])


def draw_basket(rng: np.random.Generator) -> Mesh:
    """Return a wicker basket with a handle over it or two at its sides."""
    radius, height = rng.uniform(0.15, 0.22), rng.uniform(0.18, 0.34)
    tone = near(rng, ((176, 134, 84), (130, 92, 56), (206, 180, 140))[rng.integers(3)])
    cane = Material(textures.wicker(rng, tone), (0.16, 0.16))
    rope = plastic(shade(tone, 0.8), 0.0)
    oval = rng.uniform(0.7, 1.0)
    body = tub(0.8 * radius, radius, height, cane)
    brim = at(ring(radius, 0.011, rope), 0, 0, height - 0.004)
    parts = [scaled(part, (1, oval, 1)) for part in (body, brim)]
    if rng.random() < 0.5:
        bow = arc(0, np.pi, (radius, 0.9 * radius), (0.0, height - 0.01), 15)
        parts.append(tube(bow, 0.009, rope, n_around=8))
    else:
        ear = tube(arc(0, np.pi, (0.06, 0.05), (0.0, height - 0.01)), 0.008, rope, n_around=8)
        parts += [at(ear, side * 0.98 * radius, 0, 0, np.pi / 2) for side in (-1, 1)]
    if rng.random() < 0.4:
        laundry = cloth(rng)
        heap = ellipsoid((0.8 * radius, 0.8 * oval * radius, 0.2 * height), laundry)
        parts.append(at(warped(heap, _creased(rng, 0.6 * radius)), 0, 0, 0.75 * height))
    return assembled(parts)


KINDS = (
    Kind("bucket", draw_bucket, FLOOR),
    Kind("waste bin", draw_waste_bin, FLOOR),
    Kind("crate", draw_crate, FLOOR),
    Kind("basket", draw_basket, ANYWHERE),
)
