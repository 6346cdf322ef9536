"""A tiny furniture library: one crate."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Mesh
from curiosight.rooms.sweet_home import SweetHomeLibrary

Array = npt.NDArray[Any]
CATALOGUE = """# a comment
id=Tiny
id#1=tiny#crate
name#1=Wooden \\u201ccrate\\u201d
category#1=Boxes
model#1=/models/crate.obj
width#1=40
depth#1=30.0
height#1=20
movable#1=true
doorOrWindow#1=false
"""
# A unit cube, y up; z = 1 is the front, which alone shows the picture.
CRATE = b"""mtllib crate.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl front
f 5/1 6/2 7/3 8/4
usemtl sides
f 1 4 3 2\nf 4 8 7 3\nf 1 2 6 5\nf 1 5 8 4\nf -7 -6 -2 -3
"""
MATERIALS = b"newmtl front\nmap_Kd front.png\nnewmtl sides\nKd 1 0 0\nKs 1 1 1\nNs 50\n"
RED = (255, 0, 0)
GREEN = (0, 255, 0)


def picture(top: tuple[int, int, int] = RED, bottom: tuple[int, int, int] = GREEN) -> bytes:
    """Return a PNG of 600x300 of two colours."""
    image = np.empty((300, 600, 3), np.uint8)
    image[:150], image[150:] = top[::-1], bottom[::-1]
    return bytes(cv2.imencode(".png", image)[1])


def members() -> dict[str, bytes]:
    return {
        "PluginFurnitureCatalog.properties": CATALOGUE.encode("latin-1"),
        "models/crate.obj": CRATE,
        "models/crate.mtl": MATERIALS,
        "models/front.png": picture(),
    }


def write_library(path: Path, **changes: bytes | None) -> Path:
    """Write the tiny library; `changes` replace members (by ending) or, as None, leave them out."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members().items():
            new = changes.get(name.rpartition(".")[2], content)
            if new is not None:
                archive.writestr(name, new)
    return path


def only_mesh(path: Path) -> Mesh:
    library = SweetHomeLibrary(path)
    return library.mesh(library.entries[0])


def face_colour(mesh: Mesh, normal: tuple[float, float, float]) -> Array:
    """Return the mean colour of the material of all triangles that face one way."""
    faces = (mesh.normals[mesh.triangles].mean(1) @ np.array(normal)) > 0.99
    materials = {int(number) for number in mesh.surface[faces]}
    assert len(materials) == 1
    colour: Array = mesh.materials[materials.pop()].texture.reshape(-1, 3).mean(0)
    return colour
