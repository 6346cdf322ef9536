"""Things from a furniture library of Sweet Home 3D, to stand in a drawn room."""

from curiosight.rooms.sweet_home.catalogue import Entry
from curiosight.rooms.sweet_home.library import SweetHomeLibrary

__all__ = ["Entry", "SweetHomeLibrary"]
