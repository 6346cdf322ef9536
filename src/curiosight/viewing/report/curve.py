"""The learning curve as SVG; lines stretch with the page, text and strokes do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.explorer.progress import moving_mean
from curiosight.viewing.paper import spread
from curiosight.viewing.report.content import ReportStep
from curiosight.viewing.report.markup import NOTHING, Markup, element, number, path_of, thinned

Floats = npt.NDArray[np.float64]

MAX_POINTS = 2000  # of a line; more could not be told apart
N_MEAN = 10
_TICKS = (0.0, 0.25, 0.5, 0.75, 1.0)
_LABEL_GAP = 0.15


def learning_curve(steps: Sequence[ReportStep]) -> Markup:
    """Return overall error and error of each step (eq. 1) over the steps; empty if none is known.

    steps: at least one. Points are in percent: x of the way from the first step to the last,
    y = 100 * (1 - error), as SVG counts downwards.
    """
    overall = _defined(steps, [step.overall_error for step in steps])
    region = _defined(steps, [step.error for step in steps])
    if not len(overall) and not len(region):
        return NOTHING
    mean = region.copy()
    mean[:, 1] = 100 - moving_mean(100 - region[:, 1], N_MEAN)
    lines = element(
        "svg",
        {
            "viewBox": "0 0 100 100",
            "preserveAspectRatio": "none",
            "width": "100%",
            "height": "100%",
        },
        _line("dots", region, is_dotted=True),
        _line("mean", mean),
        _line("overall", overall),
    )
    named = [("overall", "test views", overall), ("mean", "each frame", mean)]
    ends = [(kind, name, points[-1]) for kind, name, points in named if len(points)]
    axes = [*_error_axis(), *_step_axis(steps[0].step, steps[-1].step)]
    described = f"{_described('Error on the test views', overall)}"
    described += _described("Error of each frame", mean)
    return element(
        "svg",
        {"class": "chart", "role": "img", "aria-label": described.strip()},
        *axes,
        lines,
        *_end_labels(ends),
    )


def _defined(steps: Sequence[ReportStep], errors: Sequence[float | None]) -> Floats:
    """Return the errors that are defined as (n, 2) points in percent."""
    first = steps[0].step
    span = max(1, steps[-1].step - first)
    points = [
        (100 * (step.step - first) / span, 100 * (1 - error))
        for step, error in zip(steps, errors, strict=True)
        if error is not None
    ]
    return np.array(points, np.float64).reshape(-1, 2)


def _line(kind: str, points: Floats, *, is_dotted: bool = False) -> Markup:
    if not len(points):
        return NOTHING
    points = thinned(points, MAX_POINTS)
    if is_dotted:  # a round end to a line of no length is a dot that never becomes an ellipse
        drawn = "".join(f"M{number(x)} {number(y)}h.01" for x, y in points)
    else:
        drawn = path_of(points)
    return element("path", {"class": kind, "d": drawn})


def _error_axis() -> list[Markup]:
    title = {"class": "tick", "x": "0", "dx": "-32", "dy": "-1.1em"}
    parts = [element("text", title, "error")]
    for error in _TICKS:
        height = f"{number(100 * (1 - error))}%"
        parts.append(element("line", {"class": "grid", "x2": "100%", "y1": height, "y2": height}))
        place = {"class": "tick", "y": height, "dx": "-8", "dy": "0.35em", "text-anchor": "end"}
        parts.append(element("text", place, number(error)))
    return parts


def _step_axis(first: int, last: int) -> list[Markup]:
    """Number frames from 1, as a person counts them."""
    ends = [("0", "start", str(first + 1)), ("50%", "middle", "frames looked at →")]
    if last > first:
        ends.append(("100%", "end", str(last + 1)))
    return [
        element("text", {"class": "tick", "x": x, "y": "100%", "dy": "1.6em", "text-anchor": to}, t)
        for x, to, t in ends
    ]


def _end_labels(ends: Sequence[tuple[str, str, Floats]]) -> list[Markup]:
    """Name each line at its end, with the error it ends with."""
    ends = sorted(ends, key=lambda end: float(end[2][1]))
    heights = spread([float(point[1]) / 100 for _, _, point in ends], _LABEL_GAP)
    labels = []
    for (kind, name, point), height in zip(ends, heights, strict=True):
        place = {"class": f"end {kind}", "x": "100%", "y": f"{number(100 * height)}%"}
        error = element("tspan", {"class": "value"}, f"{1 - point[1] / 100:.2f}")
        below = element("tspan", {"x": "100%", "dx": "10", "dy": "1.15em"}, name)
        value = element("tspan", {"dx": "10", "dy": "-0.1em"}, error)
        labels.append(element("text", place, value, below))
    return labels


def _described(name: str, points: Floats) -> str:
    if not len(points):
        return ""
    first, last = (1 - points[[0, -1], 1] / 100).tolist()
    return f"{name}: from {first:.2f} at first to {last:.2f} at the end. "
