"""What is packed to go out."""

from __future__ import annotations

import numpy as np

from curiosight.rooms.materials import (
    black_plastic,
    chrome,
    cloth,
    colour,
    leather,
    near,
    plastic,
    shade,
)
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, tube
from curiosight.rooms.shapes import box, panel, rounded_box
from curiosight.rooms.surfaces import Points, arc, scaled, stretched, turned, warped
from curiosight.rooms.things.kind import ANYWHERE, FLOOR, Kind, assembled, at


def draw_suitcase(rng: np.random.Generator) -> Mesh:
    """Return a trolley case with its handle out, standing on wheels."""
    width, depth, height = rng.uniform(0.36, 0.46), rng.uniform(0.2, 0.27), rng.uniform(0.5, 0.66)
    hue = draw_colour(rng, vivid=0.6)
    shell, black = plastic(hue, 0.35), black_plastic(rng)
    parts = [
        rounded_box((width, depth, height), 0.05, shell, lift=0.05, n_bevel=3),
        box((1.003 * width, 0.012, 0.8 * height), black, lift=0.05 + 0.1 * height),
    ]
    tall, groove = (0, 0, 0.76 * height), plastic(shade(hue, 0.5), 0.0)
    line = panel((-0.003, -depth / 2 - 0.001, 0.05 + 0.12 * height), (0.006, 0, 0), tall, groove)
    for x in np.linspace(-0.34, 0.34, int(rng.integers(4, 7))) * width:
        parts += [at(line, x, 0), at(line, x, 0, 0, np.pi)]
    top, pull = height + 0.03, rng.uniform(0.12, 0.3)
    x, y = 0.2 * width, 0.3 * depth
    bar = [(-x, y, top), (-x, y, top + pull), (x, y, top + pull), (x, y, top)]
    grip = rounded_box((0.45 * width, 0.026, 0.024), 0.01, black, lift=top + pull - 0.005)
    axle = turned((0, 1, 0), np.pi / 2, (-0.012, 0, 0.03))
    wheel = cylinder(0.03, 0.025, black, n_around=16).moved(axle)
    parts += [tube(bar, 0.009, chrome(rng), n_around=8), at(grip, 0, y)]
    parts += [at(wheel, sx * 2 * x, sy * 1.2 * y) for sx in (-1, 1) for sy in (-1, 1)]
    return assembled(parts)


def draw_backpack(rng: np.random.Generator) -> Mesh:
    """Return a rucksack that stands, with pockets and a loop."""
    width, depth, height = rng.uniform(0.28, 0.34), rng.uniform(0.15, 0.2), rng.uniform(0.4, 0.5)
    hue = draw_colour(rng, vivid=0.6)
    main = cloth(rng, hue)
    trim = cloth(rng, draw_colour(rng) if rng.random() < 0.5 else shade(hue, 0.6))
    zip_line = plastic(colour(30, 30, 32), 0.2)

    def slumped(points: Points) -> Points:
        level = np.clip(points[:, 2] / height, 0, 1)
        return stretched(points, x=1 - 0.22 * level**3, y=1 - 0.3 * level**2)

    pocket = rounded_box((0.7 * width, 0.4 * depth, 0.4 * height), 0.03, trim, lift=0.05)
    pouch = rounded_box((0.25 * depth, 0.6 * depth, 0.32 * height), 0.018, trim, lift=0.03)
    seam = arc(0.05, np.pi - 0.05, (0.38 * width, 0.24 * height), (0.0, 0.62 * height), 15)
    parts = [
        rounded_box((width, depth, height), 0.06, main, n_bevel=3),
        at(pocket, 0, -0.48 * depth),
        *(at(pouch, side * 0.5 * width, 0) for side in (-1, 1)),
        at(tube(seam, 0.004, zip_line, n_around=6), 0, -0.5 * depth),
    ]
    behind = np.array([(0.07, 0.3, 0.95), (0.1, 0.62, 0.7), (0.13, 0.5, 0.1)])
    strap = tube(behind * [1, depth, height], 0.014, trim, n_around=8)
    parts += [strap, scaled(strap, (-1, 1, 1))]
    bow = arc(0, np.pi, (0.05, 0.05), (0.0, height - 0.01))
    loop = at(tube(bow, 0.008, trim, n_around=8), 0, 0.3 * depth)
    return assembled([*(warped(part, slumped) for part in parts), loop])


def draw_handbag(rng: np.random.Generator) -> Mesh:
    """Return a handbag or a shopping bag with two handles."""
    width, depth, height = rng.uniform(0.26, 0.42), rng.uniform(0.1, 0.18), rng.uniform(0.2, 0.34)
    skin = leather(rng, draw_colour(rng, vivid=0.6)) if rng.random() < 0.6 else cloth(rng)
    metal = chrome(rng, (196, 170, 110))
    flare = rng.uniform(-0.25, 0.15)

    def shaped(points: Points) -> Points:
        level = np.clip(points[:, 2] / height, 0, 1)
        return stretched(points, x=1 + flare * level, y=1 - 0.6 * level**2)

    body = rounded_box((width, depth, height), 0.03, skin, n_bevel=3)
    bow = arc(0, np.pi, (0.24 * width, rng.uniform(0.09, 0.16)), (0.0, 0.92 * height), 13)
    strap = skin if rng.random() < 0.5 else leather(rng, near(rng, (96, 62, 40)))
    handle = tube(bow, 0.0075, strap, n_around=8)
    clasp = rounded_box((0.05, 0.012, 0.03), 0.005, metal, n_bevel=1, lift=0.6 * height)
    handles = [at(handle, 0, side * 0.2 * depth) for side in (-1, 1)]
    return assembled([warped(body, shaped), *handles, at(clasp, 0, -0.4 * depth)])


KINDS = (
    Kind("suitcase", draw_suitcase, FLOOR),
    Kind("backpack", draw_backpack, FLOOR),
    Kind("handbag", draw_handbag, ANYWHERE),
)
