"""Read Wavefront models (OBJ) and their materials (MTL) as furniture libraries hold them.

The text is not trusted: its size and its numbers are bounded, and whatever cannot be understood
is a `ModelError`.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

MAX_TRIANGLES = 20_000
MAX_VERTICES = 200_000
MAX_LINES = 1_000_000
MAX_LINE_BYTES = 20_000
MAX_MATERIALS = 1000
MAX_COORDINATE = 1e9

# Position and texture place of a polygon's corner, numbers from 0; -1 = no texture place.
Corner = tuple[int, int]


class ModelError(Exception):
    """Say what is wrong with a model, such as "line 7 is not a face of this model"."""


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """What an OBJ file says, its polygons cut into triangles.

    positions: (V, 3). texture_places: (P, 2), v upwards.
    corners: (T, 3, 2) int32 position and texture place; -1 = no texture place.
    material: (T,) int32 place in `materials`, the names.
    libraries: names of MTL files as written.
    """

    positions: npt.NDArray[np.float64]
    texture_places: npt.NDArray[np.float64]
    corners: npt.NDArray[np.int32]
    material: npt.NDArray[np.int32]
    materials: tuple[str, ...]
    libraries: tuple[str, ...]


@dataclass(slots=True)
class Paint:
    """What an MTL file says of a material.

    colour: sRGB, 0 to 1. shine: mean of its highlights' colour, 0 to 1; sharpness: their
        exponent. opacity: 1 = solid. image: the texture's file as written, None = plain.
    """

    colour: tuple[float, float, float] = (0.8, 0.8, 0.8)
    shine: float = 0.0
    sharpness: float = 20.0
    opacity: float = 1.0
    image: str | None = None


def count_triangles(content: bytes) -> int:
    """Return how many triangles an OBJ file has, roughly but fast: without reading it."""
    faces = re.finditer(rb"^f .*", content, re.MULTILINE)
    return sum(face.group().strip().count(b" ") - 2 for face in faces)


def read_obj(content: bytes, *, max_triangles: int = MAX_TRIANGLES) -> Model:
    """Read a model; raises `ModelError`."""
    reader = _ObjReader(max_triangles)
    for number, keyword, rest in _lines(content):
        try:
            reader.read(keyword, rest)
        except (ValueError, IndexError, OverflowError) as error:
            raise ModelError(f"line {number} is not a {keyword} line of this model") from error
    return reader.model()


def read_mtl(content: bytes) -> dict[str, Paint]:
    """Read materials by name; raises `ModelError`."""
    paints: dict[str, Paint] = {}
    paint = Paint()
    for number, keyword, rest in _lines(content):
        try:
            if keyword == "newmtl":
                paint = paints.setdefault(rest, Paint())
            else:
                _read_paint(paint, keyword, rest)
        except (ValueError, IndexError) as error:
            raise ModelError(f"line {number} is not a {keyword} line of a material") from error
        if len(paints) > MAX_MATERIALS:
            raise ModelError(f"more than {MAX_MATERIALS} materials")
    return paints


def _lines(content: bytes) -> Iterator[tuple[int, str, str]]:
    """Yield number, keyword and the rest of each line that says something."""
    stream = io.BytesIO(content)
    number = 0
    while line := stream.readline(MAX_LINE_BYTES):
        number += 1
        if len(line) == MAX_LINE_BYTES or number > MAX_LINES:
            raise ModelError(f"line {number} is too long, or one too many")
        words = line.decode("utf-8", "replace").split(maxsplit=1)
        if words and not words[0].startswith("#"):
            yield number, words[0][:20], words[1].strip() if len(words) > 1 else ""


def _read_paint(paint: Paint, keyword: str, rest: str) -> None:
    if keyword == "Kd":
        red, green, blue = _shares(rest)
        paint.colour = (red, green, blue)
    elif keyword == "Ks":
        paint.shine = sum(_shares(rest)) / 3
    elif keyword == "Ns":
        paint.sharpness = min(max(_number(rest), 1.0), 1000.0)
    elif keyword == "d":
        (paint.opacity,) = _shares(rest.split()[-1])
    elif keyword == "map_Kd":
        paint.image = rest


def _shares(text: str) -> list[float]:
    """Read up to three numbers, cut to 0 to 1."""
    return [min(max(_number(word), 0.0), 1.0) for word in text.split()[:3]]


def _number(text: str) -> float:
    number = float(text)
    if not abs(number) < MAX_COORDINATE:
        raise ValueError(f"number: expected below {MAX_COORDINATE:g}, got {text}")
    return number


class _ObjReader:
    """A model half read."""

    def __init__(self, max_triangles: int) -> None:
        self._max_triangles = max_triangles
        self._positions: list[list[float]] = []
        self._texture_places: list[list[float]] = []
        self._triangles: list[tuple[Corner, Corner, Corner]] = []
        self._material: list[int] = []
        self._materials: dict[str, int] = {}
        self._libraries: list[str] = []
        self._current = ""

    def read(self, keyword: str, rest: str) -> None:
        """Take in one line; ValueError or IndexError where it makes no sense."""
        if keyword == "v":
            x, y, z = (_number(word) for word in rest.split()[:3])
            self._positions.append([x, y, z])
        elif keyword == "vt":
            words = rest.split()
            self._texture_places.append([_number(words[0]), _number(words[1])])
        elif keyword == "f":
            self._read_face(rest)
        elif keyword == "usemtl":
            self._current = rest
        elif keyword == "mtllib":
            self._libraries.append(rest)
        if max(len(self._positions), len(self._texture_places)) > MAX_VERTICES:
            raise ModelError(f"more than {MAX_VERTICES} vertices")

    def _read_face(self, rest: str) -> None:
        corners = [self._corner(word) for word in rest.split()]
        # Always from the same corner: a face and its back, if both are there, are cut alike.
        start = min(range(len(corners)), key=lambda place: self._positions[corners[place][0]])
        first, *others = corners[start:] + corners[:start]
        material = self._materials.setdefault(self._current, len(self._materials))
        for second, third in pairwise(others):
            self._triangles.append((first, second, third))
            self._material.append(material)
        if len(self._triangles) > self._max_triangles:
            raise ModelError(f"more than {self._max_triangles} triangles")

    def _corner(self, word: str) -> Corner:
        numbers = [*word.split("/"), ""]
        position = _index(numbers[0], len(self._positions))
        return position, _index(numbers[1], len(self._texture_places)) if numbers[1] else -1

    def model(self) -> Model:
        """Return all that was read."""
        if not self._triangles:
            raise ModelError("no faces")
        if len(self._materials) > MAX_MATERIALS:
            raise ModelError(f"more than {MAX_MATERIALS} materials")
        return Model(
            np.array(self._positions),
            np.array(self._texture_places).reshape(-1, 2),
            np.array(self._triangles, np.int32),
            np.array(self._material, np.int32),
            tuple(self._materials),
            tuple(self._libraries[:MAX_MATERIALS]),
        )


def _index(text: str, n_known: int) -> int:
    """Return a place from 0 of OBJ's number: from 1, or negative from the last one read."""
    number = int(text)
    place = number - 1 if number > 0 else n_known + number
    if not 0 <= place < n_known or number == 0:
        raise ValueError(f"number: expected 1 to {n_known}, got {text}")
    return place
