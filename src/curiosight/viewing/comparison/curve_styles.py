"""Which of many curves stand out, and how: the same in every figure and on the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from curiosight.viewing.comparison.content import Curve, MethodResult
from curiosight.viewing.comparison.standings import ranked
from curiosight.viewing.paper import HUES

N_COLOURED = 4  # others than ours; more colours could not be told apart at a glance
MAX_POINTS = 500  # of a curve; more could not be seen
CORNER = 0.2  # of the axes, shown larger where good curves crowd there
DASHES: tuple[tuple[float, ...], ...] = ((), (6, 2), (2, 1.5))
_CROWDED_AUC = 0.9

Range = tuple[float, float]
Window = tuple[Range, Range]
WHOLE: Window = ((0, 1), (0, 1))
UPPER_LEFT: Window = ((0, CORNER), (1 - CORNER, 1))


@dataclass(frozen=True, slots=True, eq=False)
class StyledMethod:
    """A method, and how its curves are drawn.

    hue: index of `HUES`; None = grey. dash: index of `DASHES`.
    """

    method: MethodResult
    hue: int | None
    dash: int = 0


def styled(methods: Sequence[MethodResult]) -> list[StyledMethod]:
    """Return the methods, best AUC first: ours in the first hue, the best others coloured."""
    others = [method for method in ranked(methods) if not method.is_ours]
    hue_of = {id(method): hue for hue, method in enumerate(others[:N_COLOURED], start=1)}
    chosen, n_ours = [], 0
    for method in ranked(methods):
        if method.is_ours:
            chosen.append(StyledMethod(method, 0, n_ours % len(DASHES)))
            n_ours += 1
        else:
            chosen.append(StyledMethod(method, hue_of.get(id(method))))
    return chosen


def in_drawing_order(drawn: Sequence[StyledMethod]) -> list[StyledMethod]:
    """Return grey curves first, so that coloured ones lie above them, and ours above all."""
    return sorted(drawn, key=lambda one: -len(HUES) if one.hue is None else -one.hue)


def is_crowded(drawn: Sequence[StyledMethod]) -> bool:
    """Tell whether the ROC curves that stand out crowd in the upper left corner."""
    aucs = [one.method.figures.get("roc_auc") for one in drawn if one.hue is not None]
    known = [auc for auc in aucs if auc is not None]
    return bool(known) and float(np.median(known)) > _CROWDED_AUC


def thinned_curve(curve: Curve) -> Curve:
    """Return points of a curve that are evenly spread along its way, with both ends."""
    if len(curve) <= MAX_POINTS:
        return curve
    way = np.concatenate([[0], np.cumsum(np.abs(np.diff(curve, axis=0)).sum(axis=1))])
    kept = np.searchsorted(way, np.linspace(0, way[-1], MAX_POINTS))
    thinned: Curve = curve[np.unique(np.append(kept, [0, len(curve) - 1]))]
    return thinned
