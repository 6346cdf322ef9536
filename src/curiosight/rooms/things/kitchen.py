"""Things of a kitchen, but for what is bought packed."""

from __future__ import annotations

import numpy as np

from curiosight.rooms.materials import black_plastic, ceramic, near, plastic, steel, timber
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe, tube
from curiosight.rooms.surfaces import Points, arc, stretched, warped
from curiosight.rooms.things.kind import TABLE, Kind, assembled, at


def _cup_profile(base: float, brim: float, height: float, wall: float) -> list[tuple[float, float]]:
    belly = 0.35 * base + 0.65 * brim
    return [
        (0.0, 0.0),
        (base * 0.9, 0.0),
        (base, 0.03 * height),
        (belly, 0.4 * height),
        (brim, height),
        (brim - wall, height),
        (belly - wall, 0.4 * height),
        (base - wall, 0.08 * height),
        (0.0, 0.06 * height),
    ]


def draw_mug(rng: np.random.Generator) -> Mesh:
    """Return a mug with a handle, with a drink in it or empty."""
    radius, height = rng.uniform(0.04, 0.052), rng.uniform(0.09, 0.125)
    glaze = ceramic(rng, draw_colour(rng, vivid=0.7))
    profile = _cup_profile(radius * rng.uniform(0.75, 1.0), radius, height, 0.004)
    body = lathe(profile, glaze, n_around=24, fit=False)
    centre = (0.93 * radius, 0.52 * height)
    bow = arc(-np.pi / 2, np.pi / 2, (0.032, 0.3 * height), centre)
    handle = tube(bow, 0.0055, glaze, n_around=8)
    parts = [body, handle]
    if rng.random() < 0.6:
        drink = plastic(near(rng, (62, 36, 20)), 0.4)
        parts.append(cylinder(radius * 0.9, 0.002, drink, lift=0.8 * height))
    return assembled(parts)


def draw_bowl(rng: np.random.Generator) -> Mesh:
    """Return a wide bowl."""
    radius = rng.uniform(0.08, 0.15)
    height = radius * rng.uniform(0.5, 0.8)
    angles = np.linspace(0.15, np.pi / 2, 8)
    outside = np.stack([radius * np.sin(angles), height * (1 - np.cos(angles))], 1)
    inside = (outside * 0.95 + [0, 0.05 * height])[::-1]
    foot = [(0.0, 0.0), (0.4 * radius, 0.0), (0.4 * radius, 0.08 * height)]
    profile = np.concatenate([foot, outside[2:], inside[:-1], [[0.0, inside[-1, 1]]]])
    glaze = ceramic(rng, draw_colour(rng, vivid=0.6))
    return assembled([lathe(profile, glaze, fit=False)])


def draw_plates(rng: np.random.Generator) -> Mesh:
    """Return a stack of plates."""
    radius, gap = rng.uniform(0.1, 0.14), rng.uniform(0.012, 0.018)
    glaze = ceramic(rng, draw_colour(rng, vivid=0.35))
    profile = [(0, 0), (0.6, 0), (1, 0.16), (1, 0.2), (0.7, 0.12), (0.62, 0.04), (0, 0.04)]
    plate = lathe(np.array(profile) * radius, glaze, n_around=24, fit=False)
    offsets = rng.normal(0, 0.002, (int(rng.integers(3, 9)), 2))
    return assembled([at(plate, x, y, gap * i) for i, (x, y) in enumerate(offsets)])


def draw_teapot(rng: np.random.Generator) -> Mesh:
    """Return a round teapot: spout, handle and a lid with a knob."""
    radius = rng.uniform(0.07, 0.095)
    squat = rng.uniform(0.75, 1.0)
    glaze = ceramic(rng, draw_colour(rng, vivid=0.6))
    heights = np.linspace(-0.85, 0.8, 10)
    belly = np.stack([np.sqrt(1 - heights**2), squat * (heights + 0.85)], 1)
    top = belly[-1, 1]
    lid = [(0.5, top + 0.05), (0.3, top + 0.15), (0.08, top + 0.2)]
    knob = [(0.07, top + 0.24), (0.13, top + 0.31), (0.08, top + 0.38), (0, top + 0.39)]
    profile = [(0.0, 0.0), *belly, (0.56, top + 0.03), *lid, *knob]
    body = lathe(np.array(profile) * radius, glaze, n_around=28, fit=False)
    spout = np.array([(0.8, 0, 0.45), (1.15, 0, 0.6), (1.4, 0, 1.05), (1.7, 0, 1.35)])
    curve = arc(-np.pi / 2, np.pi / 2, (-0.55, 0.5), (-0.85, 0.85))
    scale = np.array([1, 1, squat]) * radius
    return assembled(
        [
            body,
            tube(spout * scale, np.array([0.26, 0.2, 0.13, 0.11]) * radius, glaze),
            tube(curve * scale, 0.09 * radius, glaze, n_around=8),
        ]
    )


def draw_pot(rng: np.random.Generator) -> Mesh:
    """Return a cooking pot with a lid and two handles, or a pan with a long one."""
    radius = rng.uniform(0.1, 0.14)
    is_pan = rng.random() < 0.4
    height = 0.05 if is_pan else radius * rng.uniform(0.9, 1.3)
    hue = draw_colour(rng, vivid=0.8)
    shell = steel(rng) if rng.random() < 0.5 else plastic(hue, 0.45)
    black = black_plastic(rng)
    rim = [(radius, height), (radius - 0.004, height)]
    if is_pan:
        profile = [(0, 0), (0.85 * radius, 0), *rim, (0.83 * radius, 0.005), (0, 0.005)]
        stick = [(0.95 * radius, 0, 0.04), (radius + 0.08, 0, 0.06), (radius + 0.19, 0, 0.07)]
        handle = tube(stick, [0.009, 0.011, 0.013], black)
        return assembled([lathe(profile, shell, fit=False), handle])
    profile = [(0, 0), (radius, 0), *rim, (radius - 0.004, height + 0.006)]
    profile += [(0.6 * radius, height + 0.025), (0, height + 0.03)]
    parts = [
        lathe(profile, shell, fit=False),
        at(cylinder(0.018, 0.025, black), 0, 0, height + 0.028),
    ]
    bow = arc(-np.pi / 2, np.pi / 2, (0.035, 0.04), (0.97 * radius, 0.0), 7)[:, [0, 2, 1]]
    grip = tube(bow, 0.006, shell if rng.random() < 0.5 else black, n_around=8)
    ear = at(grip, 0, 0, 0.75 * height)
    return assembled([*parts, ear, at(ear, 0, 0, 0, np.pi)])


def draw_fruit_bowl(rng: np.random.Generator) -> Mesh:
    """Return a bowl heaped with apples, oranges, lemons and bananas."""
    radius = rng.uniform(0.11, 0.15)
    height = 0.5 * radius
    wall = ceramic(rng, draw_colour(rng)) if rng.random() < 0.5 else timber(rng)
    profile = [(0, 0), (0.45, 0), (0.85, 0.22), (1, 0.5), (0.96, 0.5), (0.8, 0.25), (0, 0.06)]
    parts = [lathe(np.array(profile) * radius, wall, fit=False)]
    skins = ((186, 44, 38), (222, 128, 36), (226, 200, 62), (128, 168, 62))
    for ring_radius, level, n_fruits in ((0.52, 0.35, 5), (0.25, 0.95, 3)):
        for i in range(n_fruits):
            angle = 2 * np.pi * (i + rng.uniform(0, 0.3)) / n_fruits
            x, y = ring_radius * radius * np.cos(angle), ring_radius * radius * np.sin(angle)
            skin = plastic(near(rng, skins[rng.integers(len(skins))]), 0.2)
            size = 0.3 * radius * rng.uniform(0.9, 1.15)
            fruit = ellipsoid((size, size, 0.9 * size), skin, n_around=14)
            parts.append(at(fruit, x, y, level * height))
    if rng.random() < 0.6:
        parts.append(at(_banana(rng), 0, 0, 1.75 * height, rng.uniform(0, 6)))
    return assembled(parts)


def _banana(rng: np.random.Generator) -> Mesh:
    peel = plastic(near(rng, (224, 190, 60)), 0.1)
    path = arc(1.25 * np.pi, 1.8 * np.pi, (0.09, 0.09), (0.0, 0.09), 8)
    thickness = np.array([0.005, 0.013, 0.017, 0.018, 0.018, 0.016, 0.011, 0.004])
    return tube(path, thickness, peel, n_around=8)


def draw_jug(rng: np.random.Generator) -> Mesh:
    """Return a jug of earthenware or enamel with a lip and a handle."""
    radius, height = rng.uniform(0.055, 0.075), rng.uniform(0.17, 0.25)
    glaze = ceramic(rng, draw_colour(rng, vivid=0.5))
    shape = [(0, 0), (0.75, 0), (0.98, 0.25), (1, 0.4), (0.7, 0.75), (0.75, 1), (0.69, 1)]
    shape += [(0.64, 0.75), (0.9, 0.4), (0, 0.05)]
    body = lathe(np.array(shape) * [radius, height], glaze, fit=False)

    def with_lip(points: Points) -> Points:
        lifted = np.clip(points[:, 2] / height - 0.8, 0, 1)
        share = lifted * np.clip(-points[:, 0] / radius, 0, 1) ** 3
        return stretched(points, x=1 + 3 * share, y=1 - share)

    bow = arc(-np.pi / 2, np.pi / 2, (0.05, 0.3 * height), (0.68 * radius, 0.63 * height))
    return assembled([warped(body, with_lip), tube(bow, 0.008, glaze)])


KINDS = (
    Kind("mug", draw_mug, TABLE),
    Kind("bowl", draw_bowl, TABLE),
    Kind("plates", draw_plates, TABLE),
    Kind("teapot", draw_teapot, TABLE),
    Kind("pot", draw_pot, TABLE),
    Kind("fruit bowl", draw_fruit_bowl, TABLE),
    Kind("jug", draw_jug, TABLE),
)
