"""Who stands where: the order of methods, the best of each column, and how figures are written."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from curiosight.viewing.comparison.content import COLUMN_OF, COLUMNS, MAIN_KEY, Column, MethodResult

MISSING = "–"


@dataclass(frozen=True, slots=True)
class Leaders:
    """The best figures of a column and the second best, as they are written."""

    best: str | None
    second: str | None


def ranked(methods: Iterable[MethodResult], key: str = MAIN_KEY) -> list[MethodResult]:
    """Return the methods, best first; without a figure last, equals in the order given."""
    column = COLUMN_OF[key]

    def place(method: MethodResult) -> tuple[bool, float]:
        figure = method.figure(column)
        if figure is None:
            return True, 0.0
        return False, figure if column.is_lower_better else -figure

    return sorted(methods, key=place)


def known_columns(methods: Sequence[MethodResult]) -> list[Column]:
    """Return the columns in which any method has a figure."""
    return [c for c in COLUMNS if any(method.figure(c) is not None for method in methods)]


def leaders(methods: Sequence[MethodResult], column: Column) -> Leaders:
    """Return a column's best and second-best figures.

    As they are written, so that what reads the same is marked the same.
    """
    figures = [method.figure(column) for method in ranked(methods, column.key)]
    known = dict.fromkeys(written(figure, column) for figure in figures if figure is not None)
    best, second, *_ = [*known, None, None]
    return Leaders(best, second)


def written(figure: float | None, column: Column) -> str:
    """Write a figure with three decimals, a time with about three digits."""
    if figure is None:
        return MISSING
    if column.key == "ms":
        return f"{figure:.1f}" if figure < 100 else f"{figure:.0f}"
    return f"{figure:.3f}"


def written_interval(method: MethodResult, column: Column) -> str:
    """Write a method's interval as "[.912, .951]"; empty where it is not known."""
    interval = method.intervals.get(column.key)
    if interval is None:
        return ""
    low, high = (f"{end:.3f}".removeprefix("0") for end in interval)
    return f"[{low}, {high}]"


def with_direction(column: Column, title: str) -> str:
    """Add to a title an arrow that says which way is better."""
    return f"{title} {'↓' if column.is_lower_better else '↑'}"
