"""Textures at sizes that halve, so that a far one does not flicker."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log2
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.rooms.compiling import kernel
from curiosight.rooms.mesh import Floats, Material, Texture
from curiosight.rooms.vectors import Triple

# The first is the texture itself, the last about two texels wide for one of 512.
N_LEVELS = 9
_CODES = np.arange(256) / 255
LINEAR_OF_SRGB = np.where(
    _CODES <= 0.04045, _CODES / 12.92, ((_CODES + 0.055) / 1.055) ** 2.4
).astype(np.float32)


class Mipmaps(NamedTuple):
    """The textures of all materials, each N_LEVELS times.

    texels: (N, 3) uint8 sRGB, one row of one texture after the other. places: (M, N_LEVELS, 3)
    int32 of each material's levels: the first texel, width, height.
    """

    texels: Texture
    places: npt.NDArray[np.int32]


def mipmaps(materials: Sequence[Material]) -> Mipmaps:
    """Shrink each texture again and again; a texel is the mean light of those it covers."""
    texels: list[Texture] = []
    places: list[tuple[int, int, int]] = []
    n_texels = 0
    for material in materials:
        level = material.texture
        for _ in range(N_LEVELS):
            height, width = level.shape[:2]
            places.append((n_texels, width, height))
            texels.append(level.reshape(-1, 3))
            n_texels += height * width
            level = halved(level)
    return Mipmaps(np.concatenate(texels), np.array(places, np.int32).reshape(-1, N_LEVELS, 3))


def halved(texture: Texture) -> Texture:
    """Return the texture at half the width and height, both at least one texel."""
    height, width = (max(side // 2, 1) for side in texture.shape[:2])
    linear = cv2.resize(LINEAR_OF_SRGB[texture], (width, height), interpolation=cv2.INTER_AREA)
    return srgb_of_linear(linear.reshape(height, width, 3))


def srgb_of_linear(linear: Floats) -> Texture:
    """Return the nearest sRGB codes of light in [0, 1]."""
    between = (LINEAR_OF_SRGB[1:] + LINEAR_OF_SRGB[:-1]) / 2
    return np.searchsorted(between, linear).astype(np.uint8)


def mean_albedo(materials: Sequence[Material]) -> Floats:
    """Return the (M, 3) share of light that each material sends back."""
    means = [LINEAR_OF_SRGB[material.texture].mean((0, 1)) for material in materials]
    return np.array(means, np.float32)


@kernel
def bilinear(texels: Texture, place: tuple[int, int, int], s: float, t: float) -> Triple:
    """Return the linear colour at (s, t), in repeats of a texture: first texel, width, height."""
    start, width, height = place
    x, y = (s - floor(s)) * width - 0.5, (t - floor(t)) * height - 0.5
    left, top = floor(x), floor(y)
    right, bottom = left + 1, top + 1
    share_x, share_y = np.float32(x - left), np.float32(y - top)
    both = share_x * share_y
    shares = (np.float32(1) - share_x - share_y + both, share_x - both, share_y - both, both)
    left, top = left if left >= 0 else width - 1, top if top >= 0 else height - 1
    right, bottom = right if right < width else 0, bottom if bottom < height else 0
    upper, lower = start + top * width, start + bottom * width
    corners = (upper + left, upper + right, lower + left, lower + right)
    red = green = blue = np.float32(0)
    for k in range(4):
        red += shares[k] * LINEAR_OF_SRGB[texels[corners[k], 0]]
        green += shares[k] * LINEAR_OF_SRGB[texels[corners[k], 1]]
        blue += shares[k] * LINEAR_OF_SRGB[texels[corners[k], 2]]
    return float(red), float(green), float(blue)


@kernel
def trilinear(
    texels: Texture, places: npt.NDArray[np.int32], n_texels: float, s: float, t: float
) -> Triple:
    """Return the linear colour around (s, t) for a pixel that is `n_texels` wide there.

    places: (N_LEVELS, 3) of one texture, see Mipmaps.
    """
    level = min(log2(max(n_texels, 1.0)), N_LEVELS - 1.0)
    finer = int(level)
    mix = level - finer
    place = (places[finer, 0], places[finer, 1], places[finer, 2])
    red, green, blue = bilinear(texels, place, s, t)
    if mix == 0:
        return red, green, blue
    place = (places[finer + 1, 0], places[finer + 1, 1], places[finer + 1, 2])
    r, g, b = bilinear(texels, place, s, t)
    return red + mix * (r - red), green + mix * (g - green), blue + mix * (b - blue)
