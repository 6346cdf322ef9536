"""Homes: rooms on one floor plan, on both sides of a corridor."""

from curiosight.rooms.home.change import Change
from curiosight.rooms.home.home import Home
from curiosight.rooms.home.settings import HomeSettings, is_home, parse_home
from curiosight.rooms.home.views import HomeViews

__all__ = ["Change", "Home", "HomeSettings", "HomeViews", "is_home", "parse_home"]
