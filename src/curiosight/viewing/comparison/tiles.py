"""The wall of maps on a page: for each frame its pictures, each with its name."""

from __future__ import annotations

from collections.abc import Sequence

from curiosight.viewing.comparison.confusion import OUTCOMES
from curiosight.viewing.comparison.content import WallRow
from curiosight.viewing.comparison.wall import Tile, map_names, tiles
from curiosight.viewing.overlays import Colour
from curiosight.viewing.report.embedding import shrunken, source
from curiosight.viewing.report.markup import Markup, element, join
from curiosight.viewing.truth import HATCH, IGNORED

MAX_WIDTH_PX = 320
MAX_COLUMNS = 10


def wall(rows: Sequence[WallRow]) -> Markup:
    """Return what the colours mean, and the pictures of all frames."""
    names = map_names(rows)
    return join((_key(), *[_frame(row, names) for row in rows]))


def _frame(row: WallRow, names: Sequence[str]) -> Markup:
    pictures = [_tile(tile, row) for tile in tiles(row, names, has_mistakes=True)]
    n_lines = -(-len(pictures) // MAX_COLUMNS)
    n_columns = -(-len(pictures) // n_lines)  # so that the last line is about as long as the others
    return element(
        "figure",
        {"class": "example"},
        element("figcaption", {}, row.caption),
        element("div", {"class": "tiles", "style": f"--columns:{n_columns}"}, *pictures),
    )


def _tile(tile: Tile, row: WallRow) -> Markup:
    described = f"{row.caption}: {tile.title}"
    image = element("img", {"alt": described, **source(shrunken(tile.picture, MAX_WIDTH_PX))})
    return element("figure", {}, element("figcaption", {}, tile.title), image)


def _key() -> Markup:
    swatches = [_swatch(name, f"background:{_css(c)}") for name, c in OUTCOMES.items()]
    stripes = f"{_css(IGNORED)} 0 3px,{_css(HATCH)} 3px 4px"
    hatched = f"background:repeating-linear-gradient(135deg,{stripes})"
    ignored = _swatch("ignored: truth not known", hatched)
    return element("ul", {"class": "key"}, *swatches, ignored)


def _swatch(name: str, style: str) -> Markup:
    return element("li", {}, element("span", {"class": "swatch", "style": style}), name)


def _css(colour: Colour) -> str:
    return "rgb({},{},{})".format(*colour)
