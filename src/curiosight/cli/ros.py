"""curiosight ros: a ROS 2 node that maps what a camera sees, learns, and explores by Nav2."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options

NODE = "Node"


def ros(
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN",
            help="Map by the model of a run from the first image on.",
            rich_help_panel=NODE,
        ),
    ] = None,
    learn: Annotated[
        bool,
        typer.Option(
            "--learn",
            metavar="",
            help="Learn from what depth says; with --model go on with that one.",
            rich_help_panel=NODE,
        ),
    ] = False,
    ros_args: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[--ros-args …]",
            help="For ROS: parameters (-p color_topic:=/image), remappings, a name.",
            show_default=False,
        ),
    ] = None,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Run a ROS 2 node: map what a camera sees, learn meanwhile, and explore by Nav2.

    Needs rclpy and vision_msgs of a ROS 2 that is sourced. Topics, parameters, services and the
    action: docs/ros.md. Writes config.toml and model.npz where it learns. Ctrl-C, SIGTERM and
    SIGHUP keep all of it.
    """
    from curiosight.cli.interrupt import CtrlC
    from curiosight.cli.talk import Talk
    from curiosight.config import load_config
    from curiosight.experiments.output import OutputFolder
    from curiosight.experiments.ros.node import Asked
    from curiosight.experiments.ros.running import run_node
    from curiosight.learner.archive import MODEL

    if ros_args and ros_args[0] != "--ros-args":
        raise ValueError(f"ros: expected options, then --ros-args, got {ros_args[0]!r}")
    talk = Talk(quiet=quiet)
    overrides = {
        "run.seed": seed,
        "run.n_threads": 1,  # the other core is for maps
        "teacher.scene": scene,
        "teacher.up": up,
    }
    settings = load_config(preset, config, overrides)
    folder = OutputFolder(out, "ros", None, overwrite=overwrite)
    folder.keep(MODEL)  # until there is another
    with CtrlC() as ctrl_c:
        asked = Asked(model, is_learning=learn)
        has_begun = run_node(settings, folder, asked, lambda: not ctrl_c.is_pressed, ros_args or ())
    if not has_begun:
        raise typer.Exit(2)
    if ctrl_c.is_pressed:
        if folder.path.exists():
            talk.note(f"what was learned is kept in {folder.path}")
        raise typer.Exit(ctrl_c.status)
