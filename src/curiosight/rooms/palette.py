"""The colours that things and walls share, so that no colour tells an object by itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Colour = npt.NDArray[np.uint8]
Shade = tuple[int, int, int]

VIVID = (
    (178, 34, 40),
    (206, 92, 28),
    (226, 178, 52),
    (84, 138, 62),
    (34, 102, 92),
    (38, 84, 150),
    (92, 66, 132),
    (196, 92, 128),
    (70, 150, 190),
)
MUTED = (
    (226, 218, 202),
    (200, 188, 168),
    (160, 144, 124),
    (122, 92, 66),
    (150, 110, 70),
    (92, 96, 98),
    (52, 52, 56),
    (182, 186, 186),
    (142, 154, 140),
    (120, 136, 150),
    (236, 234, 228),
)


class Palette(NamedTuple):
    """The colours of one room: (r, g, b) each, strong ones and quiet ones."""

    vivid: Sequence[Shade]
    muted: Sequence[Shade]


EVERYTHING = Palette(VIVID, MUTED)
_palette: ContextVar[Palette] = ContextVar("palette", default=EVERYTHING)


@contextmanager
def painted_with(palette: Palette) -> Iterator[None]:
    """Draw with the colours of one room inside of this context, in this thread."""
    token = _palette.set(palette)
    try:
        yield
    finally:
        _palette.reset(token)


def draw_palette(rng: np.random.Generator, n_vivid: int = 4, n_muted: int = 5) -> Palette:
    """Draw some of all colours, for a room that has its own."""
    vivid, muted = (
        tuple(colours[number] for number in sorted(rng.permutation(len(colours))[:n]))
        for colours, n in ((VIVID, n_vivid), (MUTED, n_muted))
    )
    return Palette(vivid, muted)


def draw_muted(rng: np.random.Generator) -> Shade:
    """Draw one of the quiet colours, as it stands in the palette."""
    muted = _palette.get().muted
    return muted[int(rng.integers(len(muted)))]


def draw_colour(rng: np.random.Generator, *, vivid: float = 0.5, spread: float = 12.0) -> Colour:
    """Return an (3,) sRGB colour near one of the palette's.

    vivid: chance that it is one of the strong ones. spread: standard deviation of each channel.
    """
    palette = _palette.get()
    colours = palette.vivid if rng.random() < vivid else palette.muted
    colour = np.asarray(colours[int(rng.integers(len(colours)))]) + rng.normal(0, spread, 3)
    return np.clip(np.rint(colour), 8, 247).astype(np.uint8)
