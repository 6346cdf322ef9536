"""What grows in pots and vases."""

from __future__ import annotations

import numpy as np

from curiosight.frame import Pose
from curiosight.rooms import textures
from curiosight.rooms.materials import ceramic, glass, near, plastic, shade, terracotta
from curiosight.rooms.mesh import Material, Mesh, join
from curiosight.rooms.palette import Colour, draw_colour
from curiosight.rooms.round_shapes import ellipsoid, lathe, tube
from curiosight.rooms.surfaces import Points, sheet, stretched, turned, unit, warped
from curiosight.rooms.things.kind import FLOOR, TABLE, Kind, assembled, at

PETALS = (
    (196, 44, 52),
    (232, 188, 60),
    (236, 232, 226),
    (206, 110, 150),
    (126, 84, 160),
    (222, 122, 50),
)
GREENS = ((62, 98, 48), (84, 122, 58), (44, 78, 50), (108, 138, 80), (70, 104, 78))
UP = np.array([0.0, 0.0, 1.0])


def pot(rng: np.random.Generator, radius: float, height: float) -> Mesh:
    """Return a flower pot with earth in it."""
    is_clay = rng.random() < 0.4
    wall = terracotta(rng) if is_clay else ceramic(rng, draw_colour(rng))
    slope = rng.uniform(0.65, 0.95)
    profile = [(0, 0), (slope, 0), (0.97, 0.8), (1, 1), (0.92, 1), (0.9, 0.88)]
    if is_clay:
        profile[2:] = [(0.93, 0.78), (1.03, 0.78), (1.05, 1), (0.94, 1), (0.9, 0.88)]
    body = lathe(np.array(profile) * [radius, height], wall, n_around=28, fit=False)
    soil = Material(textures.soil(rng), (0.15, 0.15))
    earth = [(0.91 * radius, 0.87 * height), (0, 0.9 * height)]
    return join([body, lathe(earth, soil, n_around=28, fit=False)])


def leaf(
    spine: Points, width: float, green: Material, *, tip: float = 1.0, fold: float = 0.3
) -> Mesh:
    """Return a thin leaf along a spine, (N, 3).

    width: metres at its widest. tip: above 1 moves that place towards the root.
    fold: how far its two halves rise from its middle, in parts of the width.
    """
    along = unit(np.gradient(spine, axis=0))
    side = unit(np.cross(along, UP + 1e-3 * along[:, [1, 2, 0]]))
    up = np.cross(side, along)
    t = np.linspace(0, 1, len(spine)) ** (1 / tip)
    half = width / 2 * np.sin(np.pi * (0.06 + 0.9 * t)) ** 0.8
    across = np.array([-1.0, 0.0, 1.0])[:, None]
    edge = half[:, None, None] * (across * side[:, None] + fold * np.abs(across) * up[:, None])
    return sheet(spine[:, None] + edge, green)


def arched(
    start: Points, heading: float, length: float, rise: float, droop: float, n_points: int = 6
) -> Points:
    """Return the (N, 3) spine of a leaf: it leaves at the angle `rise` and ends `droop` lower."""
    slope = rise - droop * np.linspace(0, 1, n_points - 1)
    level = np.cos(slope)
    steps = np.stack([level * np.cos(heading), level * np.sin(heading), np.sin(slope)], 1)
    return start + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, 0)]) * length / (n_points - 1)


def _foliage(rng: np.random.Generator) -> list[Material]:
    """Return two materials of one green, a darker and a lighter one, sometimes with pale edges."""
    green = near(rng, GREENS[rng.integers(len(GREENS))], 10)
    is_pale = rng.random() < 0.25
    light = np.array([206, 210, 150]) if is_pale else shade(green, 1.35)
    made = []
    for factor in (0.85, 1.15):
        blade = np.broadcast_to(shade(green, factor), (32, 16, 3)).copy()
        blade[::5] = shade(green, factor * 0.88)
        blade[:, 7:9] = light
        if is_pale:
            blade[:, [0, 1, 2, 13, 14, 15]] = light
        made.append(Material(blade, gloss=0.15, sharpness=15.0))
    return made


def _arching(rng: np.random.Generator, size: float, root: Points) -> list[Mesh]:
    """Return long leaves that bend over from one root, as a dracaena's or a palm's."""
    greens = _foliage(rng)
    n_leaves, width = int(rng.integers(22, 34)), rng.uniform(0.05, 0.1) * size
    headings = np.arange(n_leaves) * 2.4 + rng.normal(0, 0.2, n_leaves)
    parts = []
    for i, heading in enumerate(headings):
        age = i / n_leaves
        length = size * rng.uniform(0.6, 0.8) * (0.65 + 0.35 * age)
        rise = 0.45 + 0.95 * age
        spine = arched(root, heading, length, rise, rng.uniform(0.8, 1.5), 7)
        spine[:, 2] = np.maximum(spine[:, 2], 0.01)
        parts.append(leaf(spine, width, greens[i % 2]))
    return parts


def _upright(rng: np.random.Generator, size: float, root: Points) -> list[Mesh]:
    """Return stiff blades that stand, as a snake plant's."""
    greens = _foliage(rng)
    parts = []
    for i in range(int(rng.integers(10, 18))):
        heading, away = 2.4 * i, 0.02 * size * np.sqrt(i)
        start = root + away * np.array([np.cos(heading), np.sin(heading), 0])
        spine = arched(start, heading, size * rng.uniform(0.6, 1.0), 1.5 - 0.02 * i, 0.1, 7)
        parts.append(leaf(spine, 0.1 * size, greens[i % 2], fold=0.5))
    return parts


def _bushy(rng: np.random.Generator, size: float, root: Points) -> list[Mesh]:
    """Return stems with broad leaves on stalks, as a rubber plant's."""
    greens = _foliage(rng)
    bark = plastic(near(rng, (96, 84, 54)), 0.0)
    parts = []
    for stem in range(int(rng.integers(2, 5))):
        heading = 2.4 * stem + rng.uniform(0, 1)
        path = arched(root, heading, size * rng.uniform(0.7, 0.95), rng.uniform(1.15, 1.5), 0.2)
        parts.append(tube(path, np.linspace(0.013, 0.005, 6) * (0.4 + size), bark, n_around=5))
        for i, share in enumerate(np.linspace(0.15, 1.0, int(rng.integers(9, 14)))):
            place = np.array([np.interp(share, np.linspace(0, 1, 6), path[:, k]) for k in range(3)])
            turn, length = 2.4 * i + heading, size * rng.uniform(0.24, 0.34)
            spine = arched(place, turn, length, rng.uniform(0.3, 0.9), rng.uniform(0.6, 1.2))
            parts.append(leaf(spine, 0.5 * length, greens[i % 2], tip=1.3))
    return parts


def _round(rng: np.random.Generator, size: float, root: Points) -> list[Mesh]:
    """Return a clipped ball of small leaves on a stem, or right on the pot."""
    green = near(rng, GREENS[rng.integers(len(GREENS))], 10)
    foliage = Material(textures.leaves(rng, shade(green, 1.2)), (0.5, 0.5))
    radius = size * rng.uniform(0.28, 0.36)
    stem = max(0.0, size * rng.uniform(-0.3, 0.35))
    bumps = rng.normal(0, 9, (3, 3))

    def knobbly(points: Points) -> Points:
        bump: Points = np.sin(points @ bumps.T / radius).sum(1, keepdims=True)
        return points * (1 + 0.04 * bump)

    ball = warped(at(ellipsoid((radius,) * 3, foliage, n_around=28), 0, 0, -radius), knobbly)
    bark = plastic(near(rng, (92, 74, 52)), 0.0)
    trunk = tube([root, root + UP * (stem + 0.5 * radius)], 0.02 * size + 0.004, bark)
    return [trunk, at(ball, 0, 0, root[2] + stem + 0.85 * radius)]


def _draw_plant(rng: np.random.Generator, size: float, radius: float) -> Mesh:
    height = radius * rng.uniform(1.5, 2.0)
    grow = (_arching, _upright, _bushy, _round)[rng.integers(4)]
    root = np.array([0, 0, 0.86 * height])
    return assembled([pot(rng, radius, height), *grow(rng, size - height, root)])


def draw_plant(rng: np.random.Generator) -> Mesh:
    """Return a potted plant for a table."""
    return _draw_plant(rng, rng.uniform(0.28, 0.42), rng.uniform(0.055, 0.075))


def draw_tall_plant(rng: np.random.Generator) -> Mesh:
    """Return a potted plant for the floor, knee to breast high."""
    size = rng.uniform(0.6, 1.05)
    return _draw_plant(rng, size, size * rng.uniform(0.15, 0.18))


def draw_cactus(rng: np.random.Generator) -> Mesh:
    """Return a ribbed cactus, round or a column with arms, in a pot."""
    radius = rng.uniform(0.05, 0.075)
    skin = np.repeat(np.repeat(np.array([[0.8], [1.1], [0.8]]), 4, 1), 4, 0).T
    green = near(rng, GREENS[rng.integers(len(GREENS))], 10)
    pattern = np.clip(skin[..., None] * green.astype(float), 0, 255).astype(np.uint8)
    pattern[1::4, 5:7] = (226, 220, 190)
    body = Material(np.tile(pattern, (8, 1, 1)), (1 / 12, 1.0))
    is_round = rng.random() < 0.4
    girth = radius * (0.95 if is_round else 0.5)
    height = girth * (1.7 if is_round else rng.uniform(5, 7.5))
    parts = [pot(rng, radius, 1.4 * radius), _ribbed(girth, height, 1.2 * radius, body)]
    if not is_round:
        for side in (-1, 1)[: int(rng.integers(1, 3))]:
            level = 1.2 * radius + height * rng.uniform(0.3, 0.5)
            arm = _ribbed(0.6 * girth, 0.4 * height, level, body)
            parts.append(at(arm, side * 1.9 * girth, 0))
            link = [(0, 0, level), (side * 1.9 * girth, 0, level + 0.4 * girth)]
            parts.append(tube(link, 0.45 * girth, plastic(green, 0.0)))
    return assembled(parts)


def _ribbed(radius: float, height: float, lift: float, skin: Material) -> Mesh:
    t = np.linspace(0, np.pi / 2, 6)
    dome = np.stack([radius * np.cos(t), height - radius * (1 - np.sin(t))], 1)
    dome[-1, 0] = 0.0
    column = lathe([(0.8 * radius, 0), (radius, 0.2 * height), *dome], skin, n_around=36)

    def ribs(points: Points) -> Points:
        angle = np.arctan2(points[:, 1], points[:, 0])
        depth = 1 + 0.09 * np.cos(12 * angle)
        return stretched(points, depth, depth)

    return at(warped(column, ribs), 0, 0, lift)


def draw_flowers(rng: np.random.Generator) -> Mesh:
    """Return cut flowers in a vase."""
    height, radius = rng.uniform(0.14, 0.22), rng.uniform(0.045, 0.065)
    hue = draw_colour(rng)
    wall = glass(near(rng, (150, 176, 180))) if rng.random() < 0.3 else ceramic(rng, hue)
    shape = [(0, 0), (0.7, 0), (1, 0.4), (0.55, 0.85), (0.7, 1), (0.64, 1), (0.48, 0.85), (0, 0.7)]
    vase = lathe(np.array(shape) * [radius, height], wall, n_around=28, fit=False)
    green = _foliage(rng)
    stalk, petal = plastic(near(rng, (70, 110, 56)), 0.0), PETALS[rng.integers(len(PETALS))]
    parts = [vase]
    for i in range(int(rng.integers(8, 13))):
        heading, rise = 2.4 * i, rng.uniform(1.05, 1.5)
        start = np.array([0, 0, 0.75 * height])
        path = arched(start, heading, rng.uniform(0.13, 0.22), rise, 0.25, 5)
        parts.append(tube(path, 0.003, stalk, n_around=5))
        blossom = _blossom(rng, near(rng, petal, 10))
        parts.append(blossom.moved(_facing(path[-1] - path[-2], path[-1])))
        parts.append(leaf(arched(path[1], heading + 1, 0.09, 0.7, 0.8), 0.025, green[i % 2]))
    return assembled(parts)


def _blossom(rng: np.random.Generator, rgb: Colour) -> Mesh:
    """Return a flower at 0 that looks up: petals around a yellow eye."""
    petal = plastic(rgb, 0.0)
    n_petals = int(rng.integers(6, 10))
    length, rise = rng.uniform(0.034, 0.048), rng.uniform(0.2, 0.9)
    origin = np.zeros(3)
    parts = [
        leaf(arched(origin, turn, length, rise, 0.4, 4), 0.026, petal)
        for turn in np.arange(n_petals) * 2 * np.pi / n_petals
    ]
    eye = plastic(near(rng, (206, 160, 48)), 0.0)
    return join([*parts, ellipsoid((0.011, 0.011, 0.007), eye, n_around=8)])


def _facing(direction: Points, place: Points) -> Pose:
    """Return the motion that takes z to a direction and 0 to a place."""
    across = np.cross(UP, direction) + 1e-9
    sine, cosine = np.linalg.norm(across), direction @ UP
    return turned(across, float(np.arctan2(sine, cosine)), place)


KINDS = (
    Kind("plant", draw_plant, TABLE),
    Kind("tall plant", draw_tall_plant, FLOOR),
    Kind("cactus", draw_cactus, TABLE),
    Kind("flowers", draw_flowers, TABLE),
)
