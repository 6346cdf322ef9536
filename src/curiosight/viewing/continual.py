"""How well each place is known after each was learned, as a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.viewing.paper import FAINT, HUES, INK, new_figure, save_figure, with_style

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


# How an alarm's cause is drawn and told.
_CAUSES = {
    "light": ("light", HUES[4], "^"),
    "tint": ("light", HUES[4], "^"),
    "gone": ("moved", HUES[1], "s"),
    "new": ("new things", HUES[3], "D"),
    "errors": ("new things", HUES[3], "D"),
}


@with_style
def draw_changes(
    qualities: npt.NDArray[np.float64],
    names: Sequence[str],
    n_looks: Sequence[int],
    alarms: Sequence[tuple[int, str]],
    path: Path | str,
) -> None:
    """Draw how well each episode is known after each, and above that when there was an alarm.

    qualities, names: see `draw_qualities`. n_looks: of each episode. alarms: the look, over all
    episodes, and the cause of each.
    """
    figure = new_figure(8.0, 4.4)
    above, axes = figure.subplots(2, 1, sharex=True, height_ratios=(1, 4))
    ends = np.cumsum(n_looks)
    for number, (name, end) in enumerate(zip(names, ends, strict=True)):
        axes.plot(
            ends,
            qualities[:, number],
            "o-",
            color=HUES[number % len(HUES)],
            label=name,
            clip_on=False,
        )
        above.text(end - n_looks[number] / 2, 1.0, name, ha="center", va="bottom")
        for one in (above, axes):
            one.axvline(end, color=FAINT, linewidth=0.6, linestyle=":")
    told: set[str] = set()
    for look, cause in alarms:
        label, colour, marker = _CAUSES[cause]
        above.plot(look, 0.5, marker, color=colour, label="" if label in told else label)
        told.add(label)
    above.set_ylim(0, 1)
    above.set_yticks([0.5], ["alarms"])
    above.tick_params(length=0)
    above.spines["bottom"].set_visible(False)
    if told:
        above.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.set_xlim(0, ends[-1])
    axes.set_ylim(0, 1)
    axes.set_xlabel("looks")
    axes.set_ylabel("quality on its test views, F1")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="tested on")
    save_figure(figure, path)
