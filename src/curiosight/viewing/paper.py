"""What all figures share: their look, the colours of regions, and how they reach the disk."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from curiosight.errors import printable
from curiosight.errors.files import replace_file

Rgb = tuple[float, float, float]
Floats = npt.NDArray[np.float64]

DPI = 150
# Okabe and Ito's hues, told apart with any colour vision; their yellow is too pale for paper.
HUES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
INK = "#222222"
FAINT = "#8a8a8a"
_LINE = 0.26  # inches from label to label

# What a file would tell of the day and the program it was made with, by kind of file.
_WITHOUT_DATE: dict[str, dict[Any, Any]] = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}
_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same picture on every machine
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "text.parse_math": False,  # a frame may be called $1
    "legend.frameon": False,
}


# Decorates whatever draws: matplotlib's settings are ours while it runs, and no longer.
with_style = matplotlib.rc_context(_STYLE)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, independent of pyplot and of any window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: Path | str) -> None:
    """Write a figure, completely or not at all; the same figure gives the same bytes.

    path: what ends in .svg becomes SVG, in .pdf PDF, anything else PNG.
    Raises `DataError` where the file cannot be written.
    """
    kind = Path(path).suffix.lower().removeprefix(".")
    kind = kind if kind in _WITHOUT_DATE else "png"
    drawn = io.BytesIO()
    for text in figure.findobj(Text):  # names of files and regions are anybody's
        _make_printable(text)
    # Without the salt ids are random.
    with matplotlib.rc_context({"svg.hashsalt": "curiosight"}), warnings.catch_warnings():
        # A name in a script that the font has not is drawn as boxes, which speak for themselves.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure.savefig(
            drawn,
            format=kind,
            dpi=DPI,
            bbox_inches="tight",
            pad_inches=0.08,
            metadata=_WITHOUT_DATE[kind],
        )
    replace_file(Path(path), drawn.getvalue())


def _make_printable(text: Text) -> None:
    """Write out what is no character to draw; lines stay lines."""
    said = text.get_text()
    shown = "\n".join(map(printable, said.split("\n")))
    if shown != said:
        text.set_text(shown)


def region_colours(names: Sequence[str]) -> list[Rgb]:
    """Return a colour for each region, RGB in [0, 1].

    Names that differ only in their last word, such as the headings at one place, are shades of
    one hue, dark to light; where there is one such family, or too many, colours follow the order.
    """
    family_of = [name.rpartition(" ")[0] for name in names]
    families = list(dict.fromkeys(family_of))
    if not 1 < len(families) <= len(HUES):
        ramp = colormaps["viridis"](np.linspace(0, 0.92, max(1, len(names))))
        return [(float(r), float(g), float(b)) for r, g, b, _ in ramp]
    colours = []
    for index, family in enumerate(family_of):
        n_shades = family_of.count(family)
        shade = family_of[:index].count(family) / max(1, n_shades - 1)
        colours.append(_shade(HUES[families.index(family)], shade))
    return colours


def _shade(hue: str, shade: float) -> Rgb:
    """Darken (shade 0) or lighten (shade 1) a hue."""
    red, green, blue = to_rgb(hue)
    towards, amount = (0.0, 0.35 - shade) if shade < 0.35 else (1.0, shade - 0.35)
    return (
        red + amount * (towards - red),
        green + amount * (towards - green),
        blue + amount * (towards - blue),
    )


def label_ends(
    axes: Axes, ends: Sequence[tuple[float, float, str, Any]], *, gap: float = 0.05
) -> None:
    """Write labels to the right of the axes, each joined to the (x, y) where its line ends.

    ends: x, y, text and colour; x NaN = there is nothing to join the label to. gap: the least
    distance of two labels, as a share of the height.
    """
    low, high = axes.get_ylim()
    ends = sorted(ends, key=lambda end: end[1])
    heights = spread([(end[1] - low) / (high - low) for end in ends], gap)
    for (x, y, text, colour), height in zip(ends, heights, strict=True):
        joint = {"color": colour, "arrowstyle": "-", "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
        if not math.isnan(x):
            axes.annotate(
                "",
                xy=(x, y),
                xytext=(1.04, height),
                textcoords="axes fraction",
                arrowprops=joint,
                annotation_clip=False,
            )
        axes.plot(1.045, height, "s", color=colour, clip_on=False, transform=axes.transAxes)
        axes.text(1.065, height, text, va="center", transform=axes.transAxes)


def label_shares(
    axes: Axes, x: float, shares: Floats, names: Sequence[str], colours: Sequence[Rgb]
) -> None:
    """Label shares (n,) that are stacked at x, in an axes that they fill; see `label_ends`."""
    middles = np.cumsum(shares) - shares / 2
    joints = np.where(shares > 0, x, np.nan)
    ends = list(zip(joints.tolist(), middles.tolist(), names, colours, strict=True))
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    label_ends(axes, ends, gap=_LINE / figure.get_figheight())


def spread(positions: Sequence[float], gap: float) -> Floats:
    """Move rising positions in [0, 1] up or down until neighbours are at least `gap` apart.

    Their order stays; where they are too many the gap shrinks.
    """
    n = len(positions)
    steps = min(gap, 1 / max(1, n - 1)) * np.arange(n)
    apart = np.maximum.accumulate(np.asarray(positions) - steps) + steps
    spread_out: Floats = np.minimum(apart, 1 - steps[::-1])
    return spread_out
