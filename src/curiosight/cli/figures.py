"""curiosight figures: the figures of the paper, of any source."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer

from curiosight.cli import options
from curiosight.cli.figures_drawing import Drawing
from curiosight.cli.figures_files import CannotDrawError
from curiosight.cli.interrupt import CtrlC
from curiosight.cli.reading import ReadingOverrides, reads_source
from curiosight.cli.talk import Talk, count, need_figures
from curiosight.config import Config, load_config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.comparing import choose_methods
from curiosight.experiments.contest.backends import Workers, make_workers
from curiosight.experiments.contest.contest import Contest, check_settings, place_of
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.settings import ContestSettings, absolute_regions
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.paper_figures.subject import Subject, with_tests_apart
from curiosight.viewing.live import announce_compilation
from curiosight.worlds.sources import open_source

FIGURES = tuple(range(2, 9))
OF_STRATEGIES = {6, 7}
STRATEGIES = ("chronological", "random", "iac")
N_SEEDS, N_STEPS = 10, 200
BASELINES = "bms,gbvs,vocus2,depth"


@reads_source
def figures(
    source: options.Source,
    figure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="N",
            help="2 = examples, 3 = ROC, 4 = maps of all methods, 5 = one view's map look by look, "
            "6 = error of the strategies, 7 = time in regions, 8 = regions from above; also 2-4 or "
            "2,6, and more than once.",
            show_default=False,
        ),
    ] = None,
    all_figures: Annotated[bool, typer.Option("--all", metavar="", help="All of them.")] = False,
    seeds: Annotated[
        int, typer.Option(metavar="N", help="Of figures 6 and 7: runs of each strategy.")
    ] = N_SEEDS,
    steps: Annotated[
        int, typer.Option(metavar="N", help="Of figures 6 and 7: looks of a run.")
    ] = N_STEPS,
    regions: Annotated[
        str | None,
        typer.Option(
            help="Of figures 6 to 8, as of `compare`; time:5 = the paper's slices of a path.",
            show_default="auto where there are rooms, else pose, else time:5",
        ),
    ] = None,
    baselines: Annotated[
        str, typer.Option(metavar="NAMES", help="Of figures 3 and 4, as of `evaluate`.")
    ] = BASELINES,
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Runs at the same time; changes no result.",
            show_default="one a core",
        ),
    ] = None,
    seed: options.Seed = None,
    scene: options.Scene = None,
    up: options.Up = None,
    teacher: options.Teacher = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
    *,
    reading: ReadingOverrides,
) -> None:
    """Draw the paper's figures of a source: SVG, PDF and the numbers as CSV.

    Writes figure-N.svg, .pdf and .csv, claims.csv (what the paper says of its figures, and
    whether it holds here) and config.toml. A figure that the source cannot give is told in a
    line; exit status 2 where that is so of all.
    """
    need_figures("figures")
    talk = Talk(quiet=quiet, as_json=json)
    wanted = _wanted(figure, all_figures)
    overrides = {
        **reading,
        "run.seed": seed,
        "explorer.regions": None if regions is None else absolute_regions(regions),
        "teacher.scene": scene,
        "teacher.up": up,
        "teacher.source": teacher,
    }
    given = load_config(preset, config, overrides)
    methods = choose_methods(baselines)
    folder = OutputFolder(out, "figures", source, overwrite=overwrite)
    dataset = open_source(source, reading=given.reading)
    settings = _settings(source, with_tests_apart(given, dataset), seeds, steps)
    check_settings(settings)
    one_run = settings.config_of(STRATEGIES[0])
    drawing = Drawing(talk, folder, one_run, dataset, methods)
    talk.introduce(source, dataset)
    pool = make_workers("processes", n_workers=workers)
    with tempfile.TemporaryDirectory(prefix="curiosight-") as scratch, closing(pool):
        contest = Contest(settings, Path(scratch))
        with announce_compilation(talk.console):
            _prepare(talk, drawing, contest, str(source))
            with CtrlC() as ctrl_c:
                drawing.is_stopped = lambda: ctrl_c.is_pressed
                if drawing.subject is not None and OF_STRATEGIES & wanted:
                    _run_all(talk, contest, pool, drawing.is_stopped)
                    drawing.add_runs(contest, str(source))
                made = _draw(talk, drawing, wanted)
    if ctrl_c.is_pressed:
        talk.note(f"stopped after {count(len(made), 'figure')}; these are kept")
        raise typer.Exit(ctrl_c.status)
    if not made:
        raise typer.Exit(2)
    folder.write_text("config.toml", to_toml(given))
    drawing.write_claims()
    rows = {**drawing.told(), "written to": folder.path}
    content = {"figures": sorted(made), "claims": drawing.claims_table(), "out": str(folder.path)}
    talk.results("figures", rows, content)


def _wanted(figure: list[str] | None, all_figures: bool) -> set[int]:
    """Return the numbers of figures that are asked for."""
    form = f"{FIGURES[0]} to {FIGURES[-1]}"
    if all_figures:
        return set(FIGURES)
    wanted: set[int] = set()
    for part in ",".join(figure or []).split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:[-…–]\s*(\d+)\s*)?", part)
        if match is None:
            if not figure:
                raise ValueError(f"figure: expected {form}, or --all")
            raise ValueError(f"figure: expected {form}, such as 2-4 or 2,6, got {part!r}")
        first, last = int(match[1]), int(match[2] or match[1])
        if not FIGURES[0] <= first <= last <= FIGURES[-1]:
            raise ValueError(f"figure: expected {form}, got {part!r}")
        wanted |= set(range(first, last + 1))
    return wanted


def _settings(source: Path, config: Config, seeds: int, steps: int) -> ContestSettings:
    return ContestSettings((str(source),), STRATEGIES, seeds, steps, None, config)


def _prepare(talk: Talk, drawing: Drawing, contest: Contest, source: str) -> None:
    """Describe and label the source; what cannot be is not known to `drawing` then."""
    talk.note(f"{source} is described and labelled …")
    folder = contest.prepared_folder(source)
    try:
        prepared = prepare(place_of(source), drawing.config, folder)
    except DataError as error:
        drawing.problem = str(error)
        return
    drawing.subject = Subject(drawing.config, drawing.dataset, prepared)


def _run_all(talk: Talk, contest: Contest, pool: Workers, is_stopped: Callable[[], bool]) -> None:
    n_missing = contest.n_missing()
    with contest.begun(), talk.following("strategies", n_missing, "run") as shown:
        for task in contest.finished(pool, is_stopped):
            shown.advance(str(task))


def _draw(talk: Talk, drawing: Drawing, wanted: set[int]) -> list[int]:
    """Draw figure by figure; say which cannot be."""
    made = []
    for number in sorted(wanted):
        if drawing.is_stopped():
            break
        try:
            drawing.draw(number)
            made.append(number)
        except CannotDrawError as reason:
            if not drawing.is_stopped():
                talk.warn(f"figure {number}: {reason}")
    return made
