"""What a strategy can be sent into."""

from curiosight.worlds.check import check_world
from curiosight.worlds.replay import ReplayWorld
from curiosight.worlds.room_world import RoomWorld
from curiosight.worlds.sources import is_drawn, open_drawn, open_source
from curiosight.worlds.travel import Odometer, travel
from curiosight.worlds.world import World

__all__ = [
    "Odometer",
    "ReplayWorld",
    "RoomWorld",
    "World",
    "check_world",
    "is_drawn",
    "open_drawn",
    "open_source",
    "travel",
]
