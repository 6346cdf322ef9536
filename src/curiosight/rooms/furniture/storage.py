"""Cupboards and shelves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from curiosight.rooms import prints, round_shapes, shapes
from curiosight.rooms.blocks import block, upright_grain
from curiosight.rooms.furniture.fronts import THICKNESS, TOP_SPACING, Look, draw_look, fronts
from curiosight.rooms.furniture.kind import Furniture, Top, centred
from curiosight.rooms.materials import cloth, plastic, printed
from curiosight.rooms.mesh import Mesh, join, standing
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.surfaces import Points

BOARD = 0.022


def sideboard(rng: np.random.Generator) -> Furniture:
    """Draw a low cupboard with doors or drawers, on legs or a plinth."""
    size = (
        float(rng.uniform(1.0, 1.8)),
        float(rng.uniform(0.38, 0.48)),
        float(rng.uniform(0.7, 0.95)),
    )
    n_rows = int(rng.choice([1, 1, 3]))
    return _cupboard("sideboard", size, round(size[0] / 0.5), n_rows, rng)


def tv_board(rng: np.random.Generator) -> Furniture:
    """Draw a long low board on which a television could stand."""
    size = (
        float(rng.uniform(1.2, 1.8)),
        float(rng.uniform(0.36, 0.45)),
        float(rng.uniform(0.4, 0.52)),
    )
    return _cupboard("tv board", size, round(size[0] / 0.55), int(rng.integers(1, 3)), rng)


def wardrobe(rng: np.random.Generator) -> Furniture:
    """Draw a tall cupboard; nothing stands on it."""
    size = (
        float(rng.uniform(0.9, 1.5)),
        float(rng.uniform(0.55, 0.62)),
        float(rng.uniform(1.85, 2.1)),
    )
    tall = _cupboard("wardrobe", size, round(size[0] / 0.5), 1, rng)
    return Furniture(tall.name, tall.mesh, tall.size)


def shelf(rng: np.random.Generator) -> Furniture:
    """Draw an open bookcase with its books and boxes."""
    width, depth = float(rng.uniform(0.7, 1.2)), float(rng.uniform(0.28, 0.36))
    n_levels = int(rng.integers(4, 7))
    height = 0.06 + n_levels * float(rng.uniform(0.31, 0.36)) + BOARD
    look = draw_look(rng)
    x, y = width / 2, (-depth / 2, depth / 2)
    upright = upright_grain(look.body)
    levels = np.linspace(0.06, height - BOARD, n_levels + 1)
    boards = [block((-x, x), y, (z, z + BOARD), look.body, spacing=0.15) for z in levels]
    meshes = [
        block((-x - BOARD, -x), y, (0, height), upright),
        block((x, x + BOARD), y, (0, height), upright),
        block((-x, x), (y[1] - 0.008, y[1]), (0.06, height), look.front, spacing=0.15),
        block((-x, x), (y[0] + 0.02, y[1]), (0, 0.06), look.body),
        *boards,
    ]
    size = (width + 2 * BOARD, depth, height)
    contents = _shelf_contents(width, depth, levels, rng)
    return Furniture("shelf", join(meshes), size, contents=contents)


def _cupboard(
    name: str,
    size: tuple[float, float, float],
    n_columns: int,
    n_rows: int,
    rng: np.random.Generator,
) -> Furniture:
    width, depth, height = size
    look, x = draw_look(rng), width / 2
    y = (-depth / 2 + THICKNESS, depth / 2)
    foot = float(rng.uniform(0.06, 0.16))
    meshes = [
        block((-x, x), y, (foot, height - BOARD), look.body, spacing=0.2),
        block(
            (-x, x), (-depth / 2, y[1]), (height - BOARD, height), look.body, spacing=TOP_SPACING
        ),
        *fronts((-x, x), (foot + 0.005, height - BOARD - 0.005), y[0], n_columns, n_rows, look),
        *_feet(width, depth, foot, look, rng),
    ]
    return Furniture(name, join(meshes), size, (Top(height, centred(width, depth, 0.03)),))


def _feet(
    width: float, depth: float, height: float, look: Look, rng: np.random.Generator
) -> list[Mesh]:
    """Return a plinth set back, or four round legs."""
    x, y = width / 2 - 0.06, depth / 2 - 0.06
    if rng.random() < 0.5:
        return [block((-x, x), (-y, y + 0.05), (0, height), look.body)]
    return [
        round_shapes.cylinder(0.014, height, look.metal, top_radius=0.022, n_around=10).moved(
            standing(a, b)
        )
        for a in (-x, x)
        for b in (-y, y)
    ]


def _shelf_contents(width: float, depth: float, levels: Points, rng: np.random.Generator) -> Mesh:
    """Return rows of books, and boxes, on the levels; the highest board stays empty."""
    bound = [printed(prints.book_spine(rng)) for _ in range(14)]
    books = [shapes.box((1, 1, 1), spine, spacing=1.0, fit=True) for spine in bound]
    meshes = []
    for low, high in zip(levels[:-1] + BOARD, levels[1:], strict=True):
        left = -width / 2 + 0.01
        while left < width / 2 - 0.25:
            reach = min(float(rng.uniform(0.25, 0.6)), width / 2 - left - 0.01)
            room = (reach, depth, float(high - low))
            content = rng.random()
            if content < 0.6:
                stored = _books(room, books, rng)
            else:
                stored = [_storage_box(room, rng)] if content < 0.85 else []
            meshes += [mesh.moved(standing(left, 0, float(low))) for mesh in stored]
            left += reach
    return join(meshes)


def _books(
    room: tuple[float, float, float], books: list[Mesh], rng: np.random.Generator
) -> list[Mesh]:
    """Return books side by side from x = 0, in a stretch (width, depth, height).

    books: cubes of side 1, from which they are drawn.
    """
    meshes: list[Mesh] = []
    left, usual = 0.0, float(rng.uniform(0.6, 0.85)) * room[2]
    while True:
        thickness = float(rng.uniform(0.015, 0.05))
        if left + thickness > room[0]:
            return meshes
        height = min(usual * float(rng.uniform(0.85, 1.15)), room[2] - 0.02)
        deep = room[1] * float(rng.uniform(0.6, 0.8))
        book = books[rng.integers(len(books))]
        size = np.array((thickness, deep, height), np.float32)
        book = replace(book, vertices=book.vertices * size)
        y = -room[1] / 2 + deep / 2 + float(rng.uniform(0.01, 0.03))
        meshes.append(book.moved(standing(left + thickness / 2, y)))
        left += thickness + 0.001


def _storage_box(room: tuple[float, float, float], rng: np.random.Generator) -> Mesh:
    """Return a cardboard, cloth or plastic box in a stretch (width, depth, height)."""
    width, height = room[0] - 0.04, room[2] * float(rng.uniform(0.5, 0.85))
    deep = room[1] * 0.85
    kind = rng.integers(3)
    if kind == 0:
        box = shapes.box((width, deep, height), printed(prints.label(rng)), spacing=0.2, fit=True)
    else:
        stuff = cloth(rng) if kind == 1 else plastic(draw_colour(rng))
        box = shapes.rounded_box((width, deep, height), 0.01, stuff, spacing=0.2)
    return box.moved(standing(room[0] / 2, -0.02))
