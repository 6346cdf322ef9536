"""Boards and bars, given by their corners, and their grain: what furniture is built of."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import shapes
from curiosight.rooms.mesh import Material, Mesh, standing

Range = tuple[float, float]


def block(x: Range, y: Range, z: Range, material: Material, *, spacing: float = 0.3) -> Mesh:
    """Return the box between two planes along each axis, metres."""
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    body = shapes.box(size, material, spacing=spacing, lift=z[0])
    return body.moved(standing((x[0] + x[1]) / 2, (y[0] + y[1]) / 2))


def frame(x: Range, y: Range, z: Range, width: float, material: Material) -> tuple[Mesh, ...]:
    """Return four bars of a width around an upright rectangle, inside of it."""
    left, right = (x[0], x[0] + width), (x[1] - width, x[1])
    inner = (x[0] + width, x[1] - width)
    return (
        block(left, y, z, material),
        block(right, y, z, material),
        block(inner, y, (z[0], z[0] + width), material),
        block(inner, y, (z[1] - width, z[1]), material),
    )


def upright_grain(wood: Material) -> Material:
    """Return a material whose grain runs up and down, as on doors and legs."""
    texture = np.ascontiguousarray(wood.texture.transpose(1, 0, 2))
    return Material(texture, wood.tile[::-1], wood.gloss, wood.sharpness, infrared=wood.infrared)
