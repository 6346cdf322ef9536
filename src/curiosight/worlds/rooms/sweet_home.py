"""Things from a furniture library of Sweet Home 3D: an `.sh3f`, a zip of models and a catalogue.

Whatever is in such a file, reading it ends with a mesh or a `DataError`, within bounds of memory
and time, and opens no other file.
"""

from __future__ import annotations

import posixpath
import re
import struct
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.worlds.rooms.mesh import Material, Mesh, Texture
from curiosight.worlds.rooms.model_mesh import model_mesh
from curiosight.worlds.rooms.untrusted_zip import UntrustedZip
from curiosight.worlds.rooms.wavefront import (
    MAX_TRIANGLES,
    Model,
    ModelError,
    Paint,
    count_triangles,
    read_mtl,
    read_obj,
)

CATALOGUE = "PluginFurnitureCatalog.properties"
REMEDY = "give a furniture library of Sweet Home 3D (.sh3f)"
MAX_CATALOGUE_BYTES = 8 * 2**20
MAX_MODEL_BYTES = 256 * 2**20
MAX_IMAGE_SIDE = 4096
TEXTURE_SIDE = 256
MAX_METRES = 100.0
# In the library of CC0 models that Debian has these two are CC BY: pictures would owe a credit.
LEFT_OUT = frozenset({"winchesterArmchair", "winchesterSofa"})
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of a library's catalogue.

    size: width, depth and height in metres. model: the OBJ file's name in the zip.
    rotation: nine numbers, row by row, that turn the model before anything else.
    is_free_standing: it is neither built in nor hung up.
    """

    name: str
    category: str
    size: tuple[float, float, float]
    model: str
    rotation: tuple[float, ...] = IDENTITY
    is_free_standing: bool = True

    @property
    def diagonal(self) -> float:
        """Metres across its bounding box."""
        return float(np.linalg.norm(self.size))
