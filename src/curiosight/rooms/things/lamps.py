"""Lamps; their light is for the eye only, the room has lights of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from curiosight.rooms.materials import chrome, cloth, colour, plastic, shining, timber
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe, tube
from curiosight.rooms.surfaces import turned
from curiosight.rooms.things.kind import FLOOR, TABLE, Kind, assembled, at


def draw_desk_lamp(rng: np.random.Generator) -> Mesh:
    """Return a lamp with a jointed arm and a bell-shaped shade."""
    paint = plastic(draw_colour(rng, vivid=0.7), 0.35)
    metal = chrome(rng) if rng.random() < 0.5 else paint
    lower, upper = rng.uniform(0.18, 0.22), rng.uniform(0.16, 0.2)
    lean = rng.uniform(0.2, 0.45)
    knee = (lower * np.sin(lean), 0.0, 0.03 + lower * np.cos(lean))
    tip = (knee[0] - upper * np.cos(0.6), 0.0, knee[2] + upper * np.sin(0.6))
    bell = [(0.075, 0), (0.06, 0.03), (0.035, 0.065), (0.025, 0.1), (0, 0.105)]
    inside = [(0, 0.09), (0.03, 0.06), (0.055, 0.028), (0.072, 0)]
    head = lathe([*inside, *bell], paint, fit=False)
    glow = shining(colour(255, 236, 190), 1.0)
    bulb = ellipsoid((0.028, 0.028, 0.035), glow, n_around=12)
    pose = turned((0, 1, 0), 0.5, (tip[0] - 0.045, 0, tip[2] - 0.085))
    joint = ellipsoid((0.013, 0.013, 0.013), metal, n_around=12)
    return assembled(
        [
            cylinder(rng.uniform(0.075, 0.095), 0.02, paint, top_radius=0.07),
            tube([(0, 0, 0.01), knee], 0.006, metal, n_around=8),
            tube([knee, tip], 0.006, metal, n_around=8),
            at(joint, knee[0], 0, knee[2] - 0.013),
            head.moved(pose),
            bulb.moved(pose),
        ]
    )


def draw_floor_lamp(rng: np.random.Generator) -> Mesh:
    """Return a lamp with a cloth shade on a tall foot."""
    height, radius = rng.uniform(0.9, 1.25), rng.uniform(0.15, 0.21)
    metal = timber(rng) if rng.random() < 0.4 else chrome(rng, (150, 140, 120))
    linen = cloth(rng, draw_colour(rng, vivid=0.4))
    lit = replace(linen, emission=rng.choice([0.0, 0.5]))
    depth, top = rng.uniform(0.2, 0.28), rng.uniform(0.6, 0.95)
    low = height - depth
    glow = shining(colour(255, 240, 200), 1.0)
    hood = [(radius - 0.004, low), (radius, low)]
    hood += [(top * radius, height), (top * radius - 0.004, height)]
    return assembled(
        [
            cylinder(rng.uniform(0.12, 0.16), 0.025, metal),
            tube([(0, 0, 0.02), (0, 0, low / 2), (0, 0, height - 0.05)], 0.011, metal),
            lathe([*hood, hood[0]], lit, fit=False),
            ellipsoid((0.035, 0.035, 0.05), glow, lift=low + 0.04, n_around=12),
        ]
    )


KINDS = (
    Kind("desk lamp", draw_desk_lamp, TABLE),
    Kind("floor lamp", draw_floor_lamp, FLOOR),
)
