"""The page of a contest: what it found, source by source, in one file that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from pathlib import Path

from curiosight.errors.files import replace_file
from curiosight.viewing.contest.content import ContestReport, SourceReport
from curiosight.viewing.contest.tables import (
    IN_ORDER,
    PLACES_LEFT,
    columns_of,
    has_places_left,
    offline_sentence,
    places_left_rows,
    qualities_rows,
    ranked,
    ratio,
)
from curiosight.viewing.report.document import document, section
from curiosight.viewing.report.markup import NOTHING, Markup, element, join

_STYLE = (
    ".wide{overflow-x:auto}.wide .results{max-width:none}.wide .results th{white-space:nowrap}"
    ".wide .results tbody td{font-weight:400}.charts img{width:100%;max-width:48rem;height:auto}"
)
_TABLE = (
    "Means over the seeds with their 95 % intervals, the soonest at 90 % of the off-line model's "
    "F1 first. A seed that never got there counts with all of its run, so that its figure is a "
    "lower bound (≥). Errors over seconds and looks are means over as long as the shortest run. "
    "Spread: the standard deviation between seeds, averaged over looks 20 to 400."
)
_PAIRS = (
    "How many times the seconds to 90 % the row's strategy took, by those of the column's: below "
    "1 it is faster. Intervals are of 95 %, seeds drawn in pairs."
)


def write_contest(report: ContestReport, path: Path) -> None:
    """Write the page, completely or not at all; the same report gives the same bytes."""
    page = document("Strategies compared", _sections(report), style=_STYLE)
    replace_file(path, page.encode("utf-8", "replace"))


def _sections(report: ContestReport) -> Iterator[Markup]:
    title = element("h1", {}, "Strategies compared")
    yield element("header", {}, title, element("p", {"class": "lead"}, report.sentence))
    for number, source in enumerate(report.sources):
        yield section(f"source-{number}", source.name, "", _source(source))
    parts = [element("pre", {}, element("code", {}, report.command))]
    if report.settings:
        summary = element("summary", {}, "All settings")
        parts.append(element("details", {}, summary, element("pre", {}, report.settings)))
    yield section("making", "How this was made", "", join(parts))


def _source(source: SourceReport) -> Markup:
    names, columns = ranked(source.table), columns_of(source.table)
    rows = {
        name: [cell(source.table["strategies"][name]) for cell in columns.values()]
        for name in names
    }
    pairs = source.table["pairs"]
    ratios = {
        a: ["" if a == b else ratio(pairs[f"{a}/{b}"]["seconds_to_90"]) for b in names]
        for a in names
    }
    return join(
        [
            element("p", {}, f"{offline_sentence(source.table)} {_TABLE}"),
            _table(list(columns), rows),
            _charts(source.figures, is_open=True),
            element("h3", {}, "In pairs"),
            element("p", {}, _PAIRS),
            _table(names, ratios),
            _places_left(source),
            _charts(source.regions, is_open=False),
        ]
    )


def _places_left(source: SourceReport) -> Markup:
    """Tell what is left of places, the matrices to fold out; nothing where they are not known."""
    if not has_places_left(source.table):
        return NOTHING
    columns, rows = places_left_rows(source.table)
    matrices = {name: qualities_rows(source.table, name) for name in rows}
    shown = [
        join([element("h4", {}, name), _table(*matrix)])
        for name, matrix in matrices.items()
        if matrix is not None
    ]
    summary = element("summary", {}, "Place by place, in the order of learning")
    return join(
        [
            element("h3", {}, "What is left of places"),
            element("p", {}, PLACES_LEFT),
            _table(columns, rows),
            element("details", {}, summary, element("p", {}, IN_ORDER), *shown),
        ]
    )


def _table(columns: list[str], rows: Mapping[str, list[str]]) -> Markup:
    head = [element("th", {"scope": "col"}, column) for column in columns]
    body = [
        element(
            "tr",
            {},
            element("th", {"scope": "row"}, name),
            *[element("td", {}, cell) for cell in cells],
        )
        for name, cells in rows.items()
    ]
    table = element(
        "table",
        {"class": "results"},
        element("thead", {}, element("tr", {}, element("td", {}), *head)),
        element("tbody", {}, *body),
    )
    return element("div", {"class": "wide"}, table)


def _charts(figures: Mapping[str, Path], *, is_open: bool) -> Markup:
    """Show figures one below the other; those that are not open are to fold out."""
    if not figures:
        return NOTHING
    shown = element("div", {"class": "charts"}, *[_chart(*pair) for pair in figures.items()])
    if is_open:
        return shown
    summary = element("summary", {}, "Where the looks went, strategy by strategy")
    return element("details", {}, summary, shown)


def _chart(title: str, path: Path) -> Markup:
    content = base64.b64encode(path.read_bytes()).decode("ascii")
    image = element("img", {"src": f"data:image/svg+xml;base64,{content}", "alt": title})
    return element("figure", {}, element("figcaption", {}, title), image)
