"""All methods in figures for a paper: ROC (sec. III-A), precision–recall, a wall of maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from curiosight.viewing.comparison.confusion import OUTCOMES
from curiosight.viewing.comparison.content import COLUMN_OF, Curve, MethodResult, WallRow
from curiosight.viewing.comparison.curve_styles import (
    DASHES,
    UPPER_LEFT,
    StyledMethod,
    Window,
    in_drawing_order,
    is_crowded,
    styled,
    thinned_curve,
)
from curiosight.viewing.comparison.standings import ranked, written
from curiosight.viewing.comparison.wall import TILE_PX, Mosaic, blocks, mosaic
from curiosight.viewing.paper import FAINT, HUES, INK, new_figure, rgb_of, save_figure, with_style
from curiosight.viewing.truth import HATCH, IGNORED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

_GREY = "#b4b4b4"
_GRID = "#e6e6e6"
_TILE_WIDTH = 1.0  # inches of a picture of the wall
_TITLE_HEIGHT = 0.55
_KEY_HEIGHT = 0.3
_TITLE_STYLE: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": 9, "linespacing": 1.1}
_CAPTION_STYLE: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": 6.5, "rotation": 90}
_ROW_HEIGHT = 0.2  # inches of a line of the key


@with_style
def draw_roc(methods: Sequence[MethodResult], path: Path | str) -> None:
    """Draw the ROC curves of all methods, ours and the best others in colour.

    Where these crowd in the upper left corner, it is shown larger. Beside the curves stand all
    names with their AUC. path: ends in .png or .svg.
    """
    drawn = styled(methods)
    curves = [(one, one.method.roc) for one in in_drawing_order(drawn)]
    axes = _new_axes(len(drawn), "false positive rate", "true positive rate")
    axes.plot([0, 1], [0, 1], color=FAINT, linewidth=0.8, linestyle=(0, (2, 3)))
    _plot(axes, curves)
    if is_crowded(drawn):
        _draw_corner(axes, UPPER_LEFT, curves)
    _draw_key(axes, drawn, "roc_auc")
    _save(axes, path)


@with_style
def draw_precision_recall(methods: Sequence[MethodResult], path: Path | str) -> None:
    """Draw precision over recall of all methods, in the colours of `draw_roc`.

    Beside the curves stand all names with their average precision. path: ends in .png or .svg.
    """
    drawn = styled(methods)
    axes = _new_axes(len(drawn), "recall", "precision")
    _plot(axes, [(one, one.method.precision_recall) for one in in_drawing_order(drawn)])
    _draw_key(axes, drawn, "average_precision")
    _save(axes, path)


@with_style
def draw_wall(rows: Sequence[WallRow], path: Path | str) -> None:
    """Draw image, truth, the mistakes of the first map, and all maps of some frames (fig. 4).

    A line for each frame. Where the maps are too many for one line they go on in a second
    block below, beside image and truth again. path: ends in .png or .svg.
    """
    if not rows:
        raise ValueError("rows: expected at least one, got none")
    drawn = [
        mosaic(rows, names, has_mistakes=place == 0) for place, names in enumerate(blocks(rows))
    ]
    widths = [block.picture.shape[1] / TILE_PX * _TILE_WIDTH for block in drawn]
    heights = [block.picture.shape[0] / TILE_PX * _TILE_WIDTH for block in drawn]
    width, height = max(widths), sum(heights) + len(drawn) * _TITLE_HEIGHT + _KEY_HEIGHT
    figure = new_figure(width, height)
    figure.set_layout_engine("none")
    top = height
    for block, block_width, block_height in zip(drawn, widths, heights, strict=True):
        top -= _TITLE_HEIGHT + block_height
        place = (0, top / height, block_width / width, block_height / height)
        _draw_mosaic(figure.add_axes(place), block)
    figure.legend(
        handles=_outcome_patches(),
        loc="upper left",
        bbox_to_anchor=(0, (top - 0.03) / height),
        borderaxespad=0,
        ncols=5,
        fontsize=9,
        handlelength=1.2,
    )
    save_figure(figure, path)


def _draw_mosaic(axes: Axes, block: Mosaic) -> None:
    """Show a block, the columns' titles above it and the frames' captions on its left."""
    axes.set_axis_off()
    axes.imshow(block.picture, aspect="auto")
    height, width = block.picture.shape[:2]
    for title, u in block.titles:
        axes.text(u / width, 1.01, title, transform=axes.transAxes, **_TITLE_STYLE)
    for caption, v in block.captions:
        axes.text(-0.004, 1 - v / height, caption, transform=axes.transAxes, **_CAPTION_STYLE)


def _outcome_patches() -> list[Patch]:
    """Return a patch for each colour of the mistakes and of the truth."""
    from matplotlib.patches import Patch

    patches = [Patch(facecolor=rgb_of(*colour), label=name) for name, colour in OUTCOMES.items()]
    ignored = Patch(facecolor=rgb_of(*IGNORED), linewidth=0, label="ignored: truth not known")
    ignored.set(edgecolor=rgb_of(*HATCH), hatch="////")
    return [*patches, ignored, Patch(visible=False, label="maps: black 0, white 1")]


def _new_axes(n_methods: int, x_title: str, y_title: str) -> Axes:
    """Return square axes from 0 to 1, as high as the key that will stand beside them."""
    side = max(4.4, _ROW_HEIGHT * (n_methods + 1) + 0.6)
    axes = new_figure(side + 2.6, side).add_subplot()
    axes.set_xlim(-0.01, 1.01)
    axes.set_ylim(-0.01, 1.01)
    axes.set_aspect("equal")
    axes.set_xlabel(x_title)
    axes.set_ylabel(y_title)
    axes.grid(color=_GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    return axes


def _plot(axes: Axes, curves: Sequence[tuple[StyledMethod, Curve]]) -> None:
    for one, curve in curves:
        if len(curve):
            line = _line(one)
            line.set_data(*thinned_curve(curve).T)
            if len(curve) == 1:  # of a constant map: no line, so a dot
                line.set_marker("o")
            axes.add_line(line)


def _line(one: StyledMethod) -> Line2D:
    """Return a line without points, in the method's look."""
    from matplotlib.lines import Line2D

    dashes = DASHES[one.dash]
    return Line2D(
        [],
        [],
        color=_GREY if one.hue is None else HUES[one.hue],
        linewidth=_width(one),
        linestyle=(0, dashes) if dashes else "-",
        markersize=4,
    )


def _width(one: StyledMethod) -> float:
    if one.method.is_ours:
        return 2.6 if one.dash == 0 else 2.0
    return 0.8 if one.hue is None else 1.5


def _draw_corner(axes: Axes, window: Window, curves: Sequence[tuple[StyledMethod, Curve]]) -> None:
    """Show a part of the axes larger, in their lower right, where curves seldom are."""
    inset = axes.inset_axes((0.4, 0.1, 0.56, 0.56))
    _plot(inset, curves)
    inset.set_xlim(*window[0])
    inset.set_ylim(*window[1])
    inset.spines[:].set_visible(True)
    inset.grid(color=_GRID, linewidth=0.6)
    inset.locator_params(nbins=4)
    inset.tick_params(labelsize=8, color=FAINT)
    axes.indicate_inset_zoom(inset, edgecolor=FAINT, alpha=0.5)


def _draw_key(axes: Axes, drawn: Sequence[StyledMethod], key: str) -> None:
    """List the names of all methods beside the axes, with a figure, the best first."""
    column = COLUMN_OF[key]
    of_method = {id(one.method): one for one in drawn}
    in_order = [of_method[id(m)] for m in ranked([one.method for one in drawn], key)]
    lines = [_line(one) for one in in_order]
    texts = [f"{written(one.method.figure(column), column)}  {_short(one)}" for one in in_order]
    legend = axes.legend(
        lines,
        texts,
        title=f"{column.title}, method",
        loc="upper left",
        bbox_to_anchor=(1.01, 1.02),
        alignment="left",
        fontsize=8.5,
        title_fontsize=8.5,
        handlelength=2.2,
        labelspacing=0.32,
    )
    for one, text in zip(in_order, legend.get_texts(), strict=True):
        text.set_color("#6a6a6a" if one.hue is None else INK)
        text.set_fontweight("bold" if one.method.is_ours else "normal")


def _short(one: StyledMethod) -> str:
    name = one.method.name
    return name if len(name) <= 28 else f"{name[:27]}…"


def _save(axes: Axes, path: Path | str) -> None:
    figure = axes.get_figure(root=True)
    assert figure is not None
    save_figure(figure, path)
