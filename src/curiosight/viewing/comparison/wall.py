"""The wall of maps as in figure 4, put together as pictures: a line for each frame."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from curiosight.viewing.comparison.confusion import (
    Image,
    confusion,
    map_picture,
)
from curiosight.viewing.comparison.content import WallRow
from curiosight.viewing.truth import truth_picture

TILE_PX = 240  # width of a picture of the mosaic
GAP_PX = 8
MAX_MAPS = 9  # side by side: more would be too small on a printed page
_MAX_CAPTION = 11
_MAX_TITLE_LINE = 12
_MAX_WORD = 15


@dataclass(frozen=True, slots=True, eq=False)
class Mosaic:
    """Pictures of several frames in lines and columns.

    picture: (H, W, 3). titles: of the columns, with the u of their middle.
    captions: of the lines, with the v of their middle.
    """

    picture: Image
    titles: list[tuple[str, float]]
    captions: list[tuple[str, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """A picture of a frame and what it is."""

    title: str
    picture: Image


def map_names(rows: Sequence[WallRow]) -> list[str]:
    """Return the names of all maps, in the order in which they appear."""
    return list(dict.fromkeys(name for row in rows for name in row.maps))


def blocks(rows: Sequence[WallRow]) -> list[list[str]]:
    """Deal the names of the maps out to blocks of like width."""
    names = map_names(rows)
    n_blocks = max(1, -(-len(names) // MAX_MAPS))
    ends = np.linspace(0, len(names), n_blocks + 1).round().astype(int)
    return [names[start:end] for start, end in pairwise(ends)]


def tiles(row: WallRow, names: Sequence[str], *, has_mistakes: bool) -> Iterator[Tile]:
    """Yield image, truth, and the maps of those names; a map that there is not is blank.

    has_mistakes: before the first map what it finds, misses and invents.
    """
    yield Tile("image", row.rgb)
    yield Tile("truth", truth_picture(row.truth))
    height, width = row.truth.shape
    for place, name in enumerate(names):
        saliency = row.maps.get(name)
        blank = np.full_like(row.rgb, 255)
        if has_mistakes and place == 0:
            mistakes = (
                blank
                if saliency is None
                else confusion(row.rgb, row.truth, saliency, row.threshold)
            )
            yield Tile(f"mistakes of {name}", mistakes)
        yield Tile(name, blank if saliency is None else map_picture(saliency, (height, width)))


def mosaic(rows: Sequence[WallRow], names: Sequence[str], *, has_mistakes: bool) -> Mosaic:
    """Return the `tiles` of all frames, a line for each."""
    of_rows = [list(tiles(row, names, has_mistakes=has_mistakes)) for row in rows]
    lines, captions, top = [], [], 0
    for row, of_row in zip(rows, of_rows, strict=True):
        line = _beside([_scaled(tile.picture) for tile in of_row])
        captions.append((_ending(row.caption), top + len(line) / 2))
        top += len(line) + GAP_PX
        lines.append(line)
    step = TILE_PX + GAP_PX
    titles = [
        (folded(tile.title), column * step + TILE_PX / 2) for column, tile in enumerate(of_rows[0])
    ]
    return Mosaic(_below(lines), titles, captions)


def folded(title: str) -> str:
    """Break a title at its spaces and hyphens into lines that fit above a picture."""
    lines = [""]
    for part in re.findall(r"[^\s-]+-?|-", title):
        joint = " " if lines[-1] and not lines[-1].endswith("-") else ""
        longer = lines[-1] + joint + part
        if lines[-1] and len(longer) > _MAX_TITLE_LINE:
            lines.append(part)
        else:
            lines[-1] = longer
    return "\n".join(line if len(line) <= _MAX_WORD else f"{line[:_MAX_WORD]}…" for line in lines)


def _beside(pictures: Sequence[Image]) -> Image:
    """Join pictures of one size from left to right, white between them."""
    gap = np.full((len(pictures[0]), GAP_PX, 3), 255, np.uint8)
    return np.hstack([part for picture in pictures for part in (picture, gap)][:-1])


def _below(lines: Sequence[Image]) -> Image:
    """Join pictures of one width from top to bottom, white between them."""
    gap = np.full((GAP_PX, lines[0].shape[1], 3), 255, np.uint8)
    return np.vstack([part for line in lines for part in (line, gap)][:-1])


def _ending(caption: str) -> str:
    """Return the end of a caption, where frames differ, as long as a picture is high."""
    return caption if len(caption) <= _MAX_CAPTION else f"…{caption[1 - _MAX_CAPTION :]}"


def _scaled(picture: Image) -> Image:
    """Return a picture as wide as a tile."""
    height, width = picture.shape[:2]
    size = (TILE_PX, max(1, round(height * TILE_PX / width)))
    how = cv2.INTER_AREA if width > TILE_PX else cv2.INTER_NEAREST
    scaled: Image = cv2.resize(picture, size, interpolation=how)
    return scaled
