"""What lies on desks, but for what has a plug."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import prints, textures
from curiosight.rooms.materials import ceramic, colour, near, plastic, printed, steel, timber
from curiosight.rooms.mesh import Material, Mesh, Texture, join
from curiosight.rooms.noise import mixed, noise, shaded
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import ellipsoid, lathe, ring, tube
from curiosight.rooms.shapes import box, box_faces, panel
from curiosight.rooms.surfaces import arc, turned
from curiosight.rooms.things.kind import ANYWHERE, TABLE, Kind, assembled, at

UP = np.array([0.0, 0.0, 1.0])
# From lying to standing, its cover to the right.
ON_END = turned((0, 1, 0), np.pi / 2)


def _volume(rng: np.random.Generator, size: tuple[float, float, float]) -> Mesh:
    """Return a lying book (width, depth, thickness): spine towards -y, cover up."""
    width, depth, thickness = size
    cover = printed(_on_its_side(prints.book_cover(rng)), gloss=0.2)
    spine = printed(_on_its_side(prints.book_spine(rng)), gloss=0.2)
    board = 0.003
    paper = textures.stripes(rng, [colour(226, 220, 200), colour(206, 198, 176)])
    edges = Material(_on_its_side(paper), (0.05, 0.02))
    lids = [
        at(box((width, depth, board), cover, fit=True), 0, 0, level)
        for level in (0.0, thickness - board)
    ]
    block = box((width - 0.008, depth - 0.008, thickness - 2 * board), edges, lift=board)
    back = at(panel(*box_faces(size)[0], spine, fit=True), 0, -0.0006)
    return join([*lids, block, back])


def _on_its_side(texture: Texture) -> Texture:
    return np.ascontiguousarray(np.rot90(texture))


def _book_size(rng: np.random.Generator) -> tuple[float, float, float]:
    depth = rng.uniform(0.12, 0.2)
    return depth * rng.uniform(1.3, 1.5), depth, rng.uniform(0.015, 0.05)


def draw_book(rng: np.random.Generator) -> Mesh:
    """Return a book that lies, stands, or lies open."""
    pose = rng.random()
    if pose < 0.3:
        return _draw_open_book(rng)
    volume = _volume(rng, _book_size(rng))
    if pose < 0.6:
        return assembled([volume])
    return assembled([volume.moved(ON_END)])


def _draw_open_book(rng: np.random.Generator) -> Mesh:
    width, height = rng.uniform(0.14, 0.2), rng.uniform(0.2, 0.27)
    thickness = rng.uniform(0.01, 0.02)
    cover = plastic(draw_colour(rng), 0.2)
    parts = [box((2 * width + 0.01, height + 0.008, 0.003), cover)]
    for side in (-1, 1):
        page, edge = printed(prints.page(rng), gloss=0.05), plastic(colour(222, 216, 200), 0.0)
        parts.append(at(box((width, height, thickness), edge, lift=0.003), side * width / 2, 0))
        origin = (min(0, side) * width, -height / 2, thickness + 0.0036)
        parts.append(panel(origin, (width, 0, 0), (0, height, 0), page, fit=True))
    return assembled(parts)


def draw_books(rng: np.random.Generator) -> Mesh:
    """Return a pile of books, or a row of standing ones."""
    sizes = [_book_size(rng) for _ in range(int(rng.integers(3, 7)))]
    books = [_volume(rng, size) for size in sizes]
    thicknesses = np.array([size[2] for size in sizes])
    starts = np.concatenate([[0], np.cumsum(thicknesses + 0.0015)])
    if rng.random() < 0.6:
        shifts, headings = rng.normal(0, 0.012, (len(books), 2)), rng.normal(0, 0.12, len(books))
        placed = zip(books, shifts, starts[:-1], headings, strict=True)
        return assembled([at(book, x, y, low, turn) for book, (x, y), low, turn in placed])
    row = [
        at(book.moved(ON_END), start, 0, size[0] / 2)
        for book, start, size in zip(books, starts[:-1], sizes, strict=True)
    ]
    return assembled(row)


def draw_box_file(rng: np.random.Generator) -> Mesh:
    """Return one to four ring binders side by side, with labels and holes on their spines."""
    n_files, thickness = int(rng.integers(1, 5)), rng.uniform(0.055, 0.08)
    depth, height = 0.28, 0.315
    parts = []
    for i in range(n_files):
        x = i * (thickness + 0.002)
        board = plastic(draw_colour(rng, vivid=0.7), 0.15)
        label = printed(prints.page(rng), gloss=0.0)
        hole = ring(0.013, 0.003, steel(rng), n_around=16).moved(turned((1, 0, 0), np.pi / 2))
        right, up = (0.7 * thickness, 0, 0), (0, 0, 0.11)
        parts += [
            at(box((thickness, depth, height), board), x, 0),
            panel((x - 0.35 * thickness, -depth / 2 - 0.0008, 0.15), right, up, label, fit=True),
            at(hole, x, -depth / 2, 0.07),
        ]
    return assembled(parts)


def draw_pencil_cup(rng: np.random.Generator) -> Mesh:
    """Return a cup of pencils and pens."""
    radius, height = rng.uniform(0.036, 0.045), rng.uniform(0.09, 0.115)
    profile = [(0, 0), (radius, 0), (radius, height), (radius - 0.003, height)]
    profile += [(radius - 0.003, 0.006), (0, 0.006)]
    wall = timber(rng) if rng.random() < 0.3 else ceramic(rng, draw_colour(rng))
    parts = [lathe(profile, wall, fit=False)]
    for angle in rng.uniform(0, 2 * np.pi, int(rng.integers(5, 10))):
        lean, length = rng.uniform(0.6, 1.0), rng.uniform(0.14, 0.19)
        direction = np.array([np.cos(angle), np.sin(angle), 0])
        foot = -0.5 * radius * direction + 0.01 * UP
        brim = 0.9 * lean * radius * direction + height * UP
        end = foot + (brim - foot) * length / height
        shaft = foot + 0.93 * (end - foot)
        paint = plastic(draw_colour(rng, vivid=0.9), 0.3)
        parts += [
            tube([foot, shaft], 0.004, paint, n_around=6),
            tube([shaft, end], [0.004, 0.001], plastic(near(rng, (206, 170, 124))), n_around=6),
        ]
    return assembled(parts)


def draw_globe(rng: np.random.Generator) -> Mesh:
    """Return a globe of the world on a stand."""
    radius = rng.uniform(0.1, 0.15)
    stand = timber(rng) if rng.random() < 0.5 else plastic(draw_colour(rng))
    brass = steel(rng, (190, 160, 100))
    lift = 0.35 * radius
    world = ellipsoid((radius,) * 3, Material(_continents(rng), gloss=0.3), n_around=24)
    tilted = turned((0, 1, 0), 0.41, (0, 0, lift + radius)) @ turned((0, 0, 1), rng.uniform(0, 6))
    reach = 1.07 * radius
    frame = arc(-np.pi / 2 - 0.41, np.pi / 2 - 0.41, (reach, reach), (0.0, lift + radius), 17)
    profile = [(0, 0), (0.7, 0), (0.7, 0.08), (0.15, 0.2), (0.08, 0.4), (0, 0.4)]
    foot = lathe(np.array(profile) * radius, stand, n_around=24, fit=False)
    ball = at(world, 0, 0, -radius).moved(tilted)
    return assembled([ball, tube(frame, 0.006, brass, n_around=8), foot])


def _continents(rng: np.random.Generator) -> Texture:
    shape = (128, 256)
    height = noise(rng, shape, (10, 16)) + 0.4 * noise(rng, shape, 3)
    sea = rng.choice([(70, 120, 170), (196, 190, 160), (50, 70, 110)])
    dry = mixed(0.5 + 0.4 * noise(rng, shape, 14), (150, 160, 90), (212, 180, 120))
    latitude = np.abs(np.linspace(-1, 1, shape[0]))[:, None]
    world = np.where((height > 0.45)[..., None], dry, np.asarray(sea))
    world = np.where((latitude + 0.04 * height > 0.88)[..., None], (236, 236, 236), world)
    world[:: shape[0] // 8] = world[:: shape[0] // 8] * 0.75
    return shaded(world, 0)


KINDS = (
    Kind("book", draw_book, TABLE),
    Kind("books", draw_books, TABLE),
    Kind("box file", draw_box_file, ANYWHERE),
    Kind("pencil cup", draw_pencil_cup, TABLE),
    Kind("globe", draw_globe, TABLE),
)
