"""Tables, cupboards, shelves, sofas and beds, and where they stand in a room."""

from curiosight.rooms.furniture.furnishing import Wanted, furnish
from curiosight.rooms.furniture.kind import Furniture, Placed, Top

__all__ = ["Furniture", "Placed", "Top", "Wanted", "furnish"]
