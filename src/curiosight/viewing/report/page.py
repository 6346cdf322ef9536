"""Put the page together, a section for all that the report has content for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from curiosight.errors.files import replace_file
from curiosight.viewing.report.content import Making, Report, ResultRow, Results
from curiosight.viewing.report.curve import N_MEAN, learning_curve
from curiosight.viewing.report.decisions import decision_table
from curiosight.viewing.report.document import document, list_section, pairs, section
from curiosight.viewing.report.floor_plan import floor_plan, grid_of
from curiosight.viewing.report.markup import NOTHING, Markup, element, join, number
from curiosight.viewing.report.pictures import example_groups
from curiosight.viewing.report.region_time import (
    region_key,
    region_styles,
    time_in_regions,
    window_of,
)

_EXAMPLES = (
    "Depth teaches: it shows what stands out from floor, tables and walls, as far as depth "
    "reaches. From that the model learns how such things look, and then finds them in colour "
    "alone, the brighter the surer."
)
_CURVE = (
    "The error is 1 − F1: 0 where the model finds all of the objects and nothing else, 1 where it "
    "finds nothing right. Each dot is a frame before the model learned from it, compared with "
    f"what depth says; the thin line is their mean over {N_MEAN}."
)

_DECISIONS = (
    "The last times that it chose a region: how far that was, why it was chosen, and which other "
    "had the highest score. All candidates of all decisions are in decisions.csv."
)


def write_report(report: Report, path: Path) -> None:
    """Write the page, completely or not at all; raise `DataError` where that cannot be.

    The same report gives the same bytes.
    """
    # A path of Linux may hold bytes that are no text; they become question marks.
    replace_file(path, report_html(report).encode("utf-8", "replace"))


def report_html(report: Report) -> str:
    """Return the page: one file that asks for nothing from outside and runs no script."""
    return document(report.title, _sections(report), style=region_styles(report.region_names))


def _sections(report: Report) -> Iterator[Markup]:
    yield _opening(report)
    if any(group.examples for group in report.examples):
        yield section("examples", "What it sees", _EXAMPLES, example_groups(report.examples))
    if any(table.rows for table in report.results):
        yield section("results", "In numbers", "", join(map(_results, report.results)))
    if report.steps:
        yield _curve(report)
    if report.room_map is not None:
        yield _map(report)
    if report.steps and report.region_names:
        yield _regions(report)
    if report.decisions and report.region_names:
        table = decision_table(report.decisions, report.region_names)
        yield section("decisions", "Why it went there", _DECISIONS, table)
    yield list_section("events", "What changed", report.events)
    yield list_section("problems", "What went wrong", report.problems)
    yield list_section("limits", "What this page cannot tell", report.limits)
    if report.making is not None:
        yield _making(report.making)


def _opening(report: Report) -> Markup:
    """Say what happened."""
    parts = [element("h1", {}, report.title), element("p", {"class": "lead"}, report.sentence)]
    if report.took:
        parts.append(element("p", {"class": "measured"}, report.took))
    return element("header", {}, *parts)


def _results(table: Results) -> Markup:
    if not table.rows:
        return NOTHING
    head = [element("th", {"scope": "col"}, column) for column in table.columns]
    return element(
        "table",
        {"class": "results"},
        element("caption", {}, table.title),
        element("thead", {}, element("tr", {}, element("td", {}), *head)),
        element("tbody", {}, *[_result_row(row) for row in table.rows]),
    )


def _result_row(row: ResultRow) -> Markup:
    note = element("small", {}, row.note) if row.note else NOTHING
    values = [element("td", {}, value) for value in row.values]
    return element("tr", {}, element("th", {"scope": "row"}, row.name, note), *values)


def _curve(report: Report) -> Markup:
    chart = learning_curve(report.steps)
    if not chart:
        return NOTHING
    figure = element("figure", {"class": "curve"}, chart)
    return section("curve", "How it learned", _CURVE, figure)


def _map(report: Report) -> Markup:
    room = report.room_map
    plan = NOTHING if room is None else floor_plan(room, report.region_names)
    if room is None or not plan:
        return NOTHING
    text = (
        "The room from above. Each wedge is a look, from where the camera stood to where it "
        "pointed, in the colour of its region; a larger dot was looked from more often. Small "
        "ticks are the other views, the thin line joins the looks in their order. "
        f"Squares of {number(grid_of(room))} m."
    )
    if any(footprint.is_object for footprint in room.footprints):
        text += " Green outlines are objects."
    if report.region_note:
        text += f" {report.region_note}"
    figure = element("figure", {}, plan, region_key(report.region_names))
    return section("map", "Where it looked", text, figure)


def _regions(report: Report) -> Markup:
    window = min(window_of(len(report.steps)), len(report.steps))
    text = (
        f"Filled: the share of {window} frames that each region got, over the run. Line: "
        "learning progress, how fast the error falls there, cut off at the top. All strips have "
        "the same scale."
    )
    table = time_in_regions(report.steps, report.region_names)
    return section("regions", "Where the time went", text, table)


def _making(making: Making) -> Markup:
    parts = [element("pre", {}, element("code", {}, making.command))]
    if making.facts:
        parts.append(pairs(making.facts))
    if making.times_ms:
        parts.append(_times(making.times_ms))
    if making.files:
        parts += [element("h3", {}, "Beside this page"), pairs(making.files, is_code=True)]
    if making.settings:
        summary = element("summary", {}, "All settings")
        parts.append(element("details", {}, summary, element("pre", {}, making.settings)))
    return section("making", "How this was made", "", join(parts))


def _times(times_ms: Mapping[str, float]) -> Markup:
    """Return a bar for each stage."""
    longest = max(1e-9, *times_ms.values())
    rows = []
    for stage, spent in times_ms.items():
        bar = element("span", {"class": "bar", "style": f"width:{number(100 * spent / longest)}%"})
        name = element("th", {"scope": "row"}, stage)
        cells = element("td", {}, bar), element("td", {"class": "count"}, f"{spent:.1f}")
        rows.append(element("tr", {}, name, *cells))
    caption = element("caption", {}, "Milliseconds of each stage, per frame")
    return element("table", {"class": "times measured"}, caption, element("tbody", {}, *rows))
