"""Rooms that the program draws itself: to look around in, with the truth of every pixel."""
