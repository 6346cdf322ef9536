"""The commands, one file each; `curiosight.cli.commands` lists them."""

from curiosight.cli.app import main

__all__ = ["main"]
