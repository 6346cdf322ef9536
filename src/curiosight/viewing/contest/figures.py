"""Strategies in figures: how the error falls, and where the time goes (fig. 6 and 7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from curiosight.viewing.figures import share_of_steps, window_shares
from curiosight.viewing.paper import (
    FAINT,
    HUES,
    INK,
    label_shares,
    new_figure,
    region_colours,
    save_figure,
    with_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_DASHES = ("-", (0, (5, 2)), (0, (1.5, 1.5)))
_WINDOW = 50
# Where one takes so many times as long as another, the axis is logarithmic: the quick ones would
# share its left edge. It begins at this part of the shortest.
_UNLIKE, _BEGIN = 4.0, 0.05


class BandOfErrors(Protocol):
    """Mean and standard deviation of an error, (n,) each, over x."""

    @property
    def x(self) -> Floats: ...
    @property
    def mean(self) -> Floats: ...
    @property
    def deviation(self) -> Floats: ...


@with_style
def draw_errors(
    bands: Mapping[str, BandOfErrors],
    offline_error: float,
    x_title: str,
    path: Path | str,
    *,
    others: Mapping[str, float] | None = None,
) -> None:
    """Draw the overall error of strategies, mean ± standard deviation, and the off-line model's.

    others: errors by name of what does not learn. path: ends in .png, .svg or .pdf.
    """
    if not bands:
        raise ValueError("bands: expected at least one, got none")
    figure = new_figure(8.4, max(4.0, 0.22 * len(bands) + 0.8))
    axes = figure.add_subplot()
    for index, (name, band) in enumerate(bands.items()):
        hue, dash = HUES[index % len(HUES)], _DASHES[index // len(HUES) % len(_DASHES)]
        low, high = band.mean - band.deviation, band.mean + band.deviation
        axes.fill_between(band.x, low, high, color=hue, alpha=0.13, linewidth=0)
        axes.plot(band.x, band.mean, color=hue, linestyle=dash, linewidth=1.8, label=name)
        axes.plot(band.x[-1], band.mean[-1], "o", color=hue, markersize=3.5)
    dots = (0, (2, 3))
    axes.axhline(offline_error, color=FAINT, linewidth=1, linestyle=dots, label="off-line")
    for name, error in (others or {}).items():
        axes.axhline(error, color=INK, linewidth=1, linestyle=dots, label=name)
    constants = [offline_error, *(others or {}).values()]
    lowest = min(*constants, *(float(band.mean.min()) for band in bands.values()))
    highest = max(*constants, *(float((b.mean + b.deviation).max()) for b in bands.values()))
    _scale_x(axes, [float(band.x[-1]) for band in bands.values()])
    axes.set_ylim(max(0.0, lowest - 0.08), min(1.0, highest + 0.06) + 0.02)
    axes.set_xlabel(x_title)
    axes.set_ylabel("overall error, 1 − F1")
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), fontsize=9)
    save_figure(figure, path)


def _scale_x(axes: Axes, ends: Sequence[float]) -> None:
    """Let an axis go up to the last of the ends, so that all curves can be told apart."""
    if min(ends) <= 0 or max(ends) < _UNLIKE * min(ends):
        axes.set_xlim(0, max(ends))
        return
    from matplotlib.ticker import FuncFormatter

    axes.set_xscale("log")
    axes.set_xlim(_BEGIN * min(ends), max(ends))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))


def draw_time_per_region(
    regions: Sequence[Ints], region_names: Sequence[str], path: Path | str
) -> None:
    """Draw which share of the looks went to each region, the mean over seeds (fig. 7).

    regions: (n_looks,) of each seed.
    """
    n_looks = min(map(len, regions))
    n_window = min(_WINDOW, n_looks)
    shares = [window_shares(seed[:n_looks], len(region_names), n_window) for seed in regions]
    steps = np.arange(1, 1 + n_looks)
    share_of_steps(steps, np.mean(shares, axis=0), region_names, path, n_window=n_window)


@with_style
def draw_times(
    steps: Ints,
    shares: Mapping[str, Floats],
    region_names: Sequence[str],
    path: Path | str,
    *,
    n_window: int,
) -> None:
    """Draw shares (n_regions, n_steps) of windows of so many looks, a panel a strategy (fig. 7).

    path: ends in .png, .svg or .pdf.
    """
    if not shares:
        raise ValueError("shares: expected at least one, got none")
    height = max(3.8, 0.26 * len(region_names))
    figure = new_figure(3.8 * len(shares) + 0.6, height)
    panels = figure.subplots(1, len(shares), squeeze=False, sharey=True)[0]
    colours = region_colours(region_names)
    for panel, (name, share) in zip(panels, shares.items(), strict=True):
        panel.stackplot(steps, share, colors=colours, edgecolor="white", linewidth=0.4)
        panel.set_xlim(steps[0], max(steps[-1], steps[0] + 1))
        panel.set_ylim(0, 1)
        panel.set_title(name, fontsize=10)
        panel.set_xlabel("look")
    panels[0].set_ylabel(f"share of {n_window} looks")
    label_shares(panels[-1], float(steps[-1]), share[:, -1], region_names, colours)
    save_figure(figure, path)
