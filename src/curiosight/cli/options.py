"""The options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SETTINGS = "Settings"
OUTPUT = "Output"

Source = Annotated[
    Path,
    typer.Argument(
        metavar="SOURCE",
        help="A recording's folder: 7-Scenes, TUM RGB-D, OSD/OCID, or rgb/ depth/ camera.json.",
    ),
]
Run = Annotated[Path, typer.Argument(metavar="RUN", help="The folder that explore or learn wrote.")]
Preset = Annotated[
    str | None,
    typer.Option(
        help="paper = the paper's method to the letter; default = faster and better.",
        rich_help_panel=SETTINGS,
        show_default="default",
    ),
]
ConfigFile = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="Settings; flags win over it. Every run writes one (config.toml) to start from.",
        rich_help_panel=SETTINGS,
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(help="Seed of all chance.", rich_help_panel=SETTINGS, show_default="0"),
]
Scene = Annotated[
    str | None,
    typer.Option(
        help="What the lowest support is: floor, table, or auto = look at the recording.",
        rich_help_panel=SETTINGS,
        show_default="auto",
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(
        help="Trees to grow at the same time; changes no result.",
        rich_help_panel=SETTINGS,
        show_default="2",
    ),
]
GroundTruth = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder of <id>.png, 255 salient, 0 not salient, else ignored.",
        rich_help_panel="Testing",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder to write to, new or empty.",
        rich_help_panel=OUTPUT,
        show_default="runs/<command>-<date>-<time>",
    ),
]
Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="Write into a folder that is not empty; same names are replaced.",
        rich_help_panel=OUTPUT,
    ),
]
Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", help="Say nothing but warnings and errors.", rich_help_panel=OUTPUT
    ),
]
Json = Annotated[
    bool,
    typer.Option(
        "--json", help="Print the results as JSON on standard output.", rich_help_panel=OUTPUT
    ),
]
