"""Strategies in figures: how the error falls, and where the time goes (fig. 6 and 7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.viewing.figures import share_of_steps, window_shares
from curiosight.viewing.paper import FAINT, HUES, label_ends, new_figure, save_figure, with_style

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_DASHES = ("-", (0, (5, 2)), (0, (1.5, 1.5)))
_WINDOW = 50


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
    bands: Mapping[str, BandOfErrors], offline_error: float, x_title: str, path: Path | str
) -> None:
    """Draw the overall error of strategies, mean ± standard deviation, and the off-line model's.

    path: ends in .png or .svg.
    """
    if not bands:
        raise ValueError("bands: expected at least one, got none")
    height = max(3.8, 0.34 * len(bands) + 0.8)
    figure = new_figure(7.6, height)
    axes = figure.add_subplot()
    ends = []
    for index, (name, band) in enumerate(bands.items()):
        hue, dash = HUES[index % len(HUES)], _DASHES[index // len(HUES) % len(_DASHES)]
        low, high = band.mean - band.deviation, band.mean + band.deviation
        axes.fill_between(band.x, low, high, color=hue, alpha=0.13, linewidth=0)
        axes.plot(band.x, band.mean, color=hue, linestyle=dash, linewidth=1.8)
        ends.append((float(band.x[-1]), float(band.mean[-1]), name, hue))
    axes.axhline(offline_error, color=FAINT, linewidth=1, linestyle=(0, (2, 3)))
    axes.text(
        0.01,
        offline_error,
        "off-line",
        color=FAINT,
        va="bottom",
        fontsize=8,
        transform=axes.get_yaxis_transform(),
    )
    axes.set_xlim(0, max(float(band.x[-1]) for band in bands.values()))
    axes.set_ylim(0, 1.02)
    axes.set_xlabel(x_title)
    axes.set_ylabel("overall error, 1 − F1")
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.6)
    axes.set_axisbelow(True)
    label_ends(axes, ends, gap=0.22 / height)
    save_figure(figure, path)


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
