"""Surfaces that repeat: each (h, w, 3) uint8 sRGB without a seam, drawn by the generator.

Where a texture has a size of its own, its docstring names the length that one repeat covers.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from curiosight.rooms.mesh import Texture
from curiosight.rooms.noise import mixed, noise, shaded
from curiosight.rooms.palette import Colour

SIDE = 256


def plain(colour: Colour) -> Texture:
    """Return one even colour."""
    return np.broadcast_to(np.asarray(colour, np.uint8), (4, 4, 3)).copy()


def wood(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return sawn wood, its grain along u; about 0.6 m."""
    shape = (SIDE, SIDE)
    v = np.linspace(0, 1, SIDE, endpoint=False, dtype=np.float32)[:, None]
    years = rng.integers(5, 10) * v + rng.uniform(0.4, 0.8) * noise(rng, shape, (22, 70))
    rings = np.sin(2 * np.pi * years) ** 3
    fibres = noise(rng, shape, (0.7, 18))
    shade = 0.07 * rings + 0.05 * fibres + 0.04 * noise(rng, shape, (14, 60))
    return shaded(colour, shade * rng.uniform(0.6, 1.3))


def planks(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return a floor of boards, six rows along u; about 0.9 m."""
    side, n_rows = 2 * SIDE, 6
    rows = np.arange(side) * n_rows // side
    starts = rng.integers(0, side // 2, n_rows)[rows][:, None]
    along = (np.arange(side) + starts) % side
    board = 2 * rows[:, None] + along * 2 // side
    shade = 0.05 * noise(rng, (side, side), (0.7, 14)) + 0.04 * noise(rng, (side, side), (6, 60))
    shade = shade + rng.normal(0, 0.07, 2 * n_rows)[board]
    is_joint = (np.diff(rows, append=-1) != 0)[:, None] | (along % (side // 2) == 0)
    shade = np.where(is_joint, -0.4, shade)
    warmth = rng.normal(0, 4, 2 * n_rows)[board][..., None] * np.array([1, 0, -1])
    return shaded(np.asarray(colour) + warmth, shade)


def fabric(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return woven cloth; about 0.15 m."""
    shape = (128, 128)
    threads = np.sin(2 * np.pi * 32 * np.arange(128) / 128 + 0.4).astype(np.float32)
    weave = 0.07 * threads[:, None] * threads
    thick = 0.05 * noise(rng, shape, (0.6, 8)) + 0.05 * noise(rng, shape, (8, 0.6))
    return shaded(colour, weave + thick + 0.02 * noise(rng, shape, 10))


def carpet(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return a short pile, lightly flecked; about 0.5 m."""
    shape = (SIDE, SIDE)
    pile = 0.10 * noise(rng, shape, 0.7) + 0.05 * noise(rng, shape, 2.5)
    return shaded(colour, pile + 0.025 * noise(rng, shape, 25))


def plaster(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return a painted wall, not quite even; about 1.5 m."""
    shape = (SIDE, SIDE)
    rough = 0.012 * noise(rng, shape, 0.8) + 0.010 * noise(rng, shape, 4)
    return shaded(colour, rough + 0.012 * noise(rng, shape, 40))


def wallpaper(rng: np.random.Generator, colours: Sequence[Colour]) -> Texture:
    """Return one printed motif, half dropped, in the second colour on the first; about 0.4 m."""
    mask = np.zeros((SIDE, SIDE), np.uint8)
    n_petals, swing = int(rng.integers(3, 9)), rng.uniform(0.2, 0.9)
    angles = np.linspace(0, 2 * np.pi, 200)
    for size in (60.0, 40.0, 16.0):
        radius = size * (1 + swing * np.cos(n_petals * angles)) / (1 + swing)
        curve = np.stack((radius * np.cos(angles), 1.3 * radius * np.sin(angles)), 1) + SIDE / 2
        brightness = 0 if size == 40.0 else 255
        cv2.fillPoly(mask, [np.rint(curve * 16).astype(np.int32)], brightness, cv2.LINE_AA, 4)
    both = np.maximum(mask, np.roll(mask, (SIDE // 2, SIDE // 2), (0, 1)))
    paper = mixed(both.astype(np.float32) / 255, colours[0], colours[1])
    return shaded(paper, 0.012 * noise(rng, (SIDE, SIDE), 0.8))


def tiles(rng: np.random.Generator, colour: Colour, n_across: int = 4) -> Texture:
    """Return glazed or stone tiles in light mortar, n_across along both sides."""
    shape = (SIDE, SIDE)
    place = np.arange(SIDE) * n_across
    cell = place // SIDE
    number = cell[:, None] * n_across + cell
    shade = rng.normal(0, 0.035, n_across**2)[number] + 0.02 * noise(rng, shape, 5)
    is_edge = place % SIDE < 4 * n_across
    is_joint = is_edge[:, None] | is_edge
    mortar = 0.55 * np.asarray(colour, np.float32) + 0.45 * 175
    ground = np.where(is_joint[..., None], mortar, np.asarray(colour, np.float32))
    return shaded(ground, np.where(is_joint, 0.03 * noise(rng, shape, 1), shade))


def stone(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return clouded stone with veins, as marble and slate have; about 0.8 m."""
    shape = (SIDE, SIDE)
    veins = np.exp(-((noise(rng, shape, 14) / 0.06) ** 2))
    clouds = 0.06 * noise(rng, shape, 22) + 0.03 * noise(rng, shape, 5)
    fleck = 0.02 * noise(rng, shape, 0.8)
    sign = 1 if np.mean(colour) < 110 else -1
    return shaded(colour, clouds + fleck + sign * rng.uniform(0.1, 0.3) * veins)


def metal(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return brushed metal, its scratches along u; about 0.3 m."""
    shape = (128, 128)
    return shaded(colour, 0.05 * noise(rng, shape, (0.5, 30)) + 0.02 * noise(rng, shape, 20))


def speckled(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return a ground full of dark and light grains, as granite has; about 0.3 m."""
    shape = (SIDE, SIDE)
    dark = np.clip(noise(rng, shape, 1.4) - 1.1, 0, 1)
    light = np.clip(noise(rng, shape, 1.4) - 1.2, 0, 1)
    return shaded(colour, 0.5 * light - 0.55 * dark + 0.03 * noise(rng, shape, 0.8))


def stripes(rng: np.random.Generator, colours: Sequence[Colour]) -> Texture:
    """Return stripes across u, two to four of each colour in uneven widths."""
    palette = np.asarray(colours, np.float32)
    order = np.tile(np.arange(len(palette)), rng.integers(2, 5))
    widths = rng.uniform(0.4, 1.6, len(order))
    ends = np.cumsum(widths) / widths.sum() * SIDE
    stripe = np.searchsorted(ends, np.arange(SIDE), side="right").clip(0, len(order) - 1)
    row = palette[order[stripe]]
    return shaded(np.broadcast_to(row, (SIDE, SIDE, 3)), 0.02 * noise(rng, (SIDE, SIDE), 0.8))


def checks(rng: np.random.Generator, colours: Sequence[Colour]) -> Texture:
    """Return a woven check of all the colours; about 0.2 m."""
    across = stripes(rng, colours).astype(np.float32)
    down = across.transpose(1, 0, 2)
    twill = np.sin(2 * np.pi * (np.arange(SIDE)[:, None] + np.arange(SIDE)) / 8)
    return shaded((across + down) / 2, 0.03 * twill)


def wicker(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return plaited cane, eight strands each way; about 0.12 m."""
    side, n_strands = 128, 8
    place = np.arange(side) * n_strands / side
    strand, across = place.astype(int), np.sin(np.pi * (place % 1)).astype(np.float32)
    is_over = (strand[:, None] + strand) % 2 == 0
    lying = across[:, None] * (0.4 + 0.6 * across)
    shade = np.where(is_over, lying, lying.T) * 0.75 - 0.6
    tone = np.where(
        is_over, rng.normal(0, 0.07, 8)[strand][:, None], rng.normal(0, 0.07, 8)[strand]
    )
    return shaded(colour, shade + tone + 0.05 * noise(rng, (side, side), 0.7))


def leaves(rng: np.random.Generator, colour: Colour) -> Texture:
    """Return foliage: many small leaves of like colours over a dark ground; about 0.4 m."""
    texture = shaded(colour, -0.6 + 0.1 * noise(rng, (SIDE, SIDE), 4))
    for layer in np.linspace(0, 1, 260):
        at = rng.integers(0, SIDE, 2)
        half = (int(rng.integers(9, 20)), int(rng.integers(4, 8)))
        turn = float(rng.uniform(0, 180))
        tint = np.asarray(colour) * (0.5 + 0.6 * layer + rng.normal(0, 0.1)) + rng.normal(0, 6, 3)
        rgb = np.clip(tint, 0, 255).tolist()
        # A leaf that leaves on one side comes in on the other.
        for shift in np.ndindex(3, 3):
            centre = at + SIDE * (np.array(shift) - 1)
            if (np.abs(centre - SIDE / 2) < SIDE / 2 + 20).all():
                cv2.ellipse(texture, centre.tolist(), half, turn, 0, 360, rgb, -1, cv2.LINE_AA)
    return texture


def soil(rng: np.random.Generator) -> Texture:
    """Return potting earth; about 0.2 m."""
    shape = (128, 128)
    crumbs = 0.3 * noise(rng, shape, 1.2) + 0.15 * noise(rng, shape, 4)
    return shaded(
        (58, 42, 32), np.maximum(crumbs, -0.7) + np.clip(noise(rng, shape, 0.8) - 2.3, 0, 1)
    )
