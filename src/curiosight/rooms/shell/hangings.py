"""What hangs on walls: pictures, notice boards, clocks, sockets. Eye-catching, but no objects.

Each mesh is drawn in a wall's frame, centred at x = 0, z = 0, its back at y = 0.
"""

from __future__ import annotations

import cv2
import numpy as np

from curiosight.rooms import pictures, prints, round_shapes, shapes, textures
from curiosight.rooms.blocks import Range, block, frame
from curiosight.rooms.materials import colour, near, plastic, printed, timber
from curiosight.rooms.mesh import Material, Mesh, Texture, join
from curiosight.rooms.palette import Colour, draw_colour
from curiosight.rooms.surfaces import turned

SHEET = 0.004


def picture_mesh(width: float, height: float, rng: np.random.Generator) -> Mesh:
    """Return a framed picture, or a poster without frame."""
    x, z = (-width / 2, width / 2), (-height / 2, height / 2)
    pixels = _pixels(width, height)
    if rng.random() < 0.35:
        draw = prints.book_cover if rng.random() < 0.6 else pictures.picture
        return _sheet(x, z, -SHEET, printed(draw(rng, pixels)))
    image = printed(pictures.picture(rng, pixels))
    bar, thickness = float(rng.uniform(0.015, 0.05)), float(rng.uniform(0.012, 0.022))
    mount = float(rng.choice([0.0, 0.06])) if min(width, height) > 0.4 else 0.0
    wood = timber(rng) if rng.random() < 0.5 else plastic(draw_colour(rng, vivid=0.3))
    inset = bar + mount
    paper = plastic(near(rng, (236, 233, 226), 4), gloss=0.0)
    return join(
        [
            *frame(x, (-thickness, 0.0), z, bar, wood),
            _sheet(x, z, -0.006, paper),
            _sheet((x[0] + inset, x[1] - inset), (z[0] + inset, z[1] - inset), -0.007, image),
        ]
    )


def notice_board_mesh(width: float, height: float, rng: np.random.Generator) -> Mesh:
    """Return a cork board full of papers."""
    cork = Material(textures.speckled(rng, near(rng, (178, 134, 88))), (0.2, 0.2))
    x, z = (-width / 2, width / 2), (-height / 2, height / 2)
    meshes = [_sheet(x, z, -0.008, cork), *frame(x, (-0.016, 0.0), z, 0.025, timber(rng))]
    for number in range(int(rng.integers(4, 10))):
        paper = rng.uniform(0.10, 0.22) * np.array((1.0, rng.uniform(0.7, 1.4)))
        u = float(rng.uniform(x[0] + 0.03, x[1] - 0.03 - paper[0]))
        v = float(rng.uniform(z[0] + 0.03, z[1] - 0.03 - paper[1]))
        draw = (prints.page, prints.label, prints.book_cover)[rng.integers(3)]
        lift = -0.009 - 0.0005 * number
        note = printed(draw(rng), gloss=0.0)
        meshes.append(_sheet((u, u + float(paper[0])), (v, v + float(paper[1])), lift, note))
    return join(meshes)


def clock_mesh(rng: np.random.Generator) -> Mesh:
    """Return a round wall clock."""
    radius = float(rng.uniform(0.12, 0.18))
    rim = plastic(draw_colour(rng, vivid=0.6))
    body = round_shapes.cylinder(radius, 0.025, rim)
    face = shapes.disc(0.9 * radius, printed(_clock_face(rng)), lift=0.026, fit=True)
    return join([body, face]).moved(turned((1, 0, 0), np.pi / 2))


def outlet_mesh(rng: np.random.Generator) -> Mesh:
    """Return a socket, or two side by side."""
    white = plastic(near(rng, (238, 236, 230), 4))
    hole = plastic(colour(52, 50, 48))
    meshes = []
    for x in (0.0, 0.078)[: int(rng.integers(1, 3))]:
        plate = block((x - 0.04, x + 0.04), (-0.009, 0.0), (-0.04, 0.04), white)
        cup = shapes.disc(0.022, hole).moved(turned((1, 0, 0), np.pi / 2, (x, -0.0095, 0)))
        meshes += [plate, cup]
    return join(meshes)


def switch_mesh(rng: np.random.Generator) -> Mesh:
    """Return a light switch."""
    white = plastic(near(rng, (238, 236, 230), 4))
    plate = block((-0.04, 0.04), (-0.008, 0.0), (-0.04, 0.04), white)
    rocker = block((-0.025, 0.025), (-0.013, -0.008), (-0.028, 0.028), white)
    return join([plate, rocker])


def _sheet(x: Range, z: Range, y: float, material: Material) -> Mesh:
    """Return a rectangle that faces the room at a depth y, its texture once on it."""
    return shapes.panel(
        (x[0], y, z[0]), (x[1] - x[0], 0, 0), (0, 0, z[1] - z[0]), material, spacing=0.3, fit=True
    )


def _pixels(width: float, height: float) -> tuple[int, int]:
    scale = 256 / max(width, height)
    return round(height * scale), round(width * scale)


def _clock_face(rng: np.random.Generator) -> Texture:
    ground: Colour = near(rng, (240, 238, 232), 4)
    face = np.broadcast_to(ground, (128, 128, 3)).copy()
    ink = (30, 30, 34)
    for hour in range(12):
        sin, cos = np.sin(hour * np.pi / 6), np.cos(hour * np.pi / 6)
        start, end = (
            (round(64 + 50 * sin), round(64 - 50 * cos)),
            (round(64 + 58 * sin), round(64 - 58 * cos)),
        )
        cv2.line(face, start, end, ink, 4 if hour % 3 == 0 else 2, cv2.LINE_AA)
    for length, width in ((30, 4), (46, 3)):
        angle = rng.uniform(0, 2 * np.pi)
        tip = (round(64 + length * np.sin(angle)), round(64 - length * np.cos(angle)))
        cv2.line(face, (64, 64), tip, ink, width, cv2.LINE_AA)
    return face
