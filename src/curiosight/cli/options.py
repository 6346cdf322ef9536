"""The options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SETTINGS = "Settings"
OUTPUT = "Output"


def absolute_source(teacher: str | None) -> str | None:
    """Return a teacher's name whose path holds anywhere: it is kept in the run's config.toml."""
    kind, colon, path = (teacher or "").partition(":")
    return f"{kind}:{Path(path).absolute()}" if colon and path else teacher


Source = Annotated[
    Path,
    typer.Argument(
        metavar="SOURCE",
        help="A recording's folder, of nearly any layout (`curiosight info` says how it is read), "
        "a ROS bag, or room:SEED or home:SEED.",
    ),
]
ResumableSource = Annotated[
    Path | None,
    typer.Argument(
        metavar="SOURCE",
        help="A recording's folder, of nearly any layout (`curiosight info` says how it is read), "
        "or room:SEED or home:SEED; none with --resume.",
        show_default=False,
    ),
]
Resume = Annotated[
    Path | None,
    typer.Option(
        "--resume",
        metavar="RUN",
        help="Go on where a kill or Ctrl-C ended this run; without SOURCE and settings.",
        rich_help_panel=OUTPUT,
    ),
]
Run = Annotated[Path, typer.Argument(metavar="RUN", help="The folder that explore or learn wrote.")]
Preset = Annotated[
    str | None,
    typer.Option(
        help="paper = the paper's method to the letter; default = ours, faster and better.",
        rich_help_panel=SETTINGS,
        show_default="default",
    ),
]
ConfigFile = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="File of settings; flags win over it. Start from the config.toml of a run.",
        rich_help_panel=SETTINGS,
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        help="Where all chance starts: the same seed gives the same result.",
        rich_help_panel=SETTINGS,
        show_default="0",
    ),
]
Scene = Annotated[
    str | None,
    typer.Option(
        help="floor: nothing else is a support, a desk is one object with what is on it. table: "
        "objects stand on a table. auto: told for each support in view.",
        rich_help_panel=SETTINGS,
        show_default="auto",
    ),
]
Up = Annotated[
    str | None,
    typer.Option(
        help="Where up points in the image: up, down, left or right; towards the camera where it "
        "looks straight down, away from it where straight up; or auto = find out.",
        rich_help_panel=SETTINGS,
        show_default="auto",
    ),
]
Teacher = Annotated[
    str | None,
    typer.Option(
        help="What labels the frames: depth, depth+masks:FOLDER (<id>.png of a segmenter, a number "
        "an instance, tell where objects end), masks:FOLDER (<id>.png: 255 salient, 0 not, 125 "
        "unknown) or boxes:FILE (a detector's, COCO JSON).",
        callback=absolute_source,
        rich_help_panel=SETTINGS,
        show_default="depth",
    ),
]
Temporal = Annotated[
    bool,
    typer.Option(
        "--temporal",
        help="With poses: let what several views agree on correct each of them (not with "
        "--preset paper).",
        rich_help_panel=SETTINGS,
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
        help="Folder of true masks, <frame id>.png: 255 salient, 0 not salient, else ignored.",
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
        metavar="",
        help="Write into a folder that is not empty: results of the same kind are removed first, "
        "all else stays unless it has the same name.",
        rich_help_panel=OUTPUT,
    ),
]
Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet",
        "-q",
        metavar="",
        help="Say nothing but warnings and errors.",
        rich_help_panel=OUTPUT,
    ),
]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        metavar="",
        help="Print the results as JSON on standard output.",
        rich_help_panel=OUTPUT,
    ),
]
