"""curiosight compare: strategies against each other, on the same sources with the same seeds."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from curiosight.cli import options
from curiosight.cli.again import from_anywhere
from curiosight.cli.compare_report import CONFIG, write_reports
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count, need_figures
from curiosight.config import load_config
from curiosight.errors import DataError
from curiosight.experiments.comparing import split_names
from curiosight.experiments.contest.backends import Workers, make_workers
from curiosight.experiments.contest.contest import SETTINGS, Contest, check_settings
from curiosight.experiments.contest.settings import ContestSettings, absolute_regions
from curiosight.experiments.contest.table import make_table
from curiosight.experiments.contest.tasks import RunTask
from curiosight.experiments.contest.whole import PARTIAL
from curiosight.experiments.output import OutputFolder, write_json_file
from curiosight.experiments.sole_writer import LOCK
from curiosight.viewing.contest.tables import cost, ranked, reached

STRATEGIES = "random,sweep,iac,progress-rate"
N_SEEDS, N_STEPS = 10, 400
TABLE = "table.json"
CONTEST, WORKERS = "Contest", "Workers"


@reads_source
def compare(
    sources: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SOURCE...",
            help="Recordings' folders, room:SEED or home:SEED; none with --resume.",
            show_default=False,
        ),
    ] = None,
    strategies: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help="Whom to compare; NAME@REGIONS has regions of its own, such as iac@auto:4.",
            rich_help_panel=CONTEST,
            show_default=STRATEGIES,
        ),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="How many runs of each; run number k has the same chance for all strategies.",
            rich_help_panel=CONTEST,
            show_default=str(N_SEEDS),
        ),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Looks of a run.",
            rich_help_panel=CONTEST,
            show_default=str(N_STEPS),
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="Instead of --steps: how long the robot of a run looks around.",
            rich_help_panel=CONTEST,
        ),
    ] = None,
    regions: Annotated[
        str | None,
        typer.Option(
            help="Of all strategies that have none of their own; as of `explore`, and auto = "
            "rooms that are told apart by their ways, auto:4 = each by four headings.",
            rich_help_panel=CONTEST,
            show_default="auto where there are rooms, else pose, else time:5",
        ),
    ] = None,
    backend: Annotated[
        str,
        typer.Option(
            help="Where runs are made: processes of this machine, or ray, a cluster.",
            rich_help_panel=WORKERS,
        ),
    ] = "processes",
    address: Annotated[
        str | None,
        typer.Option(
            help="With --backend ray: of the cluster.",
            rich_help_panel=WORKERS,
            show_default="one of its own on this machine",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Runs at the same time; changes no result.",
            rich_help_panel=WORKERS,
            show_default="one a core",
        ),
    ] = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            metavar="",
            help="Go on with what is in --out: only the runs that are missing are made.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Compare strategies: which learns fastest, in looks, metres and seconds of the robot.

    Writes report.html to look at first, table.json, table.md, figures/, leaderboard.md of several
    sources, and runs/, a folder a run. Ctrl-C, or a kill, loses no run that is done: --resume
    makes the others, and the results are the same to the byte.
    """
    need_figures("compare")
    talk = Talk(quiet=quiet, as_json=json)
    given = _Given(
        sources=None if not sources else tuple(sources),
        strategies=None if strategies is None else tuple(split_names(strategies)),
        seeds=seeds,
        steps=steps,
        seconds=seconds,
        preset=preset,
        config=config,
        overrides={
            **reading,
            "explorer.regions": None if regions is None else absolute_regions(regions),
            "teacher.scene": scene,
            "teacher.up": up,
            "teacher.source": teacher,
        },
    )
    pool = make_workers(backend, n_workers=workers, address=address or "")
    contest = _open(given, out, is_resumed=resume)
    with closing(pool):
        if not contest.is_whole():
            pool.begin()
        with contest.begun():
            table = _make(talk, contest, pool)
    rows = {**_rows(table), "written to": contest.folder}
    talk.results("compare", rows, {**table, "out": str(contest.folder)})


def _make(talk: Talk, contest: Contest, pool: Workers) -> Mapping[str, Any]:
    """Have done what is missing, and write what was found; return the table."""
    with closing(pool), CtrlC() as ctrl_c:  # closed while nobody else may write
        _follow(talk, contest, pool, ctrl_c)
    n_missing = contest.n_missing()
    if n_missing:
        n_done = f"{contest.n_runs - n_missing} of {count(contest.n_runs, 'run')}"
        again = shlex.join(["curiosight", "compare", "--out", str(contest.folder), "--resume"])
        talk.note(f"stopped after {n_done}, which are kept; go on with {again}")
        raise typer.Exit(ctrl_c.status)
    table = make_table(contest)
    write_json_file(contest.folder / TABLE, table)
    write_reports(contest, table, _command_again(contest.settings))
    return table


@dataclass(frozen=True, slots=True)
class _Given:
    """What was said on the command line; None = not said."""

    sources: tuple[str, ...] | None
    strategies: tuple[str, ...] | None
    seeds: int | None
    steps: int | None
    seconds: float | None
    preset: str | None
    config: Path | None
    overrides: Mapping[str, Any]

    def settings(self) -> ContestSettings:
        """Return the settings of a new contest."""
        if self.sources is None:
            raise ValueError("SOURCE: expected at least one, got none")
        if self.steps is not None and self.seconds is not None:
            raise ValueError("steps: expected --steps or --seconds, got both")
        is_timed = self.seconds is not None
        return ContestSettings(
            self.sources,
            tuple(STRATEGIES.split(",")) if self.strategies is None else self.strategies,
            N_SEEDS if self.seeds is None else self.seeds,
            None if is_timed else N_STEPS if self.steps is None else self.steps,
            self.seconds,
            load_config(self.preset, self.config, self.overrides),
        )

    def check(self, kept: ContestSettings) -> None:
        """Raise ValueError where a contest that is gone on with has other settings."""
        for name in ("sources", "strategies", "seeds", "steps", "seconds"):
            self._check_one(name, getattr(self, name), getattr(kept, name))
        self._check_one("preset", self.preset, kept.config.preset)
        for key, value in self.overrides.items():
            section, _, name = key.partition(".")
            self._check_one(name, value, getattr(getattr(kept.config, section), name))
        if self.config is not None:
            named = load_config(self.preset, self.config, self.overrides)
            if named != kept.config:
                raise ValueError(f"resume: {self.config} has other settings than {SETTINGS}")

    @staticmethod
    def _check_one(name: str, given: Any, kept: Any) -> None:
        if given is not None and given != kept:
            raise ValueError(
                f"resume: expected {name.replace('_', '-')} as in {SETTINGS}, {_shown(kept)}; "
                f"got {_shown(given)}"
            )


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(value)
    return "none" if value in (None, "") else str(value)


def _open(given: _Given, out: Path | None, *, is_resumed: bool) -> Contest:
    """Return a new contest, or the one of a folder that holds one."""
    if is_resumed and out is None:
        raise ValueError("resume: expected --out DIR, too")
    if is_resumed and out is not None and (out / SETTINGS).exists():
        contest = Contest.resumed(out)
        given.check(contest.settings)
        return contest
    if is_resumed and given.sources is None:
        assert out is not None
        raise DataError(out, f"has no {SETTINGS} to go on with", "name the sources, too")
    settings = given.settings()
    is_begun = is_resumed and out is not None and _is_barely_begun(out)
    folders = [
        OutputFolder(out, "compare", Path(s), option="--resume", overwrite=is_begun, is_held=False)
        for s in settings.sources
    ]
    check_settings(settings)
    # A name of ours that another took in this second gets a number.
    return Contest(settings, folders[0].file(SETTINGS).parent if out is None else out)


def _is_barely_begun(out: Path) -> bool:
    """Tell whether a folder holds no more than a compare does that was killed at its start.

    Raises `DataError` where it holds anything else.
    """
    if not out.is_dir():
        return False
    foreign = [p for p in out.iterdir() if p.name != LOCK and not p.name.endswith(PARTIAL)]
    if foreign:
        found = f"has no {SETTINGS} to go on with, but other files"
        raise DataError(out, found, "choose another --out")
    return True


def _command_again(settings: ContestSettings) -> list[str]:
    """Return the words of a command that makes the same contest, in the folder of this one."""
    length = ("--steps", str(settings.steps))
    if settings.steps is None:
        length = ("--seconds", f"{settings.seconds:g}")
    words = ["curiosight", "compare", *(from_anywhere(Path(s)) for s in settings.sources)]
    words += ["--strategies", ",".join(settings.strategies), "--seeds", str(settings.seeds)]
    return [*words, *length, "--config", CONFIG]


def _rows(table: Mapping[str, Any]) -> dict[str, str]:
    """Return what a person wants to see: how soon each strategy is at 90 %, source by source."""
    rows = {}
    for source, of_source in table["sources"].items():
        for name in ranked(of_source):
            row = of_source["strategies"][name]
            took = f"{cost(row, 'seconds', 90)} s to 90 %, reached by {reached(row, 90)}"
            rows[f"{source} {name}"] = took
    return rows


def _follow(talk: Talk, contest: Contest, pool: Workers, ctrl_c: CtrlC) -> None:
    """Have done what is missing, to the end or to Ctrl-C."""
    with talk.following("compare", contest.n_missing(), "run") as shown:
        for task in contest.finished(pool, lambda: ctrl_c.is_pressed):
            if isinstance(task, RunTask):
                shown.advance(str(task))
            else:
                talk.note(f"{task.source} is described and labelled")
                shown.forget_pace()  # of runs
