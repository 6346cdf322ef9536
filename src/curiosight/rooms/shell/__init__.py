"""The fixed part of a room: floor, walls, windows, doors, lamps, and what hangs on walls."""

from curiosight.rooms.shell.drawing import Shell, draw_shell
from curiosight.rooms.shell.mood import USUAL, Mood
from curiosight.rooms.shell.openings import DOORWAY, draw_windows
from curiosight.rooms.shell.walls import Opening

__all__ = ["DOORWAY", "USUAL", "Mood", "Opening", "Shell", "draw_shell", "draw_windows"]
