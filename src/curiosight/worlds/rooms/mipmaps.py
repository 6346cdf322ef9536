"""Textures at sizes that halve, so that a far one does not flicker."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.worlds.rooms.mesh import Floats, Material, Texture

# The first is the texture itself, the last about two texels wide for one of 512.
N_LEVELS = 9
_CODES = np.arange(256) / 255
LINEAR_OF_SRGB = np.where(
    _CODES <= 0.04045, _CODES / 12.92, ((_CODES + 0.055) / 1.055) ** 2.4
).astype(np.float32)


class Mipmaps(NamedTuple):
    """The textures of all materials, each N_LEVELS times.

    texels: (N, 3) uint8 sRGB, one row of one texture after the other. start, width, height:
    (M, N_LEVELS) place in `texels` and size of each material's levels.
    """

    texels: Texture
    start: npt.NDArray[np.int32]
    width: npt.NDArray[np.int32]
    height: npt.NDArray[np.int32]


def mipmaps(materials: Sequence[Material]) -> Mipmaps:
    """Shrink each texture again and again; a texel is the mean light of those it covers."""
    texels: list[Texture] = []
    sizes: list[tuple[int, int]] = []
    for material in materials:
        level = material.texture
        for _ in range(N_LEVELS):
            texels.append(level.reshape(-1, 3))
            sizes.append((level.shape[0], level.shape[1]))
            level = halved(level)
    lengths = np.array([len(rows) for rows in texels])
    start = (np.cumsum(lengths) - lengths).astype(np.int32).reshape(-1, N_LEVELS)
    height, width = np.array(sizes, np.int32).T.reshape(2, -1, N_LEVELS).copy()
    return Mipmaps(np.concatenate(texels), start, width, height)


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
