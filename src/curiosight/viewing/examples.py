"""The figure of examples: colour, the teacher's labels, the saliency, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from curiosight.frame import LABEL_COLOURS, Label, Rgb
from curiosight.teacher import Segmentation
from curiosight.viewing.overlays import (
    LABEL_NAMES,
    OUTLINE_COLOUR,
    overlay_labels,
)
from curiosight.viewing.paper import new_figure, rgb_of, save_figure, with_style
from curiosight.viewing.truth import truth_picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

TITLES = ("colour", "what depth says", "saliency from colour", "truth")
_HEAT = "inferno"


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """A frame to show: its image, what the teacher said of it, what was predicted.

    caption: the frame's id, for instance.
    segmentation: None where no teacher was asked.
    saliency: (h, w) in [0, 1], as large as the image or as the shrunken one.
    ground_truth: (H, W) uint8 labels; None where it is not known.
    """

    caption: str
    rgb: Rgb
    segmentation: Segmentation | None
    saliency: npt.NDArray[np.floating]
    ground_truth: npt.NDArray[np.uint8] | None = None


@with_style
def examples(shown: Sequence[Example], path: Path | str, *, has_truth: bool = False) -> None:
    """Draw a row for each example, and what the colours mean below; has_truth: truth, too."""
    if not shown:
        raise ValueError("shown: expected at least one example, got none")
    height, width = shown[0].rgb.shape[:2]
    row_height = 2.24 * height / width
    n_columns = 4 if has_truth else 3
    figure = new_figure(2.4 * n_columns, len(shown) * (row_height + 0.03) + 0.7)
    figure.set_layout_engine("constrained", w_pad=0.015, h_pad=0.015, wspace=0, hspace=0)
    ratios = [1.0] * len(shown) + [0.08]
    grid = figure.subplots(len(shown) + 1, n_columns, squeeze=False, height_ratios=ratios)
    for panels, example in zip(grid, shown, strict=False):
        _draw_row(panels, example)
    for panel, title in zip(grid[0], TITLES, strict=False):
        panel.set_title(title, fontsize=10)
    _draw_key(figure, grid[-1])
    save_figure(figure, path)


def _draw_row(panels: Sequence[Axes], example: Example) -> None:
    panels[0].imshow(example.rgb)
    if example.segmentation is not None:
        panels[1].imshow(overlay_labels(example.rgb, example.segmentation))
    panels[2].imshow(example.saliency, cmap=_HEAT, vmin=0, vmax=1)
    if len(panels) > 3 and example.ground_truth is not None:
        panels[3].imshow(truth_picture(example.ground_truth))
    panels[0].set_ylabel(example.caption, fontsize=8)
    for panel in panels:
        panel.set_xticks([])
        panel.set_yticks([])
        panel.spines[:].set_visible(False)


def _draw_key(figure: Figure, panels: Sequence[Axes]) -> None:
    """Name the labels' colours below the first two columns, saliency's below the third."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    for panel in (*panels[:2], *panels[3:]):
        panel.set_axis_off()
    panels[0].legend(
        handles=_swatches(),
        loc="upper left",
        bbox_to_anchor=(0, 1.1),
        borderaxespad=0,
        ncols=4,
        fontsize=8,
    ).set_in_layout(False)
    heat = ScalarMappable(Normalize(0, 1), _HEAT)
    figure.colorbar(heat, cax=panels[2], orientation="horizontal")
    panels[2].set_xticks([0, 0.5, 1], ["0", "0.5", "1"], fontsize=8)
    # Inwards, or the bar would shrink to make room for half a digit.
    labels = panels[2].get_xticklabels()
    labels[0].set_horizontalalignment("left")
    labels[-1].set_horizontalalignment("right")


def _swatches() -> list[Patch]:
    """Return a patch for each label, painted as in the overlays."""
    from matplotlib.patches import Patch

    patches = {
        label: Patch(facecolor=rgb_of(*colour), label=LABEL_NAMES[label])
        for label, colour in LABEL_COLOURS.items()
    }
    patches[Label.SALIENT].set(edgecolor=rgb_of(*OUTLINE_COLOUR), linewidth=1.5)
    patches[Label.UNKNOWN].set(edgecolor="white", hatch="////", linewidth=0)
    return list(patches.values())
