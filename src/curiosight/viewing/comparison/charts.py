"""Curves as SVG of a page; lines stretch with the page, text and strokes do not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from curiosight.viewing.comparison.content import COLUMN_OF, MAIN_KEY, NO_CURVE, Curve, MethodResult
from curiosight.viewing.comparison.curve_styles import (
    UPPER_LEFT,
    WHOLE,
    Range,
    StyledMethod,
    Window,
    in_drawing_order,
    is_crowded,
    thinned_curve,
)
from curiosight.viewing.comparison.result_table import look, swatch
from curiosight.viewing.comparison.standings import written
from curiosight.viewing.paper import HUES
from curiosight.viewing.report.markup import NOTHING, Markup, element, join, number, path_of

_N_GAPS = 4  # between the ticks of an axis
_MAIN_COLUMN = COLUMN_OF[MAIN_KEY]


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """What a chart shows: the titles of its axes, a method's curve, the part of the plane."""

    title: str
    x_title: str
    y_title: str
    curve_of: Callable[[MethodResult], Curve]
    window: Window = WHOLE


_ROC = Chart("ROC", "false positive rate", "true positive rate", lambda method: method.roc)
_CORNER = Chart("ROC, upper left corner", _ROC.x_title, _ROC.y_title, _ROC.curve_of, UPPER_LEFT)
_PRECISION_RECALL = Chart(
    "Precision–recall", "recall", "precision", lambda method: method.precision_recall
)

_RELIABILITY = Chart("Reliability", "probability told", "share that is salient", lambda _: NO_CURVE)


def charts(drawn: Sequence[StyledMethod]) -> Markup:
    """Return the charts that have curves and the key of all; nothing where none has."""
    shown = [_ROC, _CORNER] if is_crowded(drawn) else [_ROC]
    shown = [
        chart
        for chart in (*shown, _PRECISION_RECALL)
        if any(len(chart.curve_of(one.method)) for one in drawn)
    ]
    if not shown:
        return NOTHING
    figures = element("div", {"class": "plots"}, *[_figure(chart, drawn) for chart in shown])
    return join((figures, _key(drawn)))


def reliability_chart(curves: Mapping[str, Curve]) -> Markup:
    """Return the chart of reliability curves, (n, 2) by name, and its key."""
    diagonal = element("path", {"class": "diagonal", "d": path_of(np.array([[0, 100], [100, 0]]))})
    lines, items = [diagonal], []
    for place, (name, curve) in enumerate(curves.items()):
        colour = f"hue-{place % len(HUES)}"
        title = element("title", {}, name)
        # Of one bin alone: a line of no length with round ends is a dot.
        path = path_of(_points(curve, WHOLE)) + ("h.01" if len(curve) == 1 else "")
        lines.append(element("path", {"class": f"line ours {colour}", "d": path}, title))
        sample = element("span", {"class": f"sample ours {colour}"})
        items.append(element("li", {}, sample, name))
    figure = _drawn(_RELIABILITY, lines)
    key = element("ul", {"class": "key lines"}, *items)
    return join((element("div", {"class": "plots"}, figure), key))


def pointing_style(n_methods: int) -> str:
    """Return CSS that shows a method's curve and row when either is pointed at."""
    rules = ["main:has(.pick:hover) .line{opacity:.25}"]
    for place in range(n_methods):
        here = f"main:has(.m{place}:hover)"
        rules.append(f"{here} .line.m{place}{{opacity:1;stroke-width:4}}")
        rules.append(f"{here} tr.m{place},{here} li.m{place}{{background:var(--soft)}}")
    return "".join(rules)


def _figure(chart: Chart, drawn: Sequence[StyledMethod]) -> Markup:
    place_of = {id(one): place for place, one in enumerate(drawn)}
    lines = [
        _line(one, place_of[id(one)], chart)
        for one in in_drawing_order(drawn)
        if len(chart.curve_of(one.method))
    ]
    return _drawn(chart, lines)


def _drawn(chart: Chart, lines: Sequence[Markup]) -> Markup:
    """Return a figure of lines in percent of the chart's window."""
    inside = {"viewBox": "0 0 100 100", "preserveAspectRatio": "none", "class": "inside"}
    plot = element(
        "svg",
        {"class": "chart", "role": "img", "aria-label": f"{chart.title}: all curves"},
        *_axes(chart),
        element("svg", {**inside, "width": "100%", "height": "100%"}, *lines),
    )
    caption = element("figcaption", {}, chart.title)
    return element("figure", {"class": "plot"}, caption, plot)


def _line(one: StyledMethod, place: int, chart: Chart) -> Markup:
    points = _points(_near(chart.curve_of(one.method), chart.window), chart.window)
    # A constant map has one point: a line of no length with round ends is a dot.
    drawn = path_of(points) + ("h.01" if len(points) == 1 else "")
    title = element("title", {}, one.method.name)
    return element("path", {"class": f"line pick m{place} {look(one)}", "d": drawn}, title)


def _near(curve: Curve, window: Window) -> Curve:
    """Return the part of a curve that runs through the window, and a point on each side."""
    (left, right), (low, high) = window
    across, up = curve.T
    is_inside = (left <= across) & (across <= right) & (low <= up) & (up <= high)
    inside = np.flatnonzero(is_inside)
    if not len(inside):
        return thinned_curve(curve)
    return thinned_curve(curve[max(0, inside[0] - 1) : inside[-1] + 2])


def _points(curve: Curve, window: Window) -> Curve:
    """Return points in percent of the window, as SVG counts downwards."""
    (left, right), (low, high) = window
    across = 100 * (curve[:, 0] - left) / (right - left)
    down = 100 * (high - curve[:, 1]) / (high - low)
    return np.stack([across, down], axis=1)


def _axes(chart: Chart) -> list[Markup]:
    """Return grid lines with their numbers, and the titles of both axes."""
    parts = []
    for share, value in _ticks(chart.window[1]):
        place = f"{number(100 * (1 - share))}%"
        parts.append(element("line", {"class": "grid", "x2": "100%", "y1": place, "y2": place}))
        at = {"class": "tick", "y": place, "dx": "-8", "dy": "0.35em", "text-anchor": "end"}
        parts.append(element("text", at, number(value)))
    for share, value in _ticks(chart.window[0]):
        place = f"{number(100 * share)}%"
        parts.append(element("line", {"class": "grid", "y2": "100%", "x1": place, "x2": place}))
        at = {"class": "tick", "x": place, "y": "100%", "dy": "1.4em", "text-anchor": "middle"}
        parts.append(element("text", at, number(value)))
    below = {"class": "tick", "x": "50%", "y": "100%", "dy": "2.8em", "text-anchor": "middle"}
    above = {"class": "tick", "x": "0", "dx": "-32", "dy": "-0.7em"}
    return [
        *parts,
        element("text", below, f"{chart.x_title} →"),
        element("text", above, f"{chart.y_title} ↑"),
    ]


def _ticks(of: Range) -> list[tuple[float, float]]:
    """Return the places of an axis' ticks, as shares of its length, and their values."""
    low, high = of
    return [(k / _N_GAPS, low + (high - low) * k / _N_GAPS) for k in range(_N_GAPS + 1)]


def _key(drawn: Sequence[StyledMethod]) -> Markup:
    """List the methods with their AUC."""
    items = []
    for place, one in enumerate(drawn):
        auc = element("b", {}, written(one.method.figure(_MAIN_COLUMN), _MAIN_COLUMN))
        kind = {"class": f"pick m{place}"}
        items.append(element("li", kind, swatch(one), f"{one.method.name} ", auc))
    return element("ul", {"class": "key lines"}, *items)
