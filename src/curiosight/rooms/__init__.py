"""Rooms that the program draws itself: to look around in, with the truth of every pixel."""

from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.settings import RoomSettings, is_room, parse_room
from curiosight.rooms.views import Look, RoomViews

__all__ = ["Look", "Room", "RoomSettings", "RoomViews", "draw_room", "is_room", "parse_room"]
