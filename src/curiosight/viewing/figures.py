"""The figures of a run: how the error fell, where time went, how well it ranks (sec. III)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from curiosight.explorer.progress import moving_mean
from curiosight.metrics import Ranking
from curiosight.viewing.paper import (
    FAINT,
    HUES,
    label_ends,
    label_shares,
    new_figure,
    region_colours,
    save_figure,
    with_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]


class StepRecord(Protocol):
    """A step as the figures need it; a line of steps.csv, for instance."""

    @property
    def step(self) -> int: ...
    @property
    def region(self) -> int: ...
    @property
    def error(self) -> float | None: ...
    @property
    def overall_error(self) -> float | None: ...


@with_style
def learning_curve(rows: Sequence[StepRecord], path: Path | str, *, n_mean: int = 10) -> None:
    """Draw the overall error and the error of each step (eq. 1) over the steps.

    n_mean: steps whose error is defined that the moving mean takes, its own the last.
    """
    _check_any("rows", rows)
    steps = np.array([row.step for row in rows])
    errors, overall = _numbers([r.error for r in rows]), _numbers([r.overall_error for r in rows])
    figure = new_figure(7.2, 3.4)
    axes = figure.add_subplot()
    axes.plot(steps, errors, ".", color=FAINT, markersize=3.5, alpha=0.6)
    is_defined = np.isfinite(errors)
    mean = moving_mean(errors[is_defined], n_mean)
    ends = []
    for x, values, name, colour, width in (
        (steps[is_defined], mean, f"each step\n(mean of {n_mean})", FAINT, 1.2),
        (steps, overall, "overall", HUES[0], 2.4),
    ):
        axes.plot(x, values, color=colour, linewidth=width)
        if np.isfinite(values).any():
            last = np.flatnonzero(np.isfinite(values))[-1]
            ends.append((x[last], values[last], f"{name} {values[last]:.2f}", colour))
    _frame_errors(axes, steps)
    label_ends(axes, ends, gap=0.16)
    save_figure(figure, path)


def time_per_region(
    rows: Sequence[StepRecord],
    region_names: Sequence[str],
    path: Path | str,
    *,
    n_window: int = 50,
) -> None:
    """Draw which share of the steps went to each region, over the steps (sec. III-B).

    n_window: steps of the window, centred on its step, over which shares are counted.
    """
    _check_any("rows", rows)
    regions = np.array([row.region for row in rows])
    shares = window_shares(regions, len(region_names), n_window)
    steps = np.array([row.step for row in rows])
    share_of_steps(steps, shares, region_names, path, n_window=min(n_window, len(rows)))


@with_style
def share_of_steps(
    steps: npt.NDArray[np.int64],
    shares: Floats,
    region_names: Sequence[str],
    path: Path | str,
    *,
    n_window: int,
) -> None:
    """Draw shares (n_regions, n_steps) of windows of so many steps, one above the other."""
    height = max(4.2, 0.26 * len(region_names))
    figure = new_figure(7.2, height)
    axes = figure.add_subplot()
    colours = region_colours(region_names)
    axes.stackplot(steps, shares, colors=colours, edgecolor="white", linewidth=0.4)
    axes.set_xlim(steps[0], max(steps[-1], steps[0] + 1))
    axes.set_ylim(0, 1)
    axes.set_xlabel("step")
    axes.set_ylabel(f"share of {n_window} steps")
    label_shares(axes, float(steps[-1]), shares[:, -1], region_names, colours)
    save_figure(figure, path)


@with_style
def roc(rankings: Mapping[str, Ranking], path: Path | str) -> None:
    """Draw the ROC curve of each ranking, the area below it in the legend."""
    _check_any("rankings", rankings)
    figure, axes = _square_of_shares("false positive rate", "true positive rate")
    styles = ("-", (0, (6, 2)), (0, (2, 1.5)), "-.")
    for index, (name, ranking) in enumerate(rankings.items()):
        auc = "no AUC" if ranking.roc_auc is None else f"AUC {ranking.roc_auc:.3f}"
        colour, style = HUES[index % len(HUES)], styles[index % len(styles)]
        axes.plot(
            *ranking.roc.T, color=colour, linestyle=style, linewidth=2, label=f"{name}: {auc}"
        )
    axes.legend(loc="lower right", fontsize=9)
    save_figure(figure, path)


@with_style
def reliability(curves: Mapping[str, Floats], path: Path | str) -> None:
    """Draw the share of salient pixels over the probability that they were told.

    curves: (n, 2) by name: the mean probability of each bin, and the share there. On the
        diagonal probabilities are right.
    """
    _check_any("curves", curves)
    figure, axes = _square_of_shares("probability told", "share that is salient")
    for index, (name, curve) in enumerate(curves.items()):
        colour = HUES[index % len(HUES)]
        axes.plot(*curve.T, "o-", color=colour, linewidth=2, markersize=4, label=name)
    axes.legend(loc="upper left", fontsize=9)
    save_figure(figure, path)


def window_shares(regions: npt.NDArray[np.int64], n_regions: int, n_window: int) -> Floats:
    """Return the share of each region in a window around each step, (n_regions, n_steps).

    At the ends the window stays whole, no longer centred. Steps in no region (-1) count
    for none.
    """
    is_there = regions[None, :] == np.arange(n_regions)[:, None]
    counted = np.pad(np.cumsum(is_there, axis=1), ((0, 0), (1, 0)))
    n_window = min(n_window, len(regions))
    first = np.clip(np.arange(len(regions)) - n_window // 2, 0, len(regions) - n_window)
    shares: Floats = (counted[:, first + n_window] - counted[:, first]) / n_window
    return shares


def _square_of_shares(x: str, y: str) -> tuple[Figure, Axes]:
    """Return a figure of one share over another, with its diagonal."""
    figure = new_figure(4.6, 4.6)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color=FAINT, linewidth=0.8, linestyle=(0, (2, 3)))
    axes.set_xlim(-0.01, 1.01)
    axes.set_ylim(-0.01, 1.01)
    axes.set_aspect("equal")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color="#e6e6e6", linewidth=0.6)
    return figure, axes


def _check_any(name: str, values: Sequence[object] | Mapping[str, object]) -> None:
    if not values:
        raise ValueError(f"{name}: expected at least one, got none")


def _numbers(values: Sequence[float | None]) -> Floats:
    return np.array([np.nan if value is None else value for value in values], np.float64)


def _frame_errors(axes: Axes, steps: npt.NDArray[np.int64]) -> None:
    axes.set_xlim(steps[0], max(steps[-1], steps[0] + 1))
    axes.set_ylim(0, 1.02)
    axes.set_xlabel("step")
    axes.set_ylabel("error, 1 − F1")
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.6)
    axes.set_axisbelow(True)
