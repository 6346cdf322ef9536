"""Put the page of a comparison together: figures, curves, maps, and how it was made."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from curiosight.errors.files import replace_file
from curiosight.viewing.comparison.charts import charts, pointing_style, reliability_chart
from curiosight.viewing.comparison.content import ComparisonReport
from curiosight.viewing.comparison.curve_styles import StyledMethod, styled
from curiosight.viewing.comparison.result_table import column_notes, result_table, sorting_script
from curiosight.viewing.comparison.tiles import wall
from curiosight.viewing.paper import HUES
from curiosight.viewing.report.document import document, list_section, pairs, section
from curiosight.viewing.report.markup import NOTHING, Markup, element, join

_TABLE = (
    "The best figure of a column is bold, the second best underlined. Below the AUC stands its "
    "95 % interval, from drawing frames with replacement."
)
_CURVES = (
    "Pooled over the pixels of all frames; beside the names stands the AUC. Point at a name, or "
    "at a row of the table, to see its curves alone."
)
_RELIABILITY = (
    "Of the pixels that were told a probability, the share that is salient, in 15 equal bins; on "
    "the diagonal probabilities hold. The error is their mean distance from it over all pixels "
    "(ECE)."
)
_WALL = (
    "Truth is white where an object is. Each map is shown as the method gives it, black 0 and "
    "white 1. Mistakes are those of the first map, cut at its threshold."
)


def write_comparison(report: ComparisonReport, path: Path | str) -> None:
    """Write the page, completely or not at all; raise `DataError` where that cannot be.

    The same report gives the same bytes.
    """
    # A path of Linux may hold bytes that are no text; they become question marks.
    replace_file(Path(path), comparison_html(report).encode("utf-8", "replace"))


def comparison_html(report: ComparisonReport) -> str:
    """Return the page: one file that asks for nothing from outside.

    Its only script sorts the table; without it the best AUC stands first.
    """
    drawn = styled(report.methods)
    style = files(__package__).joinpath("comparison.css").read_text("utf-8")
    return document(
        report.title,
        _sections(report, drawn),
        style=_hues() + style + pointing_style(len(drawn)),
        script=sorting_script() if drawn else "",
    )


def _sections(report: ComparisonReport, drawn: list[StyledMethod]) -> Iterator[Markup]:
    yield element(
        "header",
        {},
        element("h1", {}, report.title),
        element("p", {"class": "lead"}, report.sentence),
    )
    if drawn:
        table = join((result_table(drawn), column_notes(report.methods)))
        yield section("results", "In numbers", _TABLE, table)
    curves = charts(drawn)
    if curves:
        yield section("curves", "Curves", _CURVES, curves)
    if report.reliability:
        chart = reliability_chart(report.reliability)
        yield section("reliability", "Probabilities", _RELIABILITY, chart)
    if report.wall:
        yield section("wall", "Maps", _WALL, wall(report.wall))
    yield list_section("problems", "What went wrong", report.problems)
    yield list_section("limits", "What this comparison cannot tell", report.limits)
    yield _making(report)


def _making(report: ComparisonReport) -> Markup:
    parts = []
    if report.command:
        parts.append(element("pre", {}, element("code", {}, report.command)))
    if report.facts:
        parts.append(pairs(report.facts))
    if report.files:
        parts += [element("h3", {}, "Beside this page"), pairs(report.files, is_code=True)]
    return section("making", "How this was made", "", join(parts)) if parts else NOTHING


def _hues() -> str:
    """Return the colours of curves on light pages; the style has those of dark ones."""
    named = "".join(f"--hue-{place}:{hue};" for place, hue in enumerate(HUES))
    classes = "".join(f".hue-{place}{{--hue:var(--hue-{place})}}" for place in range(len(HUES)))
    return f":root{{{named}}}{classes}"
