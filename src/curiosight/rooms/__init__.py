"""Rooms and homes that the program draws: to look around in, with the truth of every pixel."""

from curiosight.rooms.drawn_views import DrawnViews, Look
from curiosight.rooms.home import HomeSettings, HomeViews, is_home, parse_home
from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.settings import RoomSettings, is_room, parse_room
from curiosight.rooms.views import RoomViews

__all__ = [
    "DrawnViews",
    "HomeSettings",
    "HomeViews",
    "Look",
    "Room",
    "RoomSettings",
    "RoomViews",
    "draw_room",
    "is_home",
    "is_room",
    "parse_home",
    "parse_room",
]
