"""What a room is asked to be, where its seed alone does not say it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from curiosight.rooms.furniture import Wanted
from curiosight.rooms.palette import Palette
from curiosight.rooms.plan import FloorPlan
from curiosight.rooms.shell import Mood, Opening
from curiosight.rooms.things import Kind


@dataclass(frozen=True, slots=True, eq=False)
class Purpose:
    """What a room is for.

    furniture: the most wanted first. things: kinds that stand about. n_on_floor: how many
    are put on the floor. per_square_metre: how many on tables.
    """

    name: str
    furniture: Sequence[Wanted]
    things: Sequence[Kind]
    n_on_floor: int
    per_square_metre: float


@dataclass(frozen=True, slots=True, eq=False)
class Brief:
    """A room of a home: its outline and openings, what it is for, its light and colours."""

    plan: FloorPlan
    openings: tuple[Opening, ...]
    purpose: Purpose
    mood: Mood
    palette: Palette
