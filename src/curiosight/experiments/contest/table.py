"""The figures of a contest, from its runs: `table.json`."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.evaluation.bootstrap import bootstrap_interval
from curiosight.experiments.contest.contest import Contest
from curiosight.experiments.contest.places import (
    Left,
    has_several_places,
    mean_in_order,
    places_left,
)
from curiosight.experiments.contest.prepared import Phase, Prepared
from curiosight.experiments.contest.runs import RunRecord

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Figure = dict[str, float | None]

# Shares of the off-line model's F1 that are waited for.
LEVELS = (90, 95)
UNITS = ("seconds", "frames", "metres")
# Looks over which the spread between seeds is averaged.
SPREAD_LOOKS = (20, 400)
# A room is learned again once its error is so near to what it was before it changed.
BACK_WITHIN = 0.05
# From this look on it is counted how often a strategy still looks where nothing can be learned.
UNLEARNABLE_AFTER = 100


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The overall error of a run, look by look; of a source that changes, from its change on.

    errors, seconds, metres: (n,) after each look, the time and the way since the first of them.
    """

    errors: Floats
    seconds: Floats
    metres: Floats

    @property
    def frames(self) -> Floats:
        """Return (n,) looks since the first, 1 after that one."""
        return np.arange(1.0, 1 + len(self.errors))

    def reached(self, error: float) -> int | None:
        """Return the index of the first look after which the error is no more than this."""
        found = np.flatnonzero(self.errors <= error)
        return int(found[0]) if len(found) else None

    def cost(self, unit: str, error: float) -> float:
        """Return what it cost to come down to an error; all of the run where it never did."""
        index = self.reached(error)
        costs: Floats = getattr(self, unit)
        return float(costs[-1 if index is None else index])

    def mean_over_seconds(self, total: float) -> float:
        """Return the mean error over the time: 1 until the first look is over, then as measured."""
        ends = np.minimum(np.concatenate([[0.0], self.seconds, [np.inf]]), total)
        errors = np.concatenate([[1.0], self.errors])
        return float((errors * np.diff(ends)).sum() / total)


def curve_of(run: RunRecord, first_look: int = 0) -> Curve:
    """Return the curve from a look on, straight between the looks that were measured.

    Raises ValueError for a run that ended before.
    """
    n_looks = len(run.seconds)
    if n_looks <= first_look:
        raise ValueError(f"run: expected more than {first_look} looks, got {n_looks}")
    is_after = run.measured > first_look
    means = np.nanmean(run.errors[is_after], axis=1)
    errors = np.interp(np.arange(first_look + 1, n_looks + 1), run.measured[is_after], means)
    before = first_look - 1
    seconds, metres = (
        values[first_look:] - (values[before] if first_look else 0.0)
        for values in (run.seconds, run.metres)
    )
    return Curve(errors, seconds, metres)


def make_table(contest: Contest) -> dict[str, Any]:
    """Return the figures of a contest that is whole.

    The same runs give the same table, whatever order they were made in.
    """
    return {"sources": {name: _source_table(contest, name) for name in contest.settings.sources}}


def curves_of(contest: Contest, source: str) -> dict[str, list[Curve]]:
    """Return the curves of each strategy on a source, one a seed."""
    first_look = contest.prepared(source).phases[-1].first_look
    curves = {}
    for strategy in contest.settings.strategies:
        try:
            runs = contest.records(source, strategy)
            curves[strategy] = [curve_of(run, first_look) for run in runs]
        except ValueError as error:
            found = f"{strategy} has no look after the change ({error})"
            raise DataError(source, found, "give it more --seconds, in another folder") from error
    return curves


def _source_table(contest: Contest, source: str) -> dict[str, Any]:
    prepared = contest.prepared(source)
    phase = prepared.phases[-1]
    curves = curves_of(contest, source)
    shortest = _Shortest(
        min(curve.seconds[-1] for each in curves.values() for curve in each),
        min(len(curve.errors) for each in curves.values() for curve in each),
    )
    table: dict[str, Any] = {"offline": phase.offline}
    if phase.first_look:
        table["from_look"] = phase.first_look
    table["strategies"] = {
        name: _strategy_table(prepared, contest.records(source, name), each, shortest)
        for name, each in curves.items()
    }
    table["pairs"] = {
        f"{a}/{b}": _pair(curves[a], curves[b], phase.offline["f1"])
        for a, b in itertools.permutations(curves, 2)
    }
    return table


@dataclass(frozen=True, slots=True)
class _Shortest:
    """Of all runs on a source, so that areas are over the same time and looks."""

    seconds: float
    n_looks: int


def _strategy_table(
    prepared: Prepared, runs: Sequence[RunRecord], curves: Sequence[Curve], shortest: _Shortest
) -> dict[str, Any]:
    figures = {
        **_figures(curves, prepared.phases[-1].offline["f1"], shortest),
        **_figures_of_rooms(prepared, runs),
    }
    if has_several_places(prepared):
        figures["places_left"] = _figures_of_places([places_left(prepared, run) for run in runs])
    return figures


def _figures_of_places(left: Sequence[Left | None]) -> dict[str, Any] | None:
    """Return what is left of places: means over the seeds that left any; None where none did."""
    known = [one for one in left if one is not None]
    if not known:
        return None
    figures: dict[str, Any] = {"n": len(known)}
    for name in ("average_quality", "backward_transfer", "forgetting"):
        values = [getattr(one, name) for one in known]
        deviation = float(np.std(values, ddof=1)) if len(values) > 1 else None
        figures[name] = {**_mean(values), "deviation": deviation}
    return figures | {"qualities": mean_in_order(known).tolist()}


def _figures(curves: Sequence[Curve], f1: float, shortest: _Shortest) -> dict[str, Any]:
    figures: dict[str, Any] = {"n": len(curves)}
    for level in LEVELS:
        error = error_at(level, f1)
        figures[f"reached_{level}"] = sum(curve.reached(error) is not None for curve in curves)
    for level, unit in itertools.product(LEVELS, UNITS):
        costs = [curve.cost(unit, error_at(level, f1)) for curve in curves]
        figures[f"{unit}_to_{level}"] = _mean(costs)
    over_time = [curve.mean_over_seconds(shortest.seconds) for curve in curves]
    figures["area_seconds"] = _mean(over_time)
    n_looks = shortest.n_looks
    figures["area_frames"] = _mean([float(curve.errors[:n_looks].mean()) for curve in curves])
    figures["final_error"] = _mean([float(curve.errors[-1]) for curve in curves])
    figures["spread"] = spread(curves)
    return figures


def error_at(level: int, f1: float) -> float:
    """Return the error at so many per cent of an F1."""
    return 1 - level / 100 * f1


def spread(curves: Sequence[Curve]) -> float | None:
    """Return how much seeds differ: the standard deviation, averaged over looks 20 to 400.

    Of shorter runs up to the shortest's end, and of those below 20 looks over all; None of one.
    """
    if len(curves) < 2:
        return None
    n_looks = min(len(curve.errors) for curve in curves)
    first = SPREAD_LOOKS[0] if n_looks >= SPREAD_LOOKS[0] else 1
    errors = np.array([curve.errors[first - 1 : min(n_looks, SPREAD_LOOKS[1])] for curve in curves])
    return float(errors.std(axis=0, ddof=1).mean())


def _pair(a: Sequence[Curve], b: Sequence[Curve], f1: float) -> dict[str, Any]:
    """Return how many times as much one strategy takes as another, seeds drawn in pairs."""
    pair = {}
    for level, unit in itertools.product(LEVELS, UNITS):
        error = error_at(level, f1)
        costs = np.array(
            [[x.cost(unit, error), y.cost(unit, error)] for x, y in zip(a, b, strict=True)]
        )
        interval = bootstrap_interval(costs, _ratio, np.random.default_rng(0))
        low, high = (None, None) if interval is None else interval
        pair[f"{unit}_to_{level}"] = {"ratio": _ratio(costs.mean(axis=0)), "low": low, "high": high}
    return pair


def _ratio(means: Floats) -> float | None:
    return float(means[0] / means[1]) if means[1] > 0 else None


def _mean(figures: Sequence[float]) -> Figure:
    """Return the mean over the seeds and its interval, None where one seed has no interval."""
    interval = bootstrap_interval(np.array(figures), float, np.random.default_rng(0))
    low, high = (None, None) if interval is None else interval
    return {"mean": float(np.mean(figures)), "low": low, "high": high}


def _figures_of_rooms(prepared: Prepared, runs: Sequence[RunRecord]) -> Mapping[str, Any]:
    """Return how soon a changed room is learned again, and how long nothing is looked for."""
    figures: dict[str, Any] = {}
    if len(prepared.phases) > 1 and prepared.phases[-1].first_look:
        looks = [looks_until_back(prepared, run) for run in runs]
        totals = [len(run.seconds) - prepared.phases[-1].first_look for run in runs]
        figures["back"] = sum(look is not None for look in looks)
        counted = [
            total if look is None else look for look, total in zip(looks, totals, strict=True)
        ]
        figures["looks_until_back"] = _mean([float(look) for look in counted])
    room = prepared.meta.get("unlearnable")
    if room is not None:
        number = dict(zip(prepared.ids, prepared.places, strict=True))
        shares = [
            float(np.mean([number[id] == room for id in run.ids[UNLEARNABLE_AFTER:]]))
            for run in runs
            if len(run.ids) > UNLEARNABLE_AFTER
        ]
        figures["share_of_unlearnable_after_100"] = _mean(shares) if shares else None
    return figures


def looks_until_back(prepared: Prepared, run: RunRecord) -> int | None:
    """Return how many looks after the change its rooms are as well known as before; None = never.

    Straight between the looks that were measured, as all errors.
    """
    before, after = prepared.phases[-2:]
    changed = prepared.meta.get("changed")
    known = run.errors[run.measured <= after.first_look][-1]
    least = float(known[_is_in(before, changed)].mean())
    is_after = run.measured > after.first_look
    errors = run.errors[is_after][:, _is_in(after, changed)].mean(axis=1)
    looks = np.arange(after.first_look + 1, len(run.seconds) + 1)
    found = np.flatnonzero(np.interp(looks, run.measured[is_after], errors) <= least + BACK_WITHIN)
    return int(found[0]) + 1 if len(found) else None


def _is_in(phase: Phase, rooms: Sequence[int] | None) -> Ints:
    """Return which of the test frames that have an error are in some rooms; None = in any."""
    scored = phase.scored_places()
    return np.flatnonzero(np.ones(len(scored)) if rooms is None else np.isin(scored, rooms))
