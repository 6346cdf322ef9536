"""What a room's surfaces are made of: mostly quiet colours, and one accent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curiosight.rooms import textures
from curiosight.rooms.materials import near, plastic
from curiosight.rooms.mesh import Material
from curiosight.rooms.palette import Colour, draw_colour, draw_muted

FLOOR_WOODS = ((172, 132, 88), (146, 104, 64), (112, 80, 54), (190, 160, 120), (128, 118, 106))
WHITE = (240, 238, 232)


@dataclass(frozen=True, slots=True, eq=False)
class Finish:
    """The materials of a room.

    walls: one of each wall. panelling: of the walls up to `panelling_height` metres; None = as
    above. trim: of door frames, window frames and skirting.
    """

    floor: Material
    ceiling: Material
    walls: tuple[Material, ...]
    panelling: Material | None
    panelling_height: float
    trim: Material


def draw_finish(rng: np.random.Generator, n_walls: int) -> Finish:
    """Draw the materials of a room."""
    main = accent = _draw_wall(rng, pale(rng))
    panelling = _draw_panelling(rng) if rng.random() < 0.2 else None
    if panelling is None and rng.random() < 0.65:
        accent = _draw_wall(rng, draw_colour(rng, vivid=0.7))
    special = int(rng.integers(n_walls))
    white = near(rng, WHITE, 4)
    return Finish(
        floor=draw_floor(rng),
        ceiling=Material(textures.plaster(rng, near(rng, (244, 243, 240), 3)), (1.5, 1.5)),
        walls=tuple(accent if number == special else main for number in range(n_walls)),
        panelling=panelling,
        panelling_height=float(rng.uniform(0.9, 1.15)),
        trim=plastic(white if rng.random() < 0.75 else near(rng, (120, 84, 54)), gloss=0.15),
    )


def draw_floor(rng: np.random.Generator) -> Material:
    """Draw boards, tiles, carpet or linoleum."""
    kind = rng.choice(["boards", "tiles", "carpet", "linoleum"], p=[0.45, 0.2, 0.25, 0.1])
    if kind == "boards":
        wood = near(rng, FLOOR_WOODS[rng.integers(len(FLOOR_WOODS))])
        return Material(textures.planks(rng, wood), (1.9, 0.85), gloss=0.25, sharpness=14.0)
    rgb = near(rng, draw_muted(rng)) if rng.random() < 0.6 else draw_colour(rng)
    if kind == "tiles":
        side = float(rng.uniform(1.0, 1.8))
        return Material(textures.tiles(rng, rgb), (side, side), gloss=0.35, sharpness=30.0)
    if kind == "carpet":
        return Material(textures.carpet(rng, rgb), (0.7, 0.7))
    return Material(textures.speckled(rng, rgb), (0.6, 0.6), gloss=0.2, sharpness=14.0)


def pale(rng: np.random.Generator) -> Colour:
    """Draw a wall paint: white with a little of some colour."""
    tint = draw_colour(rng, vivid=0.5).astype(float)
    paint = np.asarray(WHITE) + rng.uniform(0.0, 0.3) * (tint - WHITE)
    return np.clip(np.rint(paint), 0, 250).astype(np.uint8)


def _draw_wall(rng: np.random.Generator, rgb: Colour) -> Material:
    if rng.random() < 0.75:
        return Material(textures.plaster(rng, rgb), (1.6, 1.6))
    side = float(rng.uniform(0.25, 0.55))
    lighter = np.clip(rgb * rng.uniform(0.75, 1.2), 0, 250).astype(np.uint8)
    if rng.random() < 0.6:
        return Material(textures.wallpaper(rng, [rgb, lighter]), (side, side))
    return Material(textures.stripes(rng, [rgb, lighter]), (side, side))


def _draw_panelling(rng: np.random.Generator) -> Material:
    kind = rng.integers(3)
    if kind == 0:
        rgb = draw_colour(rng, vivid=0.35)
        return Material(textures.tiles(rng, rgb, 6), (0.9, 0.9), gloss=0.4, sharpness=50.0)
    if kind == 1:
        wood = near(rng, FLOOR_WOODS[rng.integers(len(FLOOR_WOODS))])
        upright = np.ascontiguousarray(textures.planks(rng, wood).transpose(1, 0, 2))
        return Material(upright, (0.6, 2.0), gloss=0.15)
    return Material(textures.plaster(rng, draw_colour(rng, vivid=0.25)), (1.6, 1.6), gloss=0.1)
