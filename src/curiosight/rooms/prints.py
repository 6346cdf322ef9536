"""Things printed on paper and packages, and on a screen: (h, w, 3) uint8 sRGB, upright.

They fill a face once, and need not repeat.
"""

from __future__ import annotations

import cv2
import numpy as np

from curiosight.rooms.mesh import Texture
from curiosight.rooms.noise import noise, shaded
from curiosight.rooms.palette import Colour, draw_colour

SYLLABLES = (
    "ka", "ro", "mi", "len", "sto", "ba", "vi", "nu", "tra", "fel",
    "or", "do", "sa", "pim", "gre", "la", "ton", "zu", "cer", "wi",
)  # fmt: skip
FONTS = (cv2.FONT_HERSHEY_SIMPLEX, cv2.FONT_HERSHEY_DUPLEX, cv2.FONT_HERSHEY_COMPLEX)
PAPER = (238, 234, 224)

Box = tuple[int, int, int, int]


def label(rng: np.random.Generator, shape: tuple[int, int] = (256, 192)) -> Texture:
    """Return a product's front: coloured ground, band, name, picture, small print, bar code."""
    h, w = shape
    ground = draw_colour(rng, vivid=0.7)
    image = _ground(rng, shape, ground)
    top = int(h * rng.uniform(0.08, 0.3))
    bottom = top + int(h * rng.uniform(0.2, 0.32))
    band = _contrasting(rng, ground)
    skew = int(rng.integers(-h // 12, h // 12 + 1))
    corners = [(0, top + skew), (w, top - skew), (w, bottom - skew), (0, bottom + skew)]
    cv2.fillPoly(image, [np.array(corners, np.int32)], band.tolist(), cv2.LINE_AA)
    _write(image, rng, (w // 16, top, w - w // 16, bottom), _contrasting(rng, band))
    blob_top = bottom + abs(skew) + h // 32
    _draw_blobs(image, rng, (w // 8, blob_top, w * 7 // 8, h * 4 // 5), ground)
    _small_print(image, rng, (w // 16, h * 5 // 6, w * 9 // 16, h - h // 24), ground)
    _bar_code(image, rng, (w * 11 // 16, h * 5 // 6, w - w // 16, h - h // 24))
    return image


def book_cover(rng: np.random.Generator, shape: tuple[int, int] = (256, 180)) -> Texture:
    """Return the front of a book: ground, a figure, title and author."""
    h, w = shape
    ground = draw_colour(rng, vivid=0.5)
    image = _ground(rng, shape, ground)
    if rng.random() < 0.5:
        frame = _contrasting(rng, ground).tolist()
        cv2.rectangle(image, (w // 16, w // 16), (w - w // 16, h - w // 16), frame, w // 60 + 1)
    ink = _contrasting(rng, ground)
    _draw_blobs(image, rng, (w // 6, h * 2 // 5, w * 5 // 6, h * 5 // 6), ground)
    _write(image, rng, (w // 10, h // 12, w * 9 // 10, h // 4), ink)
    _write(image, rng, (w // 6, h // 4, w * 5 // 6, h * 2 // 5), ink)
    _write(image, rng, (w // 4, h * 6 // 7, w * 3 // 4, h * 19 // 20), ink)
    return image


def book_spine(rng: np.random.Generator, shape: tuple[int, int] = (256, 40)) -> Texture:
    """Return a book's back, the title along it."""
    h, w = shape
    ground = draw_colour(rng, vivid=0.45)
    image = _ground(rng, shape, ground)
    ink = _contrasting(rng, ground)
    for at in (h // 14, h * 13 // 14):
        cv2.rectangle(image, (0, at), (w, at + max(1, int(h * rng.uniform(0, 0.03)))), ink.tolist())
    title = image.transpose(1, 0, 2)[:, ::-1].copy()
    _write(title, rng, (h // 8, w // 6, h * 3 // 4, w * 5 // 6), ink)
    return np.ascontiguousarray(title[:, ::-1].transpose(1, 0, 2))


def page(rng: np.random.Generator, shape: tuple[int, int] = (256, 180)) -> Texture:
    """Return a printed page: a heading, paragraphs and now and then a figure."""
    h, w = shape
    image = _ground(rng, shape, np.array(PAPER, np.uint8))
    paper = np.array(PAPER, np.uint8)
    _write(image, rng, (w // 8, h // 16, w * 3 // 4, h // 7), np.array((50, 50, 54), np.uint8))
    middle = int(h * rng.uniform(0.35, 0.65))
    _small_print(image, rng, (w // 8, h // 6, w * 7 // 8, middle), paper)
    if rng.random() < 0.6:
        _draw_blobs(image, rng, (w // 5, middle, w * 4 // 5, h * 13 // 16), paper)
        middle = h * 13 // 16
    _small_print(image, rng, (w // 8, middle + h // 40, w * 7 // 8, h * 15 // 16), paper)
    return image


def screen(rng: np.random.Generator, shape: tuple[int, int] = (160, 256)) -> Texture:
    """Return what a monitor shows: a desktop with windows of text and pictures."""
    h, w = shape
    image = _ground(rng, shape, draw_colour(rng, vivid=0.6))
    for _ in range(int(rng.integers(1, 4))):
        left, top = int(rng.integers(0, w // 2)), int(rng.integers(0, h // 2))
        right, bottom = left + int(rng.integers(w // 3, w)), top + int(rng.integers(h // 3, h))
        ground = np.array((245, 245, 245) if rng.random() < 0.6 else (38, 40, 46), np.uint8)
        cv2.rectangle(image, (left, top), (right, bottom), ground.tolist(), -1)
        bar = draw_colour(rng).tolist()
        cv2.rectangle(image, (left, top), (right, top + h // 16), bar, -1)
        _small_print(image, rng, (left + 6, top + h // 8, min(right, w) - 6, bottom), ground)
    cv2.rectangle(image, (0, h - h // 16), (w, h), (30, 32, 38), -1)
    return image


def rug(rng: np.random.Generator, shape: tuple[int, int] = (192, 288)) -> Texture:
    """Return a woven rug: borders within borders, and a field of lozenges."""
    h, w = shape
    image = np.empty((h, w, 3), np.uint8)
    image[:] = draw_colour(rng, vivid=0.5)
    for inset in np.cumsum(rng.integers(4, 14, int(rng.integers(1, 5)))):
        image[inset : h - inset, inset : w - inset] = draw_colour(rng, vivid=0.5)
    n_rows, ink = int(rng.integers(1, 5)), draw_colour(rng, vivid=0.6).tolist()
    step = (h - 70) // n_rows
    half = step * 2 // 5
    for v in range(35 + step // 2, h - 34, step):
        for u in range(35 + step // 2, w - 34, step):
            lozenge = np.array([(u - half, v), (u, v - half), (u + half, v), (u, v + half)])
            cv2.fillPoly(image, [lozenge.astype(np.int32)], ink, cv2.LINE_AA)
    return shaded(image, 0.06 * noise(rng, shape, (0.6, 3)))


def _ground(rng: np.random.Generator, shape: tuple[int, int], colour: Colour) -> Texture:
    """Return an even colour that fades a little from top to bottom."""
    fade = np.linspace(0, rng.uniform(-0.25, 0.15), shape[0])[:, None]
    return shaded(np.broadcast_to(colour, (*shape, 3)), np.broadcast_to(fade, shape))


def _contrasting(rng: np.random.Generator, ground: Colour) -> Colour:
    """Return a colour that can be read on a ground."""
    for _ in range(20):
        colour = draw_colour(rng, vivid=0.6)
        if abs(float(colour.mean()) - float(ground.mean())) > 60:
            return colour
    return np.array((24, 24, 28) if ground.mean() > 128 else PAPER, np.uint8)


def _write(image: Texture, rng: np.random.Generator, box: Box, ink: Colour) -> None:
    """Write an invented word as large as the box (u_min, v_min, u_max, v_max) allows."""
    left, top, right, bottom = box
    word = "".join(rng.choice(SYLLABLES, int(rng.integers(2, 4)))).capitalize()
    word = word.upper() if rng.random() < 0.4 else word
    font = FONTS[rng.integers(len(FONTS))]
    (width, height), _ = cv2.getTextSize(word, font, 1.0, 2)
    scale = 0.9 * min((right - left) / width, (bottom - top) / height)
    start = (
        round((left + right - scale * width) / 2),
        round((top + bottom + scale * 0.75 * height) / 2),
    )
    cv2.putText(image, word, start, font, scale, ink.tolist(), 2, cv2.LINE_AA)


def _small_print(image: Texture, rng: np.random.Generator, box: Box, ground: Colour) -> None:
    """Fill a box with lines of words too small to read."""
    left, top, right, bottom = box
    ink = np.rint(0.45 * ground + (0 if ground.mean() > 128 else 130)).tolist()
    for v in range(top + 2, bottom - 2, 6):
        u, end = left, right if rng.random() < 0.8 else (left + right) // 2
        while u < end:
            length = int(rng.integers(4, 16))
            cv2.rectangle(image, (u, v), (min(u + length, end), v + 2), ink, -1)
            u += length + 4


def _bar_code(image: Texture, rng: np.random.Generator, box: Box) -> None:
    left, top, right, bottom = box
    bars = rng.random(right - left) < 0.5
    image[top:bottom, left:right] = np.where(bars[:, None], 20, 245)


def _draw_blobs(image: Texture, rng: np.random.Generator, box: Box, ground: Colour) -> None:
    """Draw a few round or angular figures inside a box, as a picture of the contents."""
    left, top, right, bottom = box
    width, height = right - left, bottom - top
    for size in np.linspace(0.5, 0.18, int(rng.integers(2, 6))):
        radius = max(2, int(size * min(width, height)))
        spare_u, spare_v = max(width - 2 * radius, 1), max(height - 2 * radius, 1)
        u = left + radius + int(rng.integers(0, spare_u))
        v = top + radius + int(rng.integers(0, spare_v))
        colour = _contrasting(rng, ground).tolist()
        if rng.random() < 0.6:
            squash = int(radius * rng.uniform(0.6, 1.0))
            cv2.ellipse(image, (u, v), (radius, squash), 0, 0, 360, colour, -1, cv2.LINE_AA)
        else:
            angles = np.arange(rng.integers(3, 7)) + rng.random()
            angles *= 2 * np.pi / len(angles)
            corners = np.stack((u + radius * np.cos(angles), v + radius * np.sin(angles)), 1)
            cv2.fillPoly(image, [np.rint(corners).astype(np.int32)], colour, cv2.LINE_AA)
