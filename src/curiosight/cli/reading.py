"""The options that say how a recording is to be read: every command with a SOURCE has them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

# "reading.key" to value, for `load_config`; None = not given.
ReadingOverrides = Mapping[str, Any]
PANEL = "Reading the recording"

_OPTIONS: dict[str, Any] = {
    "depth_scale": Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="Metres per unit of depth, whatever the recording says: 0.001 = millimetres.",
            rich_help_panel=PANEL,
            show_default="as the recording says",
        ),
    ],
    "fix_units": Annotated[
        bool | None,
        typer.Option(
            "--fix-units",
            metavar="",
            help="Read depth in the unit that its readings and the poses speak for.",
            rich_help_panel=PANEL,
            show_default="off",
        ),
    ],
    "invert_poses": Annotated[
        bool | None,
        typer.Option(
            "--invert-poses",
            metavar="",
            help="Poses are world to camera: turn them round.",
            rich_help_panel=PANEL,
            show_default="off",
        ),
    ],
    "pose_axes": Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Where the camera axes of the poses point: right,up,backward for OpenGL's.",
            rich_help_panel=PANEL,
            show_default="right,down,forward",
        ),
    ],
    "min_confidence": Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Leave out depth that is less sure than this, where confidence is recorded.",
            rich_help_panel=PANEL,
            show_default="1",
        ),
    ],
    "depth_camera": Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Depth is not registered to colour: a JSON file with width, height, fx, fy, cx, "
            "cy of the depth camera and T_colour_depth, 4 rows of 4 numbers, says how to.",
            rich_help_panel=PANEL,
        ),
    ],
    "topics": Annotated[
        str | None,
        typer.Option(
            metavar="color=/A,depth=/B",
            help="Topics of a bag to read, also info=/C of colour's CameraInfo and pose=/D.",
            rich_help_panel=PANEL,
            show_default="guessed, and said",
        ),
    ],
}


def reads_source(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command these options; it gets them together as its argument `reading`."""
    own = inspect.signature(command)
    hints = get_type_hints(command, include_extras=True)
    kept = [
        parameter.replace(annotation=hints[name])
        for name, parameter in own.parameters.items()
        if name != "reading"
    ]
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=hint)
        for name, hint in _OPTIONS.items()
    ]

    @wraps(command)
    def with_options(*args: Any, **given: Any) -> None:
        values = {name: given.pop(name, None) for name in _OPTIONS}
        path = values["depth_camera"]
        # It is kept in the run's config.toml, which is read from anywhere.
        values["depth_camera"] = None if path is None else str(path.absolute())
        command(*args, **given, reading={f"reading.{name}": v for name, v in values.items()})

    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in kept] + added
    with_options.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    with_options.__annotations__ = {p.name: p.annotation for p in parameters} | {"return": None}
    del with_options.__wrapped__  # type: ignore[attr-defined]
    return with_options
