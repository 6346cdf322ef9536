"""The kinds of things that stand about in rooms."""

from curiosight.rooms.things import (
    appliances,
    bags,
    electronics,
    household,
    kitchen,
    lamps,
    office,
    packaging,
    plants,
    seats,
    storage,
    toys,
)
from curiosight.rooms.things.kind import Kind

KINDS: tuple[Kind, ...] = (
    *kitchen.KINDS,
    *packaging.KINDS,
    *appliances.KINDS,
    *electronics.KINDS,
    *lamps.KINDS,
    *office.KINDS,
    *toys.KINDS,
    *plants.KINDS,
    *storage.KINDS,
    *bags.KINDS,
    *seats.KINDS,
    *household.KINDS,
)

__all__ = ["KINDS", "Kind"]
