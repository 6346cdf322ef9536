"""Why it went there: a table of decisions between regions."""

from __future__ import annotations

from collections.abc import Sequence

from curiosight.explorer.decision import Candidate, Decision
from curiosight.viewing.report.markup import Markup, element, number

_COLUMNS = ("step", "went to", "way", "why", "next best")
_N_DIGITS = 3


def decision_table(decisions: Sequence[tuple[int, Decision]], names: Sequence[str]) -> Markup:
    """Return a table with a row for each decision; names: of the regions by their numbers."""
    head = [element("th", {"scope": "col"}, column) for column in _COLUMNS]
    rows = [_row(step, decision, names) for step, decision in decisions]
    return element(
        "table",
        {"class": "decisions"},
        element("thead", {}, element("tr", {}, *head)),
        element("tbody", {}, *rows),
    )


def _row(step: int, decision: Decision, names: Sequence[str]) -> Markup:
    chosen = next(one for one in decision.candidates if one.region == decision.chosen)
    others = [one for one in decision.candidates if one is not chosen]
    best = max(others, key=lambda one: one.score, default=None)
    cells = (
        names[chosen.region],
        f"{number(chosen.seconds, 0)} s",
        decision.text,
        "" if best is None else _told(best, names),
    )
    first = element("th", {"scope": "row"}, str(step))
    return element("tr", {}, first, *[element("td", {}, cell) for cell in cells])


def _told(one: Candidate, names: Sequence[str]) -> str:
    return f"{names[one.region]}, {number(one.seconds, 0)} s away ({one.score:.{_N_DIGITS}g})"
