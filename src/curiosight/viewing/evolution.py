"""The figure of one view's map as it comes about, look by look (fig. 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb
from curiosight.viewing.paper import new_figure, save_figure, with_style
from curiosight.viewing.truth import truth_picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes

N_COLUMNS = 4
_HEAT = "inferno"
_WIDTH = 2.0  # inches of a picture


@dataclass(frozen=True, slots=True, eq=False)
class MapThen:
    """A map, (H, W) in [0, 1], and what stands above it."""

    title: str
    saliency: npt.NDArray[np.floating]


@with_style
def evolution(
    rgb: Rgb,
    truth: npt.NDArray[np.uint8],
    maps: Sequence[MapThen],
    path: Path | str,
    *,
    outlined: npt.NDArray[np.bool_] | None = None,
    titles: tuple[str, str] = ("colour", "truth"),
) -> None:
    """Draw a view, its (H, W) labels and its maps in the order given.

    outlined: (H, W) pixels that are outlined in the colour image. path: ends in .png, .svg or
    .pdf. titles: of the first two pictures.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    if not maps:
        raise ValueError("maps: expected at least one, got none")
    n_rows = -(-(len(maps) + 2) // N_COLUMNS)
    height = _WIDTH * rgb.shape[0] / rgb.shape[1] + 0.25
    figure = new_figure(_WIDTH * N_COLUMNS, n_rows * height + 0.55)
    grid = figure.subplots(n_rows, N_COLUMNS, squeeze=False)
    panels = list(grid.flat)
    _show(panels[0], rgb, titles[0])
    if outlined is not None:
        panels[0].contour(outlined, [0.5], colors="#ffe13c", linewidths=1.2)
    _show(panels[1], truth_picture(truth), titles[1])
    for panel, one in zip(panels[2:], maps, strict=False):
        panel.imshow(one.saliency, cmap=_HEAT, vmin=0, vmax=1)
        _bare(panel, one.title)
    for panel in panels[len(maps) + 2 :]:
        panel.set_axis_off()
    heat = ScalarMappable(Normalize(0, 1), _HEAT)
    bar = figure.colorbar(heat, ax=grid, orientation="horizontal", shrink=0.3, aspect=40)
    bar.set_label("saliency", fontsize=8)
    bar.ax.tick_params(labelsize=8)
    save_figure(figure, path)


def _show(panel: Axes, picture: npt.NDArray[np.uint8], title: str) -> None:
    panel.imshow(picture)
    _bare(panel, title)


def _bare(panel: Axes, title: str) -> None:
    panel.set_title(title, fontsize=9)
    panel.set_xticks([])
    panel.set_yticks([])
    panel.spines[:].set_visible(False)
