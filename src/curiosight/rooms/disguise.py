"""A room that looks different at every look: nothing that is learned of its colours holds.

Its light and its shapes stay; each of its materials gets any of some patterns, in other colours
and of another size, things and surfaces alike.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Material, Texture
from curiosight.rooms.mipmaps import Mipmaps, mipmaps
from curiosight.rooms.noise import noise
from curiosight.rooms.shading import GLOSS, TILE, Surfaces

N_PATTERNS, SIDE = 64, 128
# Metres that one pattern covers before it repeats.
SMALLEST, LARGEST = 0.25, 1.2


class Disguise:
    """The patterns of one room."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._patterns = mipmaps([Material(pattern(rng)) for _ in range(N_PATTERNS)])

    def put_on(
        self, surfaces: Surfaces, own: Mipmaps, rng: np.random.Generator
    ) -> tuple[Surfaces, Mipmaps]:
        """Return what the kernels read of a room with all its materials changed.

        own: the room's own textures.
        """
        n_materials = len(surfaces.materials)
        metres = np.exp(rng.uniform(np.log(SMALLEST), np.log(LARGEST), n_materials))
        materials = surfaces.materials.copy()
        tile = (metres * uv_per_metre(surfaces, own)).astype(np.float32)
        materials[:, TILE] = materials[:, TILE + 1] = tile
        materials[:, GLOSS] = rng.uniform(0.0, 0.3, n_materials)
        density = (SIDE / metres).astype(np.float32)[surfaces.material]
        negative = (255 * rng.integers(0, 2, 3)).astype(np.uint8)
        texels = self._patterns.texels[:, rng.permutation(3)] ^ negative
        places = self._patterns.places[rng.integers(0, N_PATTERNS, n_materials)]
        changed = surfaces._replace(materials=materials, texel_density=density)
        return changed, Mipmaps(np.ascontiguousarray(texels), np.ascontiguousarray(places))


def pattern(rng: np.random.Generator) -> Texture:
    """Return (SIDE, SIDE, 3) patches of two to four colours, as large as things and as small."""
    n_colours = int(rng.integers(2, 5))
    shape, size = (SIDE, SIDE), float(np.exp(rng.uniform(np.log(4), np.log(20))))
    patches = np.argmax([noise(rng, shape, size) for _ in range(n_colours)], 0)
    colours = rng.uniform(15, 240, (n_colours, 3))
    mottled = colours[patches] * (1 + 0.06 * noise(rng, shape, 1.0)[..., None])
    texture: Texture = np.clip(np.rint(mottled), 0, 255).astype(np.uint8)
    return texture


def uv_per_metre(surfaces: Surfaces, own: Mipmaps) -> npt.NDArray[np.float64]:
    """Return how much of each material's uv one metre is, the mean of its triangles."""
    texels = own.places[:, 0, 1:].prod(1) / surfaces.materials[:, TILE : TILE + 2].prod(1)
    per_triangle = surfaces.texel_density / np.sqrt(texels)[surfaces.material]
    n_materials = len(surfaces.materials)
    n_triangles = np.maximum(np.bincount(surfaces.material, minlength=n_materials), 1)
    sums = np.bincount(surfaces.material, per_triangle, n_materials)
    return np.maximum(sums / n_triangles, 1e-6)
