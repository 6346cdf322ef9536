"""curiosight continual: places one after the other, and what is left of the first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import LEARNED_NOTHING_STATUS, tell_lessons
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count
from curiosight.config import load_config, to_toml
from curiosight.experiments.changes import day_of
from curiosight.experiments.continual import Continual, episodes_of
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.learner.archive import MODEL
from curiosight.viewing.continual import draw_changes, draw_qualities
from curiosight.viewing.live import announce_compilation

QUALITIES, FIGURES = "qualities.csv", ("qualities.png", "qualities.svg")
ALARMS, CHANGES = "alarms.csv", ("changes.png", "changes.svg")
ALARM_COLUMNS = (
    *("look", "episode", "look_in_episode", "id", "place", "cause", "was", "now", "n_looks"),
    "reason",
)


@reads_source
def continual(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="A home, whose rooms are learned in turn, or several sources in their order: "
            "home:7 home:7,lights=3 home:7,rearrange=2.",
        ),
    ],
    changes: Annotated[
        bool,
        typer.Option(
            "--changes",
            help="Of one home: its rooms but the last in the morning, in the evening's light, and "
            "rearranged; then the last room. Tells how soon each change is noticed.",
        ),
    ] = False,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    threads: options.Threads = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Learn places one after the other: how well each is known after each, what is forgotten.

    Every frame is looked at once. Writes config.toml, qualities.csv and its figure (row: after
    which episode, column: of which the test frames are, 1 = known best), model.npz after each
    episode, alarms.csv: the looks at which a place was no longer what had been learned of it, and
    by what that was known; and summary.json with average quality, backward transfer, forgetting,
    and the alarms. Ctrl-C, or a signal to end, keeps the episodes that are done. Exit status 1:
    nothing was learned.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(
        preset,
        config,
        {
            **reading,
            "run.seed": seed,
            "teacher.scene": scene,
            "teacher.up": up,
            "teacher.source": teacher,
            "run.n_threads": threads,
        },
    )
    folder = OutputFolder(out, "continual", sources[0], overwrite=overwrite)
    named = [str(source) for source in sources]
    if changes and len(named) > 1:
        raise ValueError(f"sources: expected one home with --changes, got {len(named)} sources")
    episodes = day_of(named[0], settings) if changes else episodes_of(named, settings)
    with announce_compilation(talk.console):
        run = Continual(settings, episodes, lambda: folder.file(MODEL))
        folder.remove((MODEL, QUALITIES, ALARMS, *FIGURES, *CHANGES, "summary.json"))
        folder.write_text("config.toml", to_toml(settings))
        talk.note(f"{count(len(episodes), 'episode')} of {count(len(run), 'look')} together")
        with CtrlC() as ctrl_c, talk.following("learn", len(run), "look") as shown:
            for number, _ in ctrl_c.until_pressed(run):
                shown.advance(episodes[number].name)
    summary = run.summary()
    _write(folder, run, has_figures=talk.can_draw())
    folder.write_json("summary.json", summary)
    talk.warn_of(run.problems, summary["looks"], "taught nothing")
    tell_lessons(talk, run.lessons, has_learned=run.learner.is_trained)
    talk.results("continual", _rows(run, summary, folder), {**summary, "out": str(folder.path)})
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(summary['looks'], 'look')}; what is done is kept")
        raise typer.Exit(ctrl_c.status)
    if not run.learner.is_trained:
        raise typer.Exit(LEARNED_NOTHING_STATUS)


def _write(folder: OutputFolder, run: Continual, *, has_figures: bool) -> None:
    names = [episode.name for episode in run.episodes]
    table = TableFile(folder.file(QUALITIES), ["after", *names])
    for name, row in zip(names, run.qualities.tolist(), strict=True):
        table.add({"after": name} | dict(zip(names, (_or_none(q) for q in row), strict=True)))
    table.close()
    for figure in FIGURES if has_figures else ():
        draw_qualities(run.qualities, names, folder.file(figure))
    alarms = TableFile(folder.file(ALARMS), ALARM_COLUMNS)
    for alarm in run.alarms:
        alarms.add(alarm.summary())
    alarms.close()
    if run.changes():
        lengths = [len(episode.training) for episode in run.episodes]
        told = [(alarm.event.look, alarm.event.alarm.cause) for alarm in run.alarms]
        for figure in CHANGES:
            draw_changes(run.qualities, names, lengths, told, folder.file(figure))


def _or_none(quality: float) -> float | None:
    return None if quality != quality else quality


def _rows(run: Continual, summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    last = [alarm.episode for alarm in run.alarms]
    noticed = {
        f"{one['episode']} ({one['change'] or 'no change'})": _noticed(one)
        for one in summary["changes"]
    }
    return {
        "episodes": len(run.episodes),
        "looks": summary["looks"],
        "average quality (F1)": summary["average_quality"],
        "backward transfer": summary["backward_transfer"],
        "forgetting": summary["forgetting"],
        "alarms": ", ".join(
            f"{last.count(number)} in {episode.name}"
            for number, episode in enumerate(run.episodes)
            if number in last
        )
        or "none",
        **noticed,
        "written to": folder.path,
    }


def _noticed(change: dict[str, Any]) -> str:
    """Say how soon a change was noticed, or how often one that was none."""
    if not change["change"]:
        return f"{count(change['false_alarms'], 'false alarm')} in {count(change['looks'], 'look')}"
    if change["reason"] is None:
        return f"no alarm in {count(change['looks'], 'look')}"
    return f"after {count(change['frames_until_alarm'], 'look')}: {change['reason']}"
