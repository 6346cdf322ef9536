"""The commands: curiosight info, segment, explore, learn, map, evaluate."""

from curiosight.cli.app import main

__all__ = ["main"]
