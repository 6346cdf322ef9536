"""Show what a contest of strategies found: tables, figures, and a page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from curiosight.cli.talk import count
from curiosight.config import to_toml
from curiosight.errors.files import replace_file, writing
from curiosight.experiments.contest.contest import SETTINGS, Contest
from curiosight.experiments.contest.series import band_of
from curiosight.experiments.contest.settings import folder_name
from curiosight.experiments.contest.table import UNITS, curves_of
from curiosight.viewing.contest import (
    ContestReport,
    SourceReport,
    draw_errors,
    draw_time_per_region,
    leaderboard,
    markdown_tables,
    write_contest,
)

CONFIG = "config.toml"
X_TITLES = {"frames": "looks", "metres": "metres", "seconds": "seconds of the robot"}


def write_reports(contest: Contest, table: Mapping[str, Any], command: Sequence[str]) -> None:
    """Write config.toml, table.md, figures/, report.html and, of several sources, leaderboard.md.

    table: of table.json. The same runs give the same bytes.
    """
    folder = contest.folder
    replace_file(folder / CONFIG, to_toml(contest.settings.config).encode())
    replace_file(folder / "table.md", markdown_tables(table).encode("utf-8", "replace"))
    if len(contest.settings.sources) > 1:
        replace_file(folder / "leaderboard.md", leaderboard(table).encode("utf-8", "replace"))
    sources = [
        SourceReport(
            source,
            table["sources"][source],
            _draw_errors(contest, source, table["sources"][source]["offline"]["error"]),
            _draw_regions(contest, source),
        )
        for source in contest.settings.sources
    ]
    settings = (folder / SETTINGS).read_text(encoding="utf-8")
    report = ContestReport(_sentence(contest), sources, shlex.join(command), settings)
    write_contest(report, folder / "report.html")


def _sentence(contest: Contest) -> str:
    settings = contest.settings
    long = f"{settings.steps} looks" if settings.seconds is None else f"{settings.seconds:g} s"
    n_strategies = len(settings.strategies)
    return (
        f"{n_strategies} {'strategy' if n_strategies == 1 else 'strategies'} on "
        f"{count(len(settings.sources), 'source')}, {count(settings.seeds, 'seed')} each, {long} "
        "a run: the same views, the same visits and the same tests for all."
    )


def _draw_errors(contest: Contest, source: str, offline_error: float) -> dict[str, Path]:
    """Draw the errors over each unit; return the SVG files by title."""
    curves = curves_of(contest, source)
    drawn = {}
    for unit in UNITS:
        bands = {name: band_of(each, unit) for name, each in curves.items()}
        for ending in ("png", "svg"):
            path = _figure(contest, source, f"error-{unit}.{ending}")
            draw_errors(bands, offline_error, X_TITLES[unit], path)
        drawn[f"Error over {X_TITLES[unit]}, mean ± standard deviation over seeds"] = path
    return drawn


def _draw_regions(contest: Contest, source: str) -> dict[str, Path]:
    """Draw where each strategy looked; return the SVG files by strategy."""
    drawn = {}
    for strategy in contest.settings.strategies:
        runs = contest.records(source, strategy)
        for ending in ("png", "svg"):
            path = _figure(contest, source, f"regions-{folder_name(strategy)}.{ending}")
            draw_time_per_region([run.regions for run in runs], runs[0].region_names, path)
        drawn[strategy] = path
    return drawn


def _figure(contest: Contest, source: str, name: str) -> Path:
    path = contest.folder / "figures" / folder_name(source) / name
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    return path
