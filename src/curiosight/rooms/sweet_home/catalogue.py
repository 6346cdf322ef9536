"""Read the catalogue of a furniture library: a Java properties file with numbered keys."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

CATALOGUE = "PluginFurnitureCatalog.properties"
MAX_CATALOGUE_BYTES = 8 * 2**20
MAX_ENTRIES = 5000
MAX_METRES = 100.0
NO_ROTATION = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class CatalogueError(Exception):
    """Say what is wrong with a catalogue, such as "entry 7 has no width"."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One thing of a catalogue.

    size: width, depth and height in metres. model: file in the zip.
    rotation: nine numbers, row by row, that turn the model before anything else.
    is_free_standing: neither built in nor hung up.
    """

    name: str
    category: str
    size: tuple[float, float, float]
    model: str
    rotation: tuple[float, ...] = NO_ROTATION
    is_free_standing: bool = True

    @property
    def diagonal(self) -> float:
        """Metres across its bounding box."""
        return math.hypot(*self.size)


def read_catalogue(content: bytes) -> tuple[Entry, ...]:
    """Read all entries in the order of the file; raises `CatalogueError`."""
    if len(content) > MAX_CATALOGUE_BYTES:
        raise CatalogueError(f"it is larger than {MAX_CATALOGUE_BYTES / 2**20:.0f} MB")
    values_of: defaultdict[str, dict[str, str]] = defaultdict(dict)
    for key, value in _properties(content):
        name, hash_, number = key.partition("#")
        if hash_:
            values_of[number][name] = value
    if not 0 < len(values_of) <= MAX_ENTRIES:
        raise CatalogueError(f"it has {len(values_of)} entries, expected 1 to {MAX_ENTRIES}")
    return tuple(_entry(number, values) for number, values in values_of.items())


def _properties(content: bytes) -> list[tuple[str, str]]:
    """Return keys and values of a Java properties file."""
    text = re.sub(r"\\\r?\n[ \t]*", "", content.decode("latin-1"))
    lines = [line.strip() for line in text.splitlines()]
    pairs = [line.partition("=") for line in lines if line and line[0] not in "#!"]
    return [(key.strip(), _unescaped(value.strip())) for key, _, value in pairs]


def _unescaped(text: str) -> str:
    text = re.sub(r"\\u([0-9a-fA-F]{4})", lambda match: chr(int(match[1], 16)), text)
    return re.sub(r"\\(.)", r"\1", text)


def _entry(number: str, values: Mapping[str, str]) -> Entry:
    missing = [key for key in ("name", "model", "width", "depth", "height") if key not in values]
    if missing:
        raise CatalogueError(f"entry {number} has no {missing[0]}")
    width, depth, height = (
        _centimetres(number, key, values[key]) for key in ("width", "depth", "height")
    )
    is_hung_up = values.get("elevation", "0") not in ("0", "0.0")
    is_built_in = values.get("movable", "true") == "false" or (
        values.get("doorOrWindow", "false") == "true"
    )
    return Entry(
        name=values["name"],
        category=values.get("category", ""),
        size=(width, depth, height),
        model=values["model"],
        rotation=_rotation(number, values.get("modelRotation")),
        is_free_standing=not (is_hung_up or is_built_in),
    )


def _centimetres(number: str, key: str, text: str) -> float:
    """Return metres."""
    (size,) = _numbers(text) or (math.nan,)
    if not 0 < size / 100 <= MAX_METRES:
        raise CatalogueError(f"entry {number} has a {key} of {text[:20]!r}")
    return size / 100


def _rotation(number: str, text: str | None) -> tuple[float, ...]:
    if text is None:
        return NO_ROTATION
    rotation = _numbers(text)
    if len(rotation) != 9 or not all(abs(share) <= 1.001 for share in rotation):
        raise CatalogueError(f"entry {number} has a modelRotation of {text[:20]!r}")
    return rotation


def _numbers(text: str) -> tuple[float, ...]:
    """Return the numbers of a line, nothing where one of its words is none."""
    try:
        return tuple(float(word) for word in text.split())
    except ValueError:
        return ()
