"""The commands by name: what each does in a line, and its module, imported when it is called."""

from __future__ import annotations

import copy
import re
from importlib import import_module
from inspect import cleandoc
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

# Each line is the first of its command's own docstring (a test compares them).
COMMANDS = {
    "demo": "Learn in a drawn room, then find its things again after they were moved.",
    "info": "Say what a recording is: layout, frames, camera, poses, ground truth, regions.",
    "explore": "Explore a recording: look, predict, compare with depth, learn, choose where to "
    "look next.",
    "watch": "Watch a source live: map its newest frame, learn meanwhile, say where to go and why.",
    "ros": "Run a ROS 2 node: map what a camera sees, learn meanwhile, and explore by Nav2.",
    "report": "Make report.html and figures/ of a run of explore again, from what is there.",
    "compare": "Compare strategies: which learns fastest, in looks, metres and seconds of the "
    "robot.",
    "figures": "Draw the paper's figures of a source: SVG, PDF and the numbers as CSV.",
    "learn": "Learn a whole recording at once: the off-line model, the least error to expect.",
    "continual": "Learn places one after the other: how well each is known after each, what is "
    "forgotten.",
    "merge": "Merge the models of robots in the same home: each knows then what all have seen.",
    "map": "Find objects in colour images with a learned model: <id>.png, 255 = surely salient.",
    "saliency": "Write the maps of a baseline, equal to its original: <id>.png, 255 = most "
    "salient.",
    "evaluate": "Score saliency against ground truth, or against the teacher where there is none.",
    "segment": "Segment depth: objects on supports (salient), supports and walls (not), the rest "
    "unknown.",
    "objects": "List what is there: each thing once; since the last visit what is new, moved or "
    "gone.",
    "propose": "Propose boxes: depth draws them, and a model ranks them.",
    "export": "Write a recording for others, as an RL-IAC folder or a ROS bag; or a run's model.",
    "render": "Render a room or home that is drawn by seed: colour, depth, poses and ground truth.",
    "score-teacher": "Score the teacher's labels, and its objects, against ground truth.",
    "bench": "Time the stages of the method, frame by frame, on one thread.",
}


class Plain:
    """Show help as it is written: to Rich, words in square brackets are styles, and vanish."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, all of its texts escaped where Rich reads them."""
        shown: Any = copy.copy(self)
        if shown.rich_markup_mode is not None:
            shown = _escaped(shown)
            shown.params = [_escaped(parameter) for parameter in shown.params]
            if isinstance(shown, TyperGroup):
                listed = shown.commands.items()
                shown.commands = {name: _escaped(command) for name, command in listed}
        parent: Any = super(Plain, shown)
        parent.format_help(ctx, formatter)


class Command(Plain, TyperCommand):
    """One command."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options; what follows --ros-args is for ROS, which appends it by itself."""
        if self.name == "ros" and "--ros-args" in args and "--" not in args:
            args = args.copy()
            args.insert(args.index("--ros-args"), "--")
        return super().parse_args(ctx, args)


class Commands(Plain, TyperGroup):
    """All of them; each is read from its module when it is called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        for name, line in COMMANDS.items():
            self.add_command(TyperCommand(name, help=line))

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Find the command that is called, or say which name is near."""
        name, listed, rest = super().resolve_command(ctx, args)
        return name, listed if name is None else load_command(name), rest


def load_command(name: str) -> Any:
    """Return a command with its options."""
    module = import_module(f"curiosight.cli.{name.replace('-', '_')}")
    function = getattr(module, "map_" if name == "map" else name.replace("-", "_"))
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command(name, cls=Command)(function)
    return typer.main.get_command(alone)


def _escaped(part: Any) -> Any:
    """Return a copy of a command or an option whose help Rich shows as it is."""
    from rich.markup import escape  # not to be waited for where no help is shown

    part = copy.copy(part)
    # Rich keeps the line breaks of all paragraphs but the first.
    part.help = part.help and escape(re.sub(r"(?<!\n)\n(?!\n)", " ", cleandoc(part.help)))
    return part
