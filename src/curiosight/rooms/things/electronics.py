"""Things with a display, a voice or a ticking."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import prints
from curiosight.rooms.materials import (
    black_plastic,
    chrome,
    colour,
    leather,
    near,
    plastic,
    steel,
    timber,
)
from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe, ring, tube
from curiosight.rooms.shapes import box, disc, panel, rounded_box
from curiosight.rooms.surfaces import Points, arc, turned
from curiosight.rooms.things.kind import ANYWHERE, TABLE, Kind, assembled, at

TO_FRONT = turned((1, 0, 0), np.pi / 2)


def draw_monitor(rng: np.random.Generator) -> Mesh:
    """Return a computer screen on its foot, with a picture on it or switched off."""
    width = rng.uniform(0.42, 0.6)
    height = 0.6 * width
    shell = black_plastic(rng) if rng.random() < 0.6 else plastic(near(rng, (190, 190, 188)))
    is_on = rng.random() < 0.6
    dark = plastic(colour(18, 18, 22), 0.6)
    face = Material(prints.screen(rng), emission=0.7, infrared=0.3) if is_on else dark
    edge, lift = 0.014, rng.uniform(0.08, 0.13)
    right, up = (width - 2 * edge, 0, 0), (0, 0, height - 2 * edge)
    screen = panel((edge - width / 2, -0.021, lift + edge), right, up, face, fit=True)
    foot = (0.24, 0.18, 0.012) if rng.random() < 0.5 else (0.32, 0.16, 0.015)
    return assembled(
        [
            box((width, 0.04, height), shell, lift=lift),
            screen,
            at(box((0.06, 0.03, lift + 0.1), shell), 0, 0.035),
            at(rounded_box(foot, 0.005, shell), 0, 0.02),
        ]
    )


def draw_laptop(rng: np.random.Generator) -> Mesh:
    """Return an open laptop computer."""
    width, depth = rng.uniform(0.3, 0.37), rng.uniform(0.21, 0.25)
    shell = steel(rng) if rng.random() < 0.5 else black_plastic(rng)
    keys = plastic(colour(30, 30, 34))
    key = box((0.0145, 0.0135, 0.003), keys, lift=0.018)
    columns, rows = np.arange(14) - 6.5, np.arange(5) - 2
    board = [at(key, 0.0185 * x, 0.018 * y + 0.2 * depth) for x in columns for y in rows]
    lid = box((width, 0.007, depth), shell)
    face = Material(prints.screen(rng), emission=0.7, infrared=0.3)
    right, up = (width - 0.03, 0, 0), (0, 0, depth - 0.03)
    screen = panel((0.015 - width / 2, -0.0045, 0.018), right, up, face, fit=True)
    hinge = turned((1, 0, 0), -rng.uniform(0.15, 0.5), (0, depth / 2, 0.016))
    pad = at(box((0.1, 0.06, 0.0008), plastic(colour(120, 120, 124)), lift=0.018), 0, -0.28 * depth)
    base = rounded_box((width, depth, 0.018), 0.004, shell)
    return assembled([base, *board, pad, lid.moved(hinge), screen.moved(hinge)])


def draw_speaker(rng: np.random.Generator) -> Mesh:
    """Return a loudspeaker box with two cones."""
    width = rng.uniform(0.13, 0.24)
    depth, height = width * rng.uniform(0.9, 1.2), width * rng.uniform(1.5, 1.9)
    shell = timber(rng) if rng.random() < 0.6 else plastic(draw_colour(rng, vivid=0.3))
    black = black_plastic(rng)
    cone = [(1, 0.0), (1, 0.008), (0.88, 0.014), (0.8, 0.004)]
    cone += [(0.3, -0.012), (0.2, 0.0), (0, 0.006)]
    rim = steel(rng)
    parts = [rounded_box((width, depth, height), 0.006, shell)]
    for radius, level in ((0.4 * width, 0.32 * height), (0.2 * width, 0.78 * height)):
        place = (0, -depth / 2 - 0.004, level)
        driver = lathe(np.array(cone) * [radius, 1], black, fit=False).moved(TO_FRONT)
        frame = ring(radius, 0.004, rim).moved(TO_FRONT)
        parts += [at(driver, *place), at(frame, *place)]
    return assembled(parts)


def draw_alarm_clock(rng: np.random.Generator) -> Mesh:
    """Return an alarm clock on two feet, with bells on top or without."""
    radius = rng.uniform(0.055, 0.085)
    paint = plastic(draw_colour(rng, vivid=0.8), 0.4)
    metal = chrome(rng, (196, 164, 92)) if rng.random() < 0.5 else chrome(rng)
    dial = plastic(near(rng, (236, 232, 220), 6), 0.3)
    front = [
        cylinder(radius, 0.05, paint, n_around=32),
        disc(0.9 * radius, dial, lift=0.0505),
        at(ring(0.95 * radius, 0.005, metal), 0, 0, 0.05),
        *_clock_hands(radius, plastic(colour(28, 28, 30)), rng.uniform(0, 2 * np.pi, 2)),
    ]
    legs = [
        tube([(0.5 * x, -0.025, -0.75 * radius), (0.65 * x, -0.025, -1.15 * radius)], 0.006, metal)
        for x in (-radius, radius)
    ]
    parts = [*(part.moved(TO_FRONT) for part in front), *legs]
    if rng.random() < 0.6:
        bell = ellipsoid((0.42 * radius, 0.42 * radius, 0.3 * radius), metal, n_around=16)
        crown = at(bell, 0, -0.025, radius)
        parts += [crown.moved(turned((0, 1, 0), lean)) for lean in (-0.6, 0.6)]
    return assembled(parts)


def _clock_hands(radius: float, ink: Material, angles: Points) -> list[Mesh]:
    """Return twelve marks, and two hands at these angles, on a clock that looks up."""
    mark = at(box((0.004, 0.012, 0.001), ink), 0, 0.78 * radius, 0.0507)
    parts = [at(mark, 0, 0, 0, hour * np.pi / 6) for hour in range(12)]
    for length, angle in zip((0.5 * radius, 0.72 * radius), angles, strict=True):
        hand = at(box((0.005, length, 0.001), ink), 0, length / 2, 0.052)
        parts.append(at(hand, 0, 0, 0, angle))
    return parts


def draw_headphones(rng: np.random.Generator) -> Mesh:
    """Return headphones that stand on their cups."""
    width, height = rng.uniform(0.15, 0.17), rng.uniform(0.15, 0.17)
    shell = black_plastic(rng) if rng.random() < 0.5 else plastic(draw_colour(rng), 0.3)
    pad = leather(rng, near(rng, (44, 42, 42), 6))
    bow = arc(0, np.pi, (width / 2, height - 0.05), (0.0, 0.05), 17)
    inner = (width / 2 - 0.006, height - 0.058)
    cushion = arc(np.pi / 4, 3 * np.pi / 4, inner, (0.0, 0.05))
    parts = [tube(bow, 0.007, shell, n_around=8), tube(cushion, 0.011, pad, n_around=8)]
    for side in (-1, 1):
        cup = ellipsoid((0.016, 0.037, 0.042), shell, n_around=20)
        soft = ring(0.03, 0.011, pad, n_around=20).moved(turned((0, 1, 0), np.pi / 2))
        parts += [
            at(cup, side * (width / 2 + 0.008), 0, 0.008),
            at(soft, side * (width / 2 - 0.012), 0, 0.05),
        ]
    return assembled(parts)


KINDS = (
    Kind("monitor", draw_monitor, TABLE),
    Kind("laptop", draw_laptop, TABLE),
    Kind("speaker", draw_speaker, ANYWHERE),
    Kind("headphones", draw_headphones, TABLE),
    Kind("alarm clock", draw_alarm_clock, TABLE),
)
