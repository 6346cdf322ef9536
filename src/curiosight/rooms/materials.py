"""What things are made of: texture, gloss, and the infrared light that comes back.

All tiles are in metres, for meshes with uv in metres; prints cover a face once.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.rooms import textures
from curiosight.rooms.mesh import Material, Texture
from curiosight.rooms.palette import Colour, draw_colour

# Mean sRGB value below which a plastic's pigment swallows infrared light too.
BLACK = 70.0


def colour(red: int, green: int, blue: int) -> Colour:
    """Return an (3,) sRGB colour."""
    return np.array([red, green, blue], np.uint8)


def near(rng: np.random.Generator, rgb: npt.ArrayLike, spread: float = 8.0) -> Colour:
    """Return a colour like `rgb`: lighter or darker by a draw, and a little of another hue."""
    shifted = np.asarray(rgb) + rng.normal(0, spread) + rng.normal(0, spread / 3, 3)
    return np.clip(np.rint(shifted), 4, 250).astype(np.uint8)


def shade(rgb: npt.ArrayLike, factor: float) -> Colour:
    """Return a colour made darker, or lighter above 1."""
    return np.clip(np.rint(np.asarray(rgb) * factor), 4, 250).astype(np.uint8)


def plastic(rgb: Colour, gloss: float = 0.25) -> Material:
    """Return smooth plastic or enamel; black is dark to a depth sensor too."""
    infrared = 0.12 if rgb.mean() < BLACK else 0.8
    return Material(textures.plain(rgb), gloss=gloss, sharpness=40.0, infrared=infrared)


def black_plastic(rng: np.random.Generator) -> Material:
    """Return the near-black plastic of housings and handles."""
    return plastic(near(rng, (36, 36, 38), 5), 0.2)


def ceramic(rng: np.random.Generator, rgb: Colour) -> Material:
    """Return glazed earthenware: even, flecked, or banded."""
    pattern = rng.random()
    if pattern < 0.6:
        texture, tile = textures.plain(rgb), 0.3
    elif pattern < 0.8:
        texture, tile = textures.speckled(rng, rgb), 0.15
    else:
        texture, tile = _bands(rng, rgb), 0.12
    return Material(texture, (tile, tile), gloss=0.35, sharpness=60.0, infrared=0.85)


def terracotta(rng: np.random.Generator) -> Material:
    """Return unglazed fired clay."""
    texture = textures.plaster(rng, near(rng, (172, 98, 66), 10))
    return Material(texture, (0.4, 0.4))


def timber(rng: np.random.Generator, rgb: Colour | None = None) -> Material:
    """Return varnished wood, of a wood's colour where none is given."""
    woods = ((186, 146, 98), (150, 104, 62), (110, 72, 44), (208, 178, 134), (84, 58, 42))
    own = near(rng, woods[rng.integers(len(woods))]) if rgb is None else rgb
    return Material(textures.wood(rng, own), (0.5, 0.5), gloss=0.12, sharpness=25.0)


def cloth(rng: np.random.Generator, rgb: Colour | None = None) -> Material:
    """Return woven stuff: plain, striped or checked where no colour is given."""
    first = draw_colour(rng) if rgb is None else rgb
    pattern = rng.random() if rgb is None else 0.0
    if pattern < 0.6:
        texture, tile = textures.fabric(rng, first), 0.12
    elif pattern < 0.8:
        texture, tile = textures.stripes(rng, [first, draw_colour(rng)]), 0.25
    else:
        texture, tile = textures.checks(rng, [first, draw_colour(rng)]), 0.15
    return Material(texture, (tile, tile), infrared=0.3 if first.mean() < BLACK else 0.9)


def leather(rng: np.random.Generator, rgb: Colour) -> Material:
    """Return grained leather."""
    infrared = 0.15 if rgb.mean() < BLACK else 0.6
    return Material(
        textures.plaster(rng, rgb), (0.2, 0.2), gloss=0.2, sharpness=15.0, infrared=infrared
    )


def rubber() -> Material:
    """Return matt black rubber."""
    return Material(textures.plain(colour(34, 34, 36)), gloss=0.05, infrared=0.12)


def steel(rng: np.random.Generator, rgb: npt.ArrayLike = (146, 148, 152)) -> Material:
    """Return brushed metal of the colour of steel, brass, copper."""
    texture = textures.metal(rng, near(rng, rgb))
    return Material(texture, (0.1, 0.1), gloss=0.6, sharpness=50.0, infrared=0.4)


def chrome(rng: np.random.Generator, rgb: npt.ArrayLike = (152, 154, 158)) -> Material:
    """Return polished metal: the sensor's light goes elsewhere."""
    texture = textures.metal(rng, near(rng, rgb, 4))
    return Material(texture, (0.1, 0.1), gloss=0.9, sharpness=90.0, infrared=0.1)


def glass(rgb: Colour) -> Material:
    """Return tinted glass, drawn opaque; it gives a depth sensor nothing."""
    return Material(textures.plain(rgb), gloss=0.9, sharpness=120.0, infrared=0.02)


def printed(texture: Texture, *, gloss: float = 0.1) -> Material:
    """Return a print that covers a face once."""
    return Material(texture, gloss=gloss, sharpness=30.0)


def shining(rgb: Colour, strength: float) -> Material:
    """Return a surface with light of its own: a lamp's bulb, a display's digits."""
    return Material(textures.plain(rgb), emission=strength, infrared=0.5)


def _bands(rng: np.random.Generator, rgb: Colour) -> Texture:
    upright = textures.stripes(rng, [rgb, rgb, draw_colour(rng, vivid=0.8)])
    return np.ascontiguousarray(upright.transpose(1, 0, 2))
