"""Figures 6 to 8: how strategies learn, where they spend their time, and where that is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from curiosight.cli.figures_files import CannotDrawError, FigureFiles, Row
from curiosight.evaluation.baselines import METHODS
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.contest.series import band_of
from curiosight.experiments.contest.table import Curve
from curiosight.experiments.paper_figures.claims import Claim, claims_of_errors, claims_of_time
from curiosight.experiments.paper_figures.from_above import ViewsFromAbove
from curiosight.experiments.paper_figures.subject import Subject, least_error
from curiosight.viewing.contest import draw_errors, draw_times
from curiosight.viewing.figures import window_shares
from curiosight.viewing.region_map import regions_from_above

BASELINE = "bms"
# Looks over which time in regions is counted: at most, at least, and as a part of a run.
MOST_LOOKS, LEAST_LOOKS, PART = 50, 5, 5


def draw_strategies(
    subject: Subject, curves: Mapping[str, Sequence[Curve]], files: FigureFiles
) -> list[Claim]:
    """Draw figure 6: the errors of strategies, BMS and the off-line model; return its claims."""
    bands = {name: band_of(each, "frames") for name, each in curves.items()}
    offline = subject.prepared.phases[-1].offline["error"]
    least = least_error(subject, METHODS, BASELINE)
    others = {} if least is None else {f"BMS, cut where it is best, at {least[1]:.2f}": least[0]}
    constants = {"off-line": offline} | ({} if least is None else {"bms": least[0]})

    def rows() -> Iterator[Row]:
        for name, band in bands.items():
            for x, mean, deviation in zip(band.x, band.mean, band.deviation, strict=True):
                yield _error_row(name, int(x), float(mean), float(deviation))
        for name, error in constants.items():
            yield _error_row(name, None, error, None)

    files.save(6, lambda path: draw_errors(bands, offline, "looks", path, others=others), rows())
    baseline = None if least is None else least[0]
    return claims_of_errors(curves, offline, baseline, subject.config.run.seed)


def draw_time_in_regions(
    runs: Mapping[str, Sequence[RunRecord]], seed: int, files: FigureFiles
) -> list[Claim]:
    """Draw figure 7: which share of the looks regions get; return its claims."""
    names = next(iter(runs.values()))[0].region_names
    shortest = min(len(run.regions) for each in runs.values() for run in each)
    n_window = min(shortest, MOST_LOOKS, max(LEAST_LOOKS, shortest // PART))
    shares = {
        strategy: [window_shares(run.regions, len(names), n_window) for run in each]
        for strategy, each in runs.items()
    }
    n_looks = min(one.shape[1] for each in shares.values() for one in each)
    looks = np.arange(1, 1 + n_looks)
    first = {f"{name}, first of {len(each)} seeds": each[0] for name, each in shares.items()}
    rows = (
        {"strategy": name, "seed": number, "look": int(look), "region": region, "share": share}
        for name, each in shares.items()
        for number, one in enumerate(each)
        for look, column in zip(looks, one.T, strict=True)
        for region, share in zip(names, column.tolist(), strict=True)
    )
    files.save(7, lambda path: draw_times(looks, first, names, path, n_window=n_window), rows)
    return claims_of_time(shares, seed)


def draw_regions(views: ViewsFromAbove, files: FigureFiles) -> None:
    """Draw figure 8: the views and their regions from above."""
    if not views.has_poses:
        raise CannotDrawError("there are no poses to be seen from above")

    def draw(path: Path) -> None:
        regions_from_above(
            views.poses,
            views.regions,
            range(len(views.poses)),
            path,
            up=views.up,
            counted="views",
            is_way=views.is_way,
            outlines=views.outlines,
        )

    files.save(8, draw, views.rows())


def _error_row(name: str, look: int | None, mean: float, deviation: float | None) -> Row:
    return {"strategy": name, "look": look, "error": mean, "standard_deviation": deviation}
