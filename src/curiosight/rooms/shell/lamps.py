"""Lamps that hang from the ceiling, and the light they give."""

from __future__ import annotations

import numpy as np

from curiosight.frame import Pose
from curiosight.rooms import round_shapes, shapes
from curiosight.rooms.blocks import block
from curiosight.rooms.materials import colour, plastic, shining
from curiosight.rooms.mesh import Material, Mesh, join, standing
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.scene import Light
from curiosight.rooms.surfaces import turned

WARM = (1.0, 0.90, 0.76)
NEUTRAL = (1.0, 0.97, 0.92)


def draw_lamp(
    x: float, y: float, ceiling: float, power: float, rng: np.random.Generator
) -> tuple[Mesh, Light]:
    """Draw a pendant, a globe or a flat lamp at a place; power: radiance times square metres."""
    draw = (_pendant, _globe, _flat)[rng.integers(3)]
    mesh, side, bottom = draw(ceiling, rng)
    hue = np.asarray(WARM if rng.random() < 0.6 else NEUTRAL)
    light = Light(
        centre=np.array((x, y, bottom - 0.01)),
        along=np.array((side, 0.0, 0.0)),
        across=np.array((0.0, -side, 0.0)),
        rgb=power / side**2 * hue,
    )
    return mesh.moved(standing(x, y)), light


def _glow() -> Material:
    return shining(colour(255, 244, 224), 1.6)


def _cord(bottom: float, top: float) -> Mesh:
    black = plastic(colour(60, 60, 62))
    return round_shapes.cylinder(0.004, top - bottom, black, n_around=6, lift=bottom)


def _pendant(ceiling: float, rng: np.random.Generator) -> tuple[Mesh, float, float]:
    """Return a shade on a cord: its mesh, the side of its light, and its height."""
    radius, height = float(rng.uniform(0.19, 0.28)), float(rng.uniform(0.16, 0.26))
    bottom = ceiling - float(rng.uniform(0.5, 0.65))
    top = bottom + height
    waist = radius * float(rng.uniform(0.25, 0.9))
    paint = plastic(draw_colour(rng, vivid=0.5))
    shade = round_shapes.lathe([(radius, bottom), (waist, top), (0.0, top)], paint)
    bulb = shapes.disc(0.92 * radius, _glow()).moved(_facing_down(bottom + 0.02))
    cord = _cord(top, ceiling)
    return join([shade, bulb, cord]), 1.7 * radius, bottom


def _globe(ceiling: float, rng: np.random.Generator) -> tuple[Mesh, float, float]:
    """Return a paper ball on a cord."""
    radius = float(rng.uniform(0.18, 0.26))
    bottom = ceiling - 2 * radius - float(rng.uniform(0.12, 0.22))
    ball = round_shapes.ellipsoid((radius, radius, radius), _glow(), lift=bottom)
    top = bottom + 2 * radius
    cord = _cord(top, ceiling)
    return join([ball, cord]), 1.7 * radius, bottom


def _flat(ceiling: float, rng: np.random.Generator) -> tuple[Mesh, float, float]:
    """Return a square lamp under the ceiling."""
    half = float(rng.uniform(0.25, 0.32))
    bottom = ceiling - 0.09
    x = (-half, half)
    case = block(x, x, (bottom + 0.01, ceiling), plastic(colour(226, 226, 224)))
    inner = (-half + 0.02, half - 0.02)
    glass = block(inner, inner, (bottom, bottom + 0.01), _glow())
    return join([case, glass]), 2 * half - 0.04, bottom


def _facing_down(z: float) -> Pose:
    """Return the motion that turns what looks up to look down, at a height."""
    return turned((1.0, 0.0, 0.0), np.pi, (0.0, 0.0, z))
