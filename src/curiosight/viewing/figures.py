"""The figures of a run: how the error fell, where time went, what was learned (sec. III)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch

from curiosight.frame import Label, Rgb
from curiosight.metrics import Ranking
from curiosight.segmentation import Segmentation
from curiosight.viewing.overlays import (
    LABEL_COLOURS,
    LABEL_NAMES,
    OUTLINE_COLOUR,
    overlay_labels,
)
from curiosight.viewing.paper import (
    FAINT,
    HUES,
    INK,
    label_ends,
    new_figure,
    region_colours,
    save_figure,
    with_style,
)

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


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """A frame to show: its colour image, what the teacher said of it, what was predicted.

    saliency: (h, w) in [0, 1], of the image's shape or of the shrunken image's.
    """

    caption: str
    rgb: Rgb
    segmentation: Segmentation
    saliency: npt.NDArray[np.floating]


@with_style
def learning_curve(rows: Sequence[StepRecord], path: Path | str, *, n_mean: int = 10) -> None:
    """Draw the overall error and the error of each step (eq. 1) over the steps.

    n_mean: steps of the moving mean, which ends at its step and leaves undefined errors out.
    """
    _check_any("rows", rows)
    steps = np.array([row.step for row in rows])
    errors, overall = _numbers([r.error for r in rows]), _numbers([r.overall_error for r in rows])
    figure = new_figure(7.2, 3.4)
    axes = figure.add_subplot()
    axes.plot(steps, errors, ".", color=FAINT, markersize=3.5, alpha=0.6)
    ends = []
    for values, name, colour, width in (
        (moving_mean(errors, n_mean), f"each step\n(mean of {n_mean})", FAINT, 1.2),
        (overall, "overall", HUES[0], 2.4),
    ):
        axes.plot(steps, values, color=colour, linewidth=width, solid_joinstyle="round")
        if (defined := np.flatnonzero(np.isfinite(values))).size:
            last = defined[-1]
            text = f"{name} {values[last]:.2f}" if values is overall else name
            ends.append((steps[last], values[last], text, INK if values is not overall else colour))
    _frame_errors(axes, steps)
    label_ends(axes, ends, gap=0.16)
    save_figure(figure, path)


@with_style
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
    figure = new_figure(7.2, 4.2)
    axes = figure.add_subplot()
    colours = region_colours(region_names)
    axes.stackplot(steps, shares, colors=colours, edgecolor="white", linewidth=0.4)
    axes.set_xlim(steps[0], max(steps[-1], steps[0] + 1))
    axes.set_ylim(0, 1)
    axes.set_xlabel("step")
    axes.set_ylabel(f"share of {min(n_window, len(rows))} steps")
    tops = np.cumsum(shares[:, -1])
    middles = tops - shares[:, -1] / 2
    label_ends(
        axes,
        [
            (steps[-1], middle, name, INK if share else FAINT)
            for middle, name, share in zip(middles, region_names, shares[:, -1], strict=True)
        ],
        gap=0.062,
    )
    save_figure(figure, path)


@with_style
def examples(shown: Sequence[Example], path: Path | str) -> None:
    """Draw a row for each example: colour, the teacher's labels, the saliency."""
    _check_any("shown", shown)
    height, width = shown[0].rgb.shape[:2]
    figure = new_figure(7.2, len(shown) * 2.32 * height / width + 0.75)
    grid = figure.subplots(len(shown), 3, squeeze=False)
    for panels, example in zip(grid, shown, strict=True):
        panels[0].imshow(example.rgb)
        panels[1].imshow(overlay_labels(example.rgb, example.segmentation))
        panels[2].imshow(example.saliency, cmap="inferno", vmin=0, vmax=1)
        panels[0].set_ylabel(example.caption, fontsize=8)
        for panel in panels:
            panel.set_xticks([])
            panel.set_yticks([])
            panel.spines[:].set_visible(False)
    titles = ("colour", "what depth says", "saliency from colour")
    for panel, title in zip(grid[0], titles, strict=True):
        panel.set_title(title, fontsize=10)
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0.01, hspace=0.01)
    figure.legend(handles=_label_patches(), loc="outside lower left", ncols=4, fontsize=8)
    heat = ScalarMappable(Normalize(0, 1), "inferno")
    bar = figure.colorbar(heat, ax=grid[-1, 2], location="bottom", pad=0.02, fraction=0.06)
    bar.ax.tick_params(labelsize=8)
    save_figure(figure, path)


@with_style
def roc(rankings: Mapping[str, Ranking], path: Path | str) -> None:
    """Draw the ROC curve of each ranking, the area below it in the legend."""
    _check_any("rankings", rankings)
    figure = new_figure(4.6, 4.6)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color=FAINT, linewidth=0.8, linestyle=(0, (2, 3)))
    styles = ("-", (0, (6, 2)), (0, (2, 1.5)), "-.")
    for index, (name, ranking) in enumerate(rankings.items()):
        auc = "no AUC" if ranking.roc_auc is None else f"AUC {ranking.roc_auc:.3f}"
        colour, style = HUES[index % len(HUES)], styles[index % len(styles)]
        axes.plot(
            *ranking.roc.T, color=colour, linestyle=style, linewidth=2, label=f"{name}: {auc}"
        )
    axes.set_xlim(-0.01, 1.01)
    axes.set_ylim(-0.01, 1.01)
    axes.set_aspect("equal")
    axes.set_xlabel("false positive rate")
    axes.set_ylabel("true positive rate")
    axes.grid(color="#e6e6e6", linewidth=0.6)
    axes.legend(loc="lower right", fontsize=9)
    save_figure(figure, path)


def moving_mean(values: Floats, n_mean: int) -> Floats:
    """Return the mean of each value and those before it, `n_mean` in all; NaN are left out."""
    known = np.isfinite(values)
    sums = np.cumsum(np.where(known, values, 0))
    counts = np.cumsum(known)
    sums[n_mean:] -= sums[:-n_mean].copy()
    counts[n_mean:] -= counts[:-n_mean].copy()
    means: Floats = np.divide(sums, counts, out=np.full(len(values), np.nan), where=counts > 0)
    return means


def window_shares(regions: npt.NDArray[np.int64], n_regions: int, n_window: int) -> Floats:
    """Return the share of each region in a window around each step, (n_regions, n_steps).

    At the ends the window is cut; steps in no region (-1) belong to no share.
    """
    is_there = regions[None, :] == np.arange(n_regions)[:, None]
    counted = np.pad(np.cumsum(is_there, axis=1), ((0, 0), (1, 0)))
    steps = np.arange(len(regions))
    first = np.maximum(0, steps - n_window // 2)
    after = np.minimum(len(regions), steps - n_window // 2 + n_window)
    shares: Floats = (counted[:, after] - counted[:, first]) / (after - first)
    return shares


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


def _label_patches() -> list[Patch]:
    """Return a swatch for each label, as the overlays paint it."""

    def paint(colour: tuple[int, int, int]) -> tuple[float, ...]:
        return tuple(value / 255 for value in colour)

    looks = {
        Label.SALIENT: {"edgecolor": paint(OUTLINE_COLOUR), "linewidth": 1.5},
        Label.UNKNOWN: {"hatch": "////", "edgecolor": "white", "linewidth": 0},
    }
    return [
        Patch(facecolor=paint(colour), label=LABEL_NAMES[label], **looks.get(label, {}))
        for label, colour in LABEL_COLOURS.items()
    ]
