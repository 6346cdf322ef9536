"""Tell in a report what is left of each place that a run went through."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from curiosight.viewing.report import ResultRow, Results


def forgetting_tables(summary: dict[str, Any] | None) -> Iterator[Results]:
    """Yield the matrix of qualities and its sums; nothing where places are not known.

    summary: what `Forgetting.summary` returned.
    """
    if summary is None:
        return
    names = [f"place {place}" for place in summary["tested_on"]]
    after = [*(f"after place {place}" for place in summary["after"]), "at the end"]
    rows = [
        ResultRow(name, tuple("" if one is None else f"{one:.2f}" for one in row))
        for name, row in zip(after, summary["qualities"], strict=True)
    ]
    yield Results("How well each place is known, F1 of its test frames", tuple(names), tuple(rows))
    told = {
        "average_quality": ("average", "of all places at the end"),
        "backward_transfer": (
            "backward transfer",
            "at the end less when it had been learned: below 0 what came later harmed it",
        ),
        "forgetting": ("forgetting", "when it was known best less at the end"),
    }
    sums = [
        ResultRow(
            name,
            (f"{summary[key]:+.2f}" if key == "backward_transfer" else f"{summary[key]:.2f}",),
            note,
        )
        for key, (name, note) in told.items()
    ]
    yield Results("What is left of places", ("F1",), tuple(sums))
