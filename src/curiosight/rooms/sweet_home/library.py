"""A furniture library of Sweet Home 3D: an `.sh3f`, a zip of models and a catalogue.

Whatever is in such a file, reading it ends with a mesh or a `DataError`, within bounds of memory
and time, and opens no other file.
"""

from __future__ import annotations

import posixpath
from pathlib import Path

import numpy as np

from curiosight.errors import DataError
from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.sweet_home.catalogue import (
    CATALOGUE,
    CatalogueError,
    Entry,
    read_catalogue,
)
from curiosight.rooms.sweet_home.materials import material_of
from curiosight.rooms.sweet_home.model_mesh import model_mesh
from curiosight.rooms.sweet_home.untrusted_zip import UntrustedZip
from curiosight.rooms.sweet_home.wavefront import (
    MAX_TRIANGLES,
    Model,
    ModelError,
    Paint,
    count_triangles,
    read_mtl,
    read_obj,
)

REMEDY = "give a furniture library of Sweet Home 3D (.sh3f)"
MAX_MODEL_BYTES = 256 * 2**20
MAX_LIBRARY_BYTES = 2**30
# Two models of a library that is CC0 otherwise are CC BY: each picture would owe a credit.
LEFT_OUT = frozenset({"winchesterArmchair", "winchesterSofa"})


class SweetHomeLibrary:
    """The things of an `.sh3f` file; raises `DataError` where it is not one.

    entries: all of its catalogue, but for two whose licence asks for a credit in pictures.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        with UntrustedZip(self.path, REMEDY, MAX_MODEL_BYTES) as archive:
            content = archive.read(CATALOGUE)
        try:
            entries = read_catalogue(content)
        except CatalogueError as error:
            raise DataError(self.path, f"a broken catalogue: {error}", REMEDY) from error
        self.entries = tuple(
            entry for entry in entries if posixpath.basename(entry.model)[:-4] not in LEFT_OUT
        )

    def things(
        self,
        *,
        min_size: float = 0.08,
        max_size: float = 1.5,
        max_triangles: int = MAX_TRIANGLES,
    ) -> tuple[Entry, ...]:
        """Return the entries that can stand about as objects.

        They are free-standing, `min_size` to `max_size` metres across, OBJ models that the file
        holds, and of at most `max_triangles` by a quick count.
        """
        with UntrustedZip(self.path, REMEDY, MAX_LIBRARY_BYTES) as archive:
            return tuple(
                entry
                for entry in self.entries
                if entry.is_free_standing
                and min_size <= entry.diagonal <= max_size
                and entry.model.lower().endswith(".obj")
                and entry.model in archive
                and count_triangles(archive.read(entry.model)) <= max_triangles
            )

    def mesh(self, entry: Entry) -> Mesh:
        """Return an entry's mesh: z up, front to -y, standing on z = 0 in the middle.

        Raises `DataError` on a model that is missing, broken or too fine. A picture or a file of
        materials that the library does not hold, as happens, is a plain colour instead.
        """
        with UntrustedZip(self.path, REMEDY, MAX_MODEL_BYTES) as archive:
            try:
                model = read_obj(archive.read(entry.model))
                folder = posixpath.dirname(entry.model)
                materials = _materials(archive, folder, model)
                rotation = np.array(entry.rotation).reshape(3, 3)
                return model_mesh(model, materials, entry.size, rotation)
            except ModelError as error:
                found = f"{entry.model} in it cannot be used: {error}"
                raise DataError(self.path, found, REMEDY) from error


def _materials(archive: UntrustedZip, folder: str, model: Model) -> list[Material]:
    paints: dict[str, Paint] = {}
    for name in model.libraries:
        member = posixpath.join(folder, name)
        if member in archive:
            paints |= read_mtl(archive.read(member))
    materials = []
    for name in model.materials:
        paint = paints.get(name, Paint())
        image = posixpath.join(folder, paint.image) if paint.image else None
        is_there = image is not None and image in archive
        materials.append(material_of(paint, archive.read(image) if image and is_there else None))
    return materials
