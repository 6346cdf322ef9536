"""How light a room is: by day and by lamp."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Mood:
    """The light of a room beside what is usual.

    daylight, lamps: in multiples of the usual. tint: of the lamps, red, green and blue.
    """

    daylight: float = 1.0
    lamps: float = 1.0
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)


USUAL = Mood()
