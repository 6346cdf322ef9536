"""Tables, cupboards, shelves, sofas and beds, and where they stand in a room."""

from curiosight.worlds.rooms.furniture.furnishing import furnish
from curiosight.worlds.rooms.furniture.kind import Furniture, Placed, Top

__all__ = ["Furniture", "Placed", "Top", "furnish"]
