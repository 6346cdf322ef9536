"""curiosight render: the views of a room or home as a recording."""

from __future__ import annotations

from contextlib import closing
from math import isfinite
from pathlib import Path
from typing import Annotated, cast

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.talk import Talk, count
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.rendering import LAYOUTS, Layout, render_room, usual_layout
from curiosight.rooms import DrawnViews
from curiosight.viewing.live import announce_compilation
from curiosight.worlds import is_drawn, open_drawn


def render(
    room: Annotated[
        str,
        typer.Argument(metavar="ROOM", help="room:SEED[,key=value…] or home:…, see docs/rooms.md."),
    ],
    views: Annotated[
        int | None,
        typer.Option(
            help="How many viewpoints, drawn by the seed; of a home in each room.",
            show_default="200, of a home 60",
        ),
    ] = None,
    pose: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y,HEADING",
            help="Look from here instead, or with over=table at this: metres, and degrees from "
            "the x axis. Can be repeated.",
        ),
    ] = None,
    layout: Annotated[
        str | None,
        typer.Option(
            help=" or ".join(LAYOUTS) + "; sensor=lidar has a place in plain alone.",
            show_default="tum; plain for sensor=lidar",
        ),
    ] = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Render a room or home that is drawn by seed: colour, depth, poses and ground truth.

    Ctrl-C ends it early and keeps a recording of what is written.
    """
    talk = Talk(quiet=quiet, as_json=json)
    if not is_drawn(room):
        raise ValueError(f"room: expected room:SEED[,key=value…] or home:…, got {room!r}")
    if views is not None and pose:
        raise ValueError("views: expected --views or --pose, got both")
    folder = OutputFolder(out, "render", Path(room), overwrite=overwrite)
    with announce_compilation(talk.console):
        looks = open_drawn(room, views=views)
        if pose:
            looks = looks.at_places([_read_pose(text) for text in pose])
        form = usual_layout(looks) if layout is None else layout
        n_written, status = _render(talk, looks, cast(Layout, form), folder)
    summary = {"room": looks.path, "views": n_written, "layout": form, "out": str(folder.path)}
    rows = {"views": count(n_written, "view"), "layout": form, "written to": folder.path}
    talk.results("render", rows, summary)
    if status and n_written < len(looks):
        talk.note(f"stopped after {count(n_written, 'view')}; these are kept")
        raise typer.Exit(status)


def _render(talk: Talk, looks: DrawnViews, layout: Layout, folder: OutputFolder) -> tuple[int, int]:
    """Write the views, to the last or to Ctrl-C; return how many, and `CtrlC.status`."""
    n_written = 0
    with CtrlC() as ctrl_c, closing(render_room(looks, layout, folder)) as rendered:
        talk.introduce(Path(looks.path), looks)
        with talk.following("render", len(looks)) as shown:
            for _ in ctrl_c.until_pressed(rendered):
                n_written += 1
                shown.advance()
    return n_written, ctrl_c.status


def _read_pose(text: str) -> tuple[float, float, float]:
    try:
        x, y, heading = (float(number) for number in text.split(","))
    except ValueError:
        raise ValueError(f"pose: expected X,Y,HEADING such as 1.5,2,90, got {text!r}") from None
    if not all(map(isfinite, (x, y, heading))):
        raise ValueError(f"pose: expected finite numbers, got {text!r}")
    return x, y, heading
