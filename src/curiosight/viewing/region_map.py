"""Where a run looked: its regions and its path, from above or along the recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from curiosight.explorer import Regions
from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Pose
from curiosight.viewing.paper import (
    FAINT,
    INK,
    Floats,
    Rgb,
    new_figure,
    region_colours,
    rgb_of_hex,
    save_figure,
    with_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Ints = npt.NDArray[np.int64]

# Inches: how wide a map is, how tall a figure may be, and a bar with its gap.
_MAP_WIDTH, _MOST_HEIGHT, _BAR = 4.0, 6.5, 0.45


@with_style
def regions_from_above(
    poses: Sequence[Pose | None],
    regions: Regions,
    visited: Sequence[int],
    path: Path | str,
    *,
    up: npt.ArrayLike | None = None,
    counted: str = "steps",
    is_way: bool = True,
    outlines: Sequence[npt.NDArray[np.floating]] = (),
) -> None:
    """Draw the regions of all views, and where the steps went, with the steps of each region.

    Without any pose the views are laid out along the recording instead of on a map.

    poses: one for each view. visited: the view of each step, in order.
    up: (3,) world vector against gravity; None = the cameras' mean up axis.
    counted: what `visited` are, in a word. is_way: join them, for they follow one another.
    outlines: (n, 2) metres each, walls in the same plane.
    """
    if len(poses) != len(regions.of_view):
        raise ValueError(
            f"poses: expected one for each of {len(regions.of_view)} views, got {len(poses)}"
        )
    looks = np.array(visited, np.int64)
    above = seen_from_above(poses, up)
    colours = _colours_of_views(regions)
    is_map = bool(np.isfinite(above.positions).any())
    shown = np.concatenate([above.positions[np.isfinite(above.headings)], *outlines])
    figure = new_figure(7.2, max(3.4, 0.22 * regions.n_regions + 0.9, _map_height(shown)))
    left, right = figure.subplots(1, 2, width_ratios=(2.4, 1))
    if is_map:
        for outline in outlines:
            left.fill(*outline.T, facecolor="#f4f4f4", edgecolor=FAINT, zorder=0)
        way = above.positions[looks] if is_way else above.positions[:0]
        left.plot(*way[np.isfinite(way[:, 0])].T, color=FAINT, linewidth=0.6, alpha=0.5, zorder=1)
        length = 0.05 * (float(np.ptp(shown, axis=0).max()) or 1.0)
        _draw_map(left, above.positions, above.headings, colours, looks, length)
    else:
        _draw_strip(left, colours, looks)
    _draw_counts(right, regions, looks, counted, n_bars=int(figure.get_figheight() / _BAR))
    save_figure(figure, path)


def _map_height(shown: Floats) -> float:
    """Return the inches of a figure in which a map of (n, 2) points fills its width."""
    if len(shown) == 0:
        return 0.0
    width, height = np.maximum(np.ptp(shown, axis=0), 1e-6)
    return min(_MOST_HEIGHT, _MAP_WIDTH * float(height / width) + 0.8)


def _colours_of_views(regions: Regions) -> Floats:
    """Return (n_views, 3) RGB; views in no region are grey."""
    palette: list[Rgb] = [*region_colours(regions.names), rgb_of_hex("#d0d0d0")]
    colours: Floats = np.array(palette)[regions.of_view]
    return colours


def _draw_map(
    axes: Axes, positions: Floats, headings: Floats, colours: Floats, looks: Ints, length: float
) -> None:
    """Draw each view as an arrow where it looks, the visited ones as dots, larger when often."""
    from matplotlib.ticker import MaxNLocator

    known = np.isfinite(headings)
    arrows = length * np.stack([np.cos(headings), np.sin(headings)], axis=1)
    axes.quiver(
        *positions[known].T,
        *arrows[known].T,
        color=colours[known],
        angles="xy",
        scale_units="xy",
        scale=1,
        width=0.0035,
        headwidth=4,
        headlength=5,
        zorder=2,
    )
    views, counts = np.unique(looks[known[looks]], return_counts=True)
    axes.scatter(
        positions[views, 0],
        positions[views, 1],
        s=14 * counts,
        color=colours[views],
        edgecolor=INK,
        linewidth=0.5,
        zorder=3,
    )
    # The arrows' tips count too, which matplotlib would let stick out.
    axes.update_datalim(positions[known] + arrows[known])
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.set_xlabel("metres")
    axes.set_ylabel("metres")


def _draw_strip(axes: Axes, colours: Floats, looks: Ints) -> None:
    """Draw the recording as a strip of regions, and above it each step's view, newest on top."""
    n_views = len(colours)
    strip_height = max(1.0, 0.06 * len(looks))
    axes.imshow(
        colours[None],
        extent=(-0.5, n_views - 0.5, -1.5 * strip_height, -0.5 * strip_height),
        aspect="auto",
        interpolation="nearest",
    )
    steps = np.arange(len(looks))
    axes.plot(looks, steps, color=FAINT, linewidth=0.5, alpha=0.5, zorder=1)
    axes.scatter(looks, steps, s=12, color=colours[looks], edgecolor=INK, linewidth=0.3, zorder=2)
    axes.set_xlim(-0.5, n_views - 0.5)
    axes.set_ylim(-1.5 * strip_height, max(1, len(looks)))
    axes.set_yticks([tick for tick in axes.get_yticks() if 0 <= tick <= len(looks)])
    axes.set_xlabel("frame of the recording")
    axes.set_ylabel("step")


def _draw_counts(axes: Axes, regions: Regions, looks: Ints, counted: str, *, n_bars: int) -> None:
    """Draw a bar for each region, as long as the steps spent there: the key to the colours.

    n_bars: for so many there is room.
    """
    steps = np.bincount(regions.of_view[looks] + 1, minlength=regions.n_regions + 1)[1:]
    places = np.arange(regions.n_regions)
    colours = region_colours(regions.names)
    bars = axes.barh(places, steps, color=colours, height=0.7)
    axes.bar_label(bars, padding=3, fontsize=8)
    # A region without a step has no bar, but a colour of its own on the map.
    beside = axes.get_yaxis_transform()
    axes.scatter(
        np.full(len(places), -0.05),
        places,
        s=28,
        c=colours,
        marker="s",
        transform=beside,
        clip_on=False,
    )
    axes.set_yticks(places, regions.names, fontsize=8)
    axes.set_ylim(max(regions.n_regions, n_bars) - 0.5, -0.5)
    axes.set_xlim(0, max(1, int(steps.max(initial=0))) * 1.15)
    axes.set_xticks([])
    axes.tick_params(axis="y", length=0, pad=14)
    axes.spines[["bottom", "left"]].set_visible(False)
    axes.set_title(f"{counted} in each region", fontsize=10, loc="left")
