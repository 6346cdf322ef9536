"""What the rooms of a home are for, and how full they are."""

from __future__ import annotations

import numpy as np

from curiosight.rooms.brief import Purpose
from curiosight.rooms.furniture import kitchen, soft, storage, tables
from curiosight.rooms.shell import Mood
from curiosight.rooms.things import (
    appliances,
    bags,
    electronics,
    household,
    lamps,
    office,
    packaging,
    plants,
    seats,
    toys,
)
from curiosight.rooms.things import kitchen as crockery
from curiosight.rooms.things import storage as containers

KITCHEN = Purpose(
    "kitchen",
    (
        (kitchen.kitchen_counter, 1.0),
        (tables.table, 1.0),
        (storage.sideboard, 0.8),
        (storage.shelf, 0.5),
    ),
    (*crockery.KINDS, *packaging.KINDS, *appliances.KINDS, *plants.KINDS, *seats.KINDS[:2]),
    n_on_floor=8,
    per_square_metre=14.0,
)
LIVING_ROOM = Purpose(
    "living room",
    (
        (soft.sofa, 1.0),
        (tables.coffee_table, 1.0),
        (storage.tv_board, 0.9),
        (storage.shelf, 1.0),
        (soft.armchair, 0.8),
        (storage.sideboard, 0.7),
    ),
    (*electronics.KINDS, *lamps.KINDS, *plants.KINDS, *household.KINDS, *seats.KINDS),
    n_on_floor=10,
    per_square_metre=9.0,
)
OFFICE = Purpose(
    "office",
    (
        (tables.desk, 1.0),
        (storage.shelf, 1.0),
        (tables.desk, 0.8),
        (storage.sideboard, 0.7),
        (storage.shelf, 0.6),
    ),
    (*office.KINDS, *electronics.KINDS, *lamps.KINDS, *bags.KINDS, *seats.KINDS[2:4]),
    n_on_floor=10,
    per_square_metre=13.0,
)
BEDROOM = Purpose(
    "bedroom",
    ((soft.bed, 1.0), (storage.wardrobe, 1.0), (storage.sideboard, 0.8), (soft.armchair, 0.5)),
    (*bags.KINDS, *lamps.KINDS, *household.KINDS[2:4], *electronics.KINDS[3:], *office.KINDS[:2]),
    n_on_floor=3,
    per_square_metre=4.0,
)
NURSERY = Purpose(
    "nursery",
    ((soft.bed, 1.0), (tables.table, 1.0), (storage.shelf, 1.0), (storage.sideboard, 0.7)),
    (*toys.KINDS, *toys.KINDS, *office.KINDS[:2], *containers.KINDS[2:], *seats.KINDS[3:]),
    n_on_floor=15,
    per_square_metre=12.0,
)
DINING_ROOM = Purpose(
    "dining room",
    ((tables.table, 1.0), (storage.sideboard, 1.0), (tables.table, 0.4), (storage.shelf, 0.3)),
    (*crockery.KINDS, *packaging.KINDS[4:8], *plants.KINDS, *seats.KINDS[:2], *seats.KINDS[:2]),
    n_on_floor=10,
    per_square_metre=11.0,
)
STORE_ROOM = Purpose(
    "store room",
    (
        (storage.shelf, 1.0),
        (tables.table, 1.0),
        (storage.shelf, 0.8),
        (tables.desk, 0.8),
        (storage.wardrobe, 0.5),
    ),
    (
        *packaging.KINDS,
        *containers.KINDS,
        *bags.KINDS,
        *household.KINDS,
        *appliances.KINDS,
        *seats.KINDS,
        *toys.KINDS,
    ),
    n_on_floor=40,
    per_square_metre=22.0,
)
SPARE_ROOM = Purpose(
    "spare room",
    ((tables.table, 0.5), (soft.armchair, 0.4)),
    (*packaging.KINDS[-1:], *containers.KINDS, *plants.KINDS[1:2], *seats.KINDS[:1]),
    n_on_floor=2,
    per_square_metre=1.0,
)
# What every home of four rooms has, then the others; of more than all it begins anew.
ALWAYS = (STORE_ROOM, SPARE_ROOM)
OTHERS = (LIVING_ROOM, KITCHEN, BEDROOM, OFFICE, NURSERY, DINING_ROOM)
# By broad daylight, by warm lamps in the evening, by cold tubes, in between.
MOODS = (
    Mood(daylight=1.5, lamps=0.3),
    Mood(daylight=0.12, lamps=1.6, tint=(1.1, 0.95, 0.72)),
    Mood(daylight=0.3, lamps=1.4, tint=(0.86, 1.0, 1.12)),
    Mood(),
)


def draw_purposes(
    n_rooms: int, rng: np.random.Generator, n_empty: int | None = None
) -> tuple[Purpose, ...]:
    """Draw what each room is for: one a dump and one nearly empty, where there are four.

    n_empty: so many are nearly empty instead.
    """
    others = [OTHERS[number] for number in rng.permutation(len(OTHERS))]
    first = [*ALWAYS, *others] if n_rooms >= 2 * len(ALWAYS) else others
    if n_empty is not None:
        first = [purpose for purpose in first if purpose is not SPARE_ROOM]
    empty = [SPARE_ROOM] * (n_empty or 0)
    chosen = [first[number % len(first)] for number in range(n_rooms - len(empty))] + empty
    return tuple(chosen[number] for number in rng.permutation(n_rooms))


def draw_moods(n_rooms: int, rng: np.random.Generator) -> tuple[Mood, ...]:
    """Draw the light of each room: all kinds come equally often."""
    return tuple(MOODS[number % len(MOODS)] for number in rng.permutation(n_rooms))
