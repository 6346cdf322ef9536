"""Pictures on walls, and what is seen through windows: (h, w, 3) uint8 sRGB, upright."""

from __future__ import annotations

import cv2
import numpy as np

from curiosight.rooms.mesh import Texture
from curiosight.rooms.noise import mixed, noise, shaded
from curiosight.rooms.palette import Colour, draw_colour


def picture(rng: np.random.Generator, shape: tuple[int, int] = (256, 320)) -> Texture:
    """Return a painting or poster: blocks, rings, hills or a head, in strong colours."""
    draw = (_blocks, _rings, _hills, _head)[rng.integers(4)]
    image = draw(rng, shape)
    strokes = 0.04 * noise(rng, shape, (1.2, 3)) + 0.03 * noise(rng, shape, 12)
    return shaded(image, strokes)


def outdoors(rng: np.random.Generator, shape: tuple[int, int] = (256, 256)) -> Texture:
    """Return a bright view from a window: sky, house fronts, trees, out of focus."""
    h = shape[0]
    fall = np.linspace(0, 1, h)[:, None]
    sky = mixed(np.broadcast_to(fall, shape), (168, 204, 240), (238, 242, 246))
    clouds = np.clip(0.35 * noise(rng, shape, (10, 30)), 0, 1)
    image = shaded(mixed(clouds, sky, (250, 250, 252)), 0)
    for _ in range(int(rng.integers(0, 3))):
        _facade(image, rng)
    horizon = int(h * rng.uniform(0.6, 0.85))
    image[horizon:] = np.clip(rng.normal((118, 140, 92), 14), 0, 255)
    for _ in range(int(rng.integers(3, 9))):
        _tree(image, rng, horizon)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 1.8), np.uint8)


def _blocks(rng: np.random.Generator, shape: tuple[int, int]) -> Texture:
    """Return rectangles inside rectangles, some of them striped."""
    h, w = shape
    image = _filled(shape, draw_colour(rng, vivid=0.3))
    for _ in range(int(rng.integers(5, 12))):
        height, width = int(h * rng.uniform(0.1, 0.5)), int(w * rng.uniform(0.1, 0.5))
        top, left = int(rng.integers(0, h - height)), int(rng.integers(0, w - width))
        patch = image[top : top + height, left : left + width]
        patch[:: int(rng.choice([1, 1, 1, 4]))] = draw_colour(rng, vivid=0.7)
    return image


def _rings(rng: np.random.Generator, shape: tuple[int, int]) -> Texture:
    """Return discs and rings over two fields of colour."""
    h, w = shape
    image = _filled(shape, draw_colour(rng, vivid=0.4))
    image[int(h * rng.uniform(0.3, 0.7)) :] = draw_colour(rng, vivid=0.6)
    for radius in np.linspace(0.35, 0.05, int(rng.integers(4, 9))):
        centre = (int(rng.integers(0, w)), int(rng.integers(0, h)))
        colour = draw_colour(rng, vivid=0.8).tolist()
        width = -1 if rng.random() < 0.6 else int(rng.integers(3, 14))
        cv2.circle(image, centre, int(radius * h), colour, width, cv2.LINE_AA)
    return image


def _hills(rng: np.random.Generator, shape: tuple[int, int]) -> Texture:
    """Return a landscape: sky, sun, ridges that darken towards the eye."""
    h, w = shape
    fall = np.broadcast_to(np.linspace(0, 1, h)[:, None], shape)
    image = shaded(mixed(fall, draw_colour(rng, vivid=0.8), (240, 226, 200)), 0)
    sun = (int(rng.integers(w // 6, w * 5 // 6)), int(rng.integers(h // 6, h // 2)))
    cv2.circle(image, sun, int(h * rng.uniform(0.05, 0.12)), (250, 236, 190), -1, cv2.LINE_AA)
    land = draw_colour(rng, vivid=0.8).astype(float)
    n_ridges = int(rng.integers(3, 6))
    for index in range(n_ridges):
        line = h * (0.45 + 0.5 * index / n_ridges) + h * 0.06 * noise(rng, (1, w), (0, w / 12))[0]
        is_below = np.arange(h)[:, None] > line
        image[is_below] = np.clip(land * (1.25 - 0.8 * index / n_ridges), 0, 255)
    return image


def _head(rng: np.random.Generator, shape: tuple[int, int]) -> Texture:
    """Return a portrait: shoulders, neck, head and hair before an even ground."""
    h, w = shape
    image = _filled(shape, draw_colour(rng, vivid=0.5))
    u, v = w // 2 + int(rng.integers(-w // 10, w // 10 + 1)), int(h * 0.42)
    skin = np.array((224, 178, 146)) * rng.uniform(0.45, 1.05)
    hair, coat = draw_colour(rng, vivid=0.2).tolist(), draw_colour(rng, vivid=0.6).tolist()
    half = int(h * 0.17)
    cv2.ellipse(image, (u, v - h // 40), (half * 6 // 5, half * 3 // 2), 0, 0, 360, hair, -1)
    cv2.ellipse(image, (u, h), (int(half * 2.2), int(h * 0.36)), 0, 180, 360, coat, -1)
    cv2.rectangle(
        image, (u - half // 2, v), (u + half // 2, int(h * 0.7)), (skin * 0.85).tolist(), -1
    )
    cv2.ellipse(image, (u, v), (half * 5 // 6, half * 6 // 5), 0, 0, 360, skin.tolist(), -1)
    cv2.ellipse(image, (u, v), (half * 5 // 6, half * 6 // 5), 0, 190, 350, hair, half // 4)
    for side in (-1, 1):
        cv2.circle(image, (u + side * half // 3, v), max(2, half // 12), (30, 26, 26), -1)
    cv2.ellipse(image, (u, v + half // 2), (half // 4, half // 12), 0, 0, 360, (150, 60, 60), -1)
    return image


def _facade(image: Texture, rng: np.random.Generator) -> None:
    """Draw a house front with rows of windows, from its roof line down."""
    h, w = image.shape[:2]
    width = int(rng.integers(w // 4, w * 2 // 3))
    left, top = int(rng.integers(-width // 3, w - width // 2)), int(h * rng.uniform(0.15, 0.5))
    wall = np.clip(draw_colour(rng, vivid=0.2) * 0.7 + 70, 0, 255)
    image[top:, max(left, 0) : left + width] = wall
    step = int(rng.integers(w // 12, w // 7))
    for v in range(top + step // 2, h, step * 3 // 2):
        for u in range(max(left, 0) + step // 3, left + width - step // 2, step):
            image[v : v + step * 4 // 5, u : u + step // 2] = (92, 104, 118)


def _tree(image: Texture, rng: np.random.Generator, horizon: int) -> None:
    """Draw a crown of leaves out of many discs, standing on the horizon."""
    h, w = image.shape[:2]
    u, size = int(rng.integers(0, w)), h * rng.uniform(0.08, 0.22)
    green = np.array((84, 116, 56)) * rng.uniform(0.6, 1.4) + rng.normal(0, 10, 3)
    for _ in range(140):
        spread = np.rint(rng.normal(0, size * 0.45, 2)).astype(int)
        centre = (u + int(spread[0]), horizon - int(size) + int(spread[1]))
        tint = np.clip(green * rng.uniform(0.7, 1.3), 0, 255).tolist()
        cv2.circle(image, centre, max(2, int(size * 0.11)), tint, -1, cv2.LINE_AA)


def _filled(shape: tuple[int, int], colour: Colour) -> Texture:
    return np.broadcast_to(colour, (*shape, 3)).copy()
