"""What else stands about in a home."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from curiosight.rooms.materials import (
    black_plastic,
    chrome,
    cloth,
    colour,
    leather,
    near,
    plastic,
    printed,
    rubber,
    shade,
    steel,
    timber,
)
from curiosight.rooms.mesh import Mesh, join
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, lathe, ring, tube
from curiosight.rooms.shapes import box, disc, extrude
from curiosight.rooms.surfaces import arc, scaled, sheet, turned
from curiosight.rooms.things.kind import ANYWHERE, FLOOR, Kind, assembled, at
from curiosight.rooms.things.packaging import wrapped_label
from curiosight.rooms.things.storage import tub


def draw_umbrella_stand(rng: np.random.Generator) -> Mesh:
    """Return a tall pot with furled umbrellas in it."""
    radius, height = rng.uniform(0.11, 0.14), rng.uniform(0.4, 0.5)
    wall = steel(rng) if rng.random() < 0.4 else plastic(draw_colour(rng), 0.3)
    parts = [tub(0.9 * radius, radius, height, wall)]
    for i in range(int(rng.integers(1, 4))):
        lean = turned((0, 1, 0), 0.13, (-0.05, 0, 0.03))
        parts.append(_umbrella(rng).moved(turned((0, 0, 1), 2.4 * i + 1) @ lean))
    return assembled(parts)


def _umbrella(rng: np.random.Generator) -> Mesh:
    silk, wood = cloth(rng, draw_colour(rng)), timber(rng)
    folds = [(0, 0), (0.012, 0.05), (0.05, 0.6), (0.042, 0.8), (0.014, 1), (0, 1)]
    length = rng.uniform(0.55, 0.65)
    furled = lathe(np.array(folds) * [1, length], silk, n_around=12, spacing=0.2, fit=False)
    crook = arc(np.pi, 0, (0.045, 0.045), (0.045, length + 0.08))
    handle = np.concatenate([[(0, 0, length - 0.01)], crook, [(0.09, 0, length + 0.05)]])
    return join([furled, tube(handle, 0.009, wood, n_around=8)])


def draw_watering_can(rng: np.random.Generator) -> Mesh:
    """Return a watering can with a rose."""
    radius = rng.uniform(0.07, 0.11)
    height = radius * rng.uniform(1.7, 2.1)
    wall = steel(rng) if rng.random() < 0.35 else plastic(draw_colour(rng, vivid=0.8), 0.3)
    inside = plastic(colour(40, 46, 48))
    spout = np.array([(0.9, 0, 0.3), (1.7, 0, 0.9), (2.4, 0, 1.75)]) * radius
    rose = cylinder(0.16 * radius, 0.35 * radius, wall, top_radius=0.36 * radius, n_around=16)
    centre = (-0.9 * radius, 0.72 * height)
    bow = arc(np.pi / 4, 1.62 * np.pi, (0.75 * radius, 0.48 * height), centre, 13)
    return assembled(
        [
            cylinder(radius, height, wall, top_radius=0.88 * radius, n_around=28),
            disc(0.7 * radius, inside, lift=height + 0.001),
            tube(spout, np.array([0.2, 0.16, 0.13]) * radius, wall),
            rose.moved(turned((0, 1, 0), 0.75, spout[-1] - [0.01, 0, 0.01])),
            tube(bow, 0.1 * radius, wall, n_around=8),
        ]
    )


def draw_shoes(rng: np.random.Generator) -> Mesh:
    """Return a pair of shoes or boots, side by side, not quite parallel."""
    shoe = _shoe(rng, rng.uniform(0.25, 0.3), rng.random() < 0.35)
    turns, shift = rng.normal(0, 0.2, 2), rng.normal(0, 0.02)
    return assembled([at(shoe, -0.065, 0, 0, turns[0]), at(shoe, 0.065, shift, 0, turns[1])])


def _shoe(rng: np.random.Generator, length: float, is_boot: bool) -> Mesh:
    """Return one shoe, its toe towards -y."""
    hue = draw_colour(rng, vivid=0.45)
    upper = leather(rng, hue) if rng.random() < 0.6 else cloth(rng, hue)
    sole = rubber() if rng.random() < 0.5 else plastic(near(rng, (222, 218, 206)), 0.1)
    lace, lining = plastic(near(rng, (220, 216, 206)), 0.0), plastic(shade(hue, 0.3), 0.0)
    # Half its width and its height from toe to heel, by the length.
    t = np.array([0, 0.04, 0.12, 0.28, 0.45, 0.6, 0.75, 0.9, 0.97, 1])
    widths = length * np.array([0.01, 0.09, 0.14, 0.165, 0.15, 0.13, 0.125, 0.115, 0.08, 0.01])
    heights = length * np.array([0.09, 0.15, 0.19, 0.22, 0.29, 0.34, 0.36, 0.37, 0.36, 0.34])
    angle = np.linspace(0, np.pi, 13)
    x = widths[:, None] * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.7
    z = heights[:, None] * np.sin(angle) ** 0.7
    y = np.broadcast_to((t[:, None] - 0.5) * length, x.shape)
    side = np.stack([widths, y[:, 0]], 1) * 1.06
    outline = np.concatenate([side, (side * [-1, 1])[::-1]])
    collar = [(0, 0.3), (0.105, 0.3), (0.11, 0.36 + 0.4 * is_boot), (0, 0.35 + 0.4 * is_boot)]
    ankle = lathe(np.array(collar[:3]) * length, upper, n_around=20, fit=False)
    opening = lathe(np.array(collar[2:]) * length, lining, n_around=20)
    parts = [at(sheet(np.stack([x, y, z], -1), upper), 0, 0, 0.012), extrude(outline, 0.02, sole)]
    parts += [at(scaled(part, (1, 1.3, 1)), 0, 0.3 * length, 0.012) for part in (ankle, opening)]
    for share in (0.36, 0.44, 0.52):
        z_lace = float(np.interp(share, t, heights)) + 0.01
        ends = [(-0.06 * length, (share - 0.5) * length, z_lace)]
        ends += [(0.06 * length, (share - 0.5) * length, z_lace)]
        parts.append(tube(ends, 0.004, lace, n_around=6))
    return assembled(parts)


def draw_cushion(rng: np.random.Generator) -> Mesh:
    """Return a cushion that lies on the floor, or leans."""
    width, depth, thick = rng.uniform(0.4, 0.52), rng.uniform(0.32, 0.48), rng.uniform(0.12, 0.17)
    cover = cloth(rng)
    # A sheet's uv run from 0 to 1: a smaller tile makes the cloth repeat in metres.
    cover = replace(cover, tile=(cover.tile[0] / width, cover.tile[1] / depth))
    u, v = np.meshgrid(np.linspace(-1, 1, 13), np.linspace(-1, 1, 13))
    bulge = thick / 2 * ((1 - u**4) * (1 - v**4)) ** 0.6
    pinch = 1 - 0.08 * (1 - np.abs(u * v))
    x, y = width / 2 * u * pinch, depth / 2 * v * pinch
    above, below = np.stack([x, y, bulge], -1), np.stack([-x, y, -bulge], -1)
    border = np.concatenate([above[0], above[1:-1, -1], above[-1, ::-1], above[-2:0:-1, 0]])
    piping = tube(border, 0.006, plastic(draw_colour(rng), 0.0), n_around=6, closed=True)
    whole = join([sheet(above, cover), sheet(below, cover), piping])
    return assembled([whole.moved(turned((1, 0, 0), 1.25)) if rng.random() < 0.4 else whole])


def draw_extinguisher(rng: np.random.Generator) -> Mesh:
    """Return a fire extinguisher with its hose."""
    radius, height = rng.uniform(0.065, 0.085), rng.uniform(0.4, 0.52)
    red, black = plastic(near(rng, (186, 30, 34)), 0.45), black_plastic(rng)
    profile = [(0, 0), (0.95, 0), (1, 0.03), (1, 0.74), (0.9, 0.82)]
    profile += [(0.6, 0.87), (0.3, 0.89), (0, 0.89)]
    body = lathe(np.array(profile) * [radius, height], red, n_around=28, fit=False)
    side, label = radius + 0.0006, printed(wrapped_label(rng), gloss=0.3)
    paper = lathe([(side, 0.3 * height), (side, 0.62 * height)], label)
    bend = [(0.3, 0, 0.95), (1.1, 0, 0.93), (1.45, 0, 0.75), (1.2, 0, 0.4), (1.12, 0, 0.2)]
    nozzle = [(1.12 * radius, 0, 0.21 * height), (1.1 * radius, 0, 0.06 * height)]
    valve = cylinder(0.022, 0.09 * height, chrome(rng, (190, 170, 110)), n_around=16)
    lever = box((0.1, 0.024, 0.012), black)
    return assembled(
        [
            body,
            cylinder(0.96 * radius, 0.03, black, n_around=28),
            at(paper, 0, 0, 0, np.pi / 2),
            at(valve, 0, 0, 0.88 * height),
            lever.moved(turned((0, 1, 0), -0.25, (-0.03, 0, 0.97 * height))),
            lever.moved(turned((0, 1, 0), 0.1, (-0.03, 0, 0.92 * height))),
            tube(np.array(bend) * [radius, 1, height], 0.011, black),
            tube(nozzle, [0.012, 0.02], black),
        ]
    )


def draw_guitar(rng: np.random.Generator) -> Mesh:
    """Return a guitar that leans in its stand."""
    lean = turned((1, 0, 0), np.pi / 2 - 0.22, (0, 0, 0.3))
    whole = join([_guitar(rng).moved(lean), *_guitar_stand()])
    return assembled([scaled(whole, rng.uniform(0.85, 1.0))])


def _guitar(rng: np.random.Generator) -> Mesh:
    """Return a guitar on its back, its neck towards y."""
    stains = ((206, 150, 84), (170, 84, 40), (60, 40, 32), (196, 172, 130))
    top, dark = timber(rng, near(rng, stains[rng.integers(4)])), timber(rng, colour(58, 38, 28))
    metal, hole = chrome(rng), plastic(colour(24, 18, 16), 0.0)
    wire = plastic(colour(120, 104, 84), 0.3)
    angle = np.linspace(0, 2 * np.pi, 44, endpoint=False)
    along = np.cos(angle)
    # Wide at the bottom, narrower at the shoulders, narrowest between them.
    half_width = np.sin(angle) * (0.226 - 0.04 * along + 0.1 * np.cos(2 * angle))
    outline = np.stack([-half_width, 0.235 * along], 1)
    parts = [
        extrude(outline, 0.095, top),
        extrude(1.02 * outline, 0.006, dark, lift=0.088),
        at(disc(0.045, hole, lift=0.0958), 0, 0.03),
        at(ring(0.048, 0.003, dark), 0, 0.03, 0.095),
        at(box((0.12, 0.022, 0.01), dark, lift=0.095), 0, -0.12),
        at(box((0.05, 0.5, 0.025), dark, lift=0.083), 0, 0.46),
        at(box((0.07, 0.16, 0.018), top, lift=0.08), 0, 0.78),
    ]
    string = tube([(0, -0.12, 0.106), (0, 0.72, 0.111)], 0.001, wire, n_around=4, spacing=1.0)
    peg = cylinder(0.008, 0.02, metal, n_around=8)
    parts += [at(string, x, 0) for x in np.linspace(-0.016, 0.016, 6)]
    parts += [at(peg, x, 0.73 + 0.045 * i, 0.08) for x in (-0.042, 0.042) for i in range(3)]
    return join(parts)


def _guitar_stand() -> list[Mesh]:
    black, apex = rubber(), (0.0, 0.13, 0.4)
    front = [(-0.2, -0.14, 0.01), (-0.12, 0.02, 0.16), apex, (0.12, 0.02, 0.16), (0.2, -0.14, 0.01)]
    hook = tube([(0, 0.02, 0.12), (0, -0.16, 0.1), (0, -0.17, 0.14)], 0.009, black)
    back = tube([apex, (0, 0.26, 0.01)], 0.01, black)
    return [tube(front, 0.01, black), back, at(hook, -0.09, 0), at(hook, 0.09, 0)]


KINDS = (
    Kind("umbrella stand", draw_umbrella_stand, FLOOR),
    Kind("watering can", draw_watering_can, ANYWHERE),
    Kind("shoes", draw_shoes, FLOOR),
    Kind("cushion", draw_cushion, FLOOR),
    Kind("extinguisher", draw_extinguisher, FLOOR),
    Kind("guitar", draw_guitar, FLOOR),
)
