"""What all figures share: their look, the colours of regions, and how they reach the disk.

They are drawn by Matplotlib (extra `curiosight[figures]`), which is imported when one is drawn.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Sequence
from functools import lru_cache, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors import printable
from curiosight.errors.files import replace_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")
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


NEEDED = "need Matplotlib, which is missing: pip install 'curiosight[figures]'"


def can_draw() -> bool:
    """Tell whether Matplotlib is installed."""
    return find_spec("matplotlib") is not None


def with_style(draw: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Decorate what draws: Matplotlib's settings are ours while it runs, and no longer.

    Where Matplotlib is missing it raises `ImportError`, which says how to install it.
    """

    @wraps(draw)
    def styled(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
        try:
            import matplotlib
        except ImportError:
            raise ImportError(f"figures {NEEDED}") from None
        with matplotlib.rc_context(_STYLE):
            return draw(*arguments, **options)

    return styled


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, independent of pyplot and of any window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: Path | str) -> None:
    """Write a figure, completely or not at all; the same figure gives the same bytes.

    path: what ends in .svg becomes SVG, in .pdf PDF, anything else PNG.
    Raises `DataError` where the file cannot be written.
    """
    import matplotlib
    from matplotlib.text import Text

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
        shares = np.linspace(0, 0.92, max(1, len(names)))
        return [rgb_of(*_viridis()[int(256 * share)]) for share in shares]
    colours = []
    for index, family in enumerate(family_of):
        n_shades = family_of.count(family)
        shade = family_of[:index].count(family) / max(1, n_shades - 1)
        colours.append(_shade(HUES[families.index(family)], shade))
    return colours


@lru_cache(maxsize=1)
def _viridis() -> npt.NDArray[np.uint8]:
    """Return the (256, 3) colours of the map, RGB, dark to light."""
    greys = np.arange(256, dtype=np.uint8)[:, None]
    colours: npt.NDArray[np.uint8] = cv2.applyColorMap(greys, cv2.COLORMAP_VIRIDIS)[:, 0, ::-1]
    return colours


def rgb_of(red: float, green: float, blue: float) -> Rgb:
    """Return an 8-bit colour in [0, 1]."""
    return float(red) / 255, float(green) / 255, float(blue) / 255


def rgb_of_hex(colour: str) -> Rgb:
    """Return a colour such as #0072B2 in [0, 1]."""
    return rgb_of(*bytes.fromhex(colour.removeprefix("#")))


def _shade(hue: str, shade: float) -> Rgb:
    """Darken (shade 0) or lighten (shade 1) a hue."""
    red, green, blue = rgb_of_hex(hue)
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
    figure = axes.get_figure(root=True)
    assert figure is not None
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
