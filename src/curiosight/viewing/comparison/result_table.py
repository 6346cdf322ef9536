"""The figures of all methods as a table of a page; a script sorts it by any column."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

from curiosight.viewing.comparison.content import MAIN_KEY, Column, MethodResult
from curiosight.viewing.comparison.curve_styles import StyledMethod
from curiosight.viewing.comparison.standings import (
    known_columns,
    leaders,
    with_direction,
    written,
    written_interval,
)
from curiosight.viewing.report.document import pairs
from curiosight.viewing.report.markup import NOTHING, Markup, element, join


def result_table(drawn: Sequence[StyledMethod]) -> Markup:
    """Return a row for each method, in the order given, the best AUC first.

    Rows have the classes of their curves, so that pointing at one shows the other.
    """
    methods = [one.method for one in drawn]
    columns = known_columns(methods)
    heads = [element("th", {"scope": "col", "data-first": "ascending"}, "method")]
    heads += [_head(column) for column in columns]
    rows = [_row(place, one, methods, columns) for place, one in enumerate(drawn)]
    table = element(
        "table",
        {"class": "methods"},
        element("thead", {}, element("tr", {}, *heads)),
        element("tbody", {}, *rows),
    )
    # Whoever cannot point at it scrolls with the keyboard.
    reach = {"class": "wide", "tabindex": "0", "role": "region", "aria-label": "Figures"}
    return element("div", reach, table)


def column_notes(methods: Sequence[MethodResult]) -> Markup:
    """Return what the columns mean, to fold out."""
    named = {column.title: f"{_explained(column)}." for column in known_columns(methods)}
    summary = element("summary", {}, "What the columns mean")
    return element("details", {"class": "notes"}, summary, pairs(named))


def sorting_script() -> str:
    """Return the script that lets the table's heads sort it."""
    return files(__package__).joinpath("sorting.js").read_text("utf-8")


def swatch(one: StyledMethod) -> Markup:
    """Return a short line as the method's curve is drawn."""
    return element("span", {"class": f"sample {look(one)}"})


def look(one: StyledMethod) -> str:
    """Return the classes that give a curve its colour and its dashes."""
    colour = "rest" if one.hue is None else f"hue-{one.hue}"
    weight = " ours" if one.method.is_ours else ""
    return f"{colour} dash-{one.dash}{weight}"


def _head(column: Column) -> Markup:
    attributes: dict[str, str | float] = {
        "scope": "col",
        "title": _explained(column),
        "data-first": "ascending" if column.is_lower_better else "descending",
    }
    if column.key == MAIN_KEY:
        attributes["aria-sort"] = "descending"
    return element("th", attributes, with_direction(column, column.title))


def _explained(column: Column) -> str:
    return f"{column.explanation}; {'less' if column.is_lower_better else 'more'} is better"


def _row(
    place: int,
    one: StyledMethod,
    methods: Sequence[MethodResult],
    columns: Sequence[Column],
) -> Markup:
    cells = [_cell(one.method, column, methods) for column in columns]
    name = element("th", {"scope": "row"}, swatch(one), one.method.name)
    kind = " ours" if one.method.is_ours else ""
    return element("tr", {"class": f"pick m{place}{kind}"}, name, *cells)


def _cell(method: MethodResult, column: Column, methods: Sequence[MethodResult]) -> Markup:
    """Return a figure, marked where it leads; only the AUC has its interval written below."""
    figure, interval = method.figure(column), written_interval(method, column)
    attributes: dict[str, str | float] = {}
    if figure is not None:
        attributes["data-value"] = f"{figure:.9g}"
    if interval and column.key != MAIN_KEY:
        attributes["title"] = f"95 % interval {interval}"
    if column.key == "ms":
        attributes["class"] = "measured"
    below = element("small", {}, interval) if interval and column.key == MAIN_KEY else NOTHING
    return element("td", attributes, _marked(written(figure, column), column, methods), below)


def _marked(figure: str, column: Column, methods: Sequence[MethodResult]) -> Markup:
    """Return a figure, bold where it is the column's best, underlined where the second best."""
    of_column = leaders(methods, column)
    if figure == of_column.best:
        return element("b", {}, figure)
    return element("u", {}, figure) if figure == of_column.second else join((figure,))
