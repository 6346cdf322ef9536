"""How well each place is known after each was learned, as a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.viewing.paper import INK, new_figure, save_figure, with_style

# Of a cell, inches; of a name the last so many letters are told.
_CELL, _LETTERS = 0.55, 30


@with_style
def draw_qualities(
    qualities: npt.NDArray[np.float64], names: Sequence[str], path: Path | str
) -> None:
    """Draw (n, n) qualities in [0, 1]: row = after which episode, column = of which; NaN = none.

    path: ends in .png, .svg or .pdf.
    """
    n = len(names)
    figure = new_figure(4.0 + _CELL * n, 3.0 + _CELL * n)
    axes = figure.add_subplot()
    shown = axes.imshow(qualities, vmin=0, vmax=1, cmap="viridis")
    for row in range(n):
        for column in range(n):
            value = qualities[row, column]
            if np.isfinite(value):
                colour = "white" if value < 0.6 else INK
                text = f"{value:.2f}".removeprefix("0")
                axes.text(column, row, text, ha="center", va="center", color=colour, fontsize=8)
    names = [name if len(name) <= _LETTERS else f"…{name[-_LETTERS:]}" for name in names]
    axes.set_xticks(range(n), names, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(n), names)
    axes.set_xlabel("tested on")
    axes.set_ylabel("after learning")
    for side in axes.spines.values():
        side.set_visible(False)
    axes.tick_params(length=0)
    figure.colorbar(shown, ax=axes, shrink=0.6, label="quality, F1")
    save_figure(figure, path)
