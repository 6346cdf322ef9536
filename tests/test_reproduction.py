"""docs/reproduction.md says of each claim what benchmarks/results/figures-claims.csv has."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from curiosight.experiments.contest.table import Curve
from curiosight.experiments.paper_figures.claims import Claim, claims_of_errors

ROOT = Path(__file__).parents[1]
# Columns of the table "What holds".
SOURCES = ("redkitchen", "room:21,views=100,path=orbit --regions time:5", "osd_learn")
VERDICT = r"(?:\*\*(yes|no)\*\*|(not clear))"
NUMBER = r"([−]?\d?\.\d{3})"
STATED = re.compile(rf"{VERDICT} {NUMBER}(?: \[{NUMBER}, {NUMBER}\])?")
# What a share says in words: so many of three methods, less a half.
NONE_OF_3 = ("no", "−.500", None, None)
NUMBERS = ("value", "low", "high")
Stated = tuple[str | None, ...]


def measured() -> list[dict[str, str]]:
    path = ROOT / "benchmarks" / "results" / "figures-claims.csv"
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def written(row: dict[str, str]) -> Stated:
    """Return a measured claim as the document writes it."""
    return (row["holds"], *(short(float(row[key]) if row[key] else None) for key in NUMBERS))


def short(number: float | None) -> str | None:
    """Return a number as the document writes it, with three digits and no 0 before the point."""
    if number is None:
        return None
    text = f"{number:.3f}".replace("0.", ".", 1).replace("-", "−")
    return ".000" if text == "−.000" else text


def of_kept_runs(preset: str) -> list[Claim]:
    """Return the claims of figure 6 that compare strategies, from runs that were kept before."""
    path = ROOT / "benchmarks" / "results" / f"strategies-{preset}.json"
    kept = json.loads(path.read_text(encoding="utf-8"))["curves"]
    curves = {name: [kept_curve(run["overall_error"]) for run in kept[name]] for name in kept}
    return claims_of_errors(curves, 0.1, None, seed=0)[2:]


def kept_curve(errors: list[float]) -> Curve:
    return Curve(np.array(errors), np.arange(1.0, 1 + len(errors)), np.zeros(len(errors)))


def document() -> str:
    return (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8")


def stated_in(cell: str) -> Stated | None:
    if cell == "**no**: none of 3":
        return NONE_OF_3
    found = STATED.match(cell)
    return None if found is None else parts(found)


def parts(found: re.Match[str]) -> Stated:
    """Return verdict, value, and both ends of the interval, None where there is none."""
    return (found[1] or found[2], found[3], found[4], found[5])


def table_rows() -> Iterator[list[str]]:
    """Yield the cells of the table, a row a claim, without its two lines of head."""
    text = document().partition("## What holds")[2]
    lines = [line for line in text.partition("\n\nIn ")[0].splitlines() if line.startswith("|")]
    for line in lines[2:]:
        yield [cell.strip() for cell in line.strip("|").split("|")]


def test_table_states_every_claim_as_it_was_measured() -> None:
    for column, source in enumerate(SOURCES, start=2):
        stated = [(cells[0], stated_in(cells[column])) for cells in table_rows()]
        expected = [(row["figure"], written(row)) for row in measured() if row["source"] == source]
        assert [one for one in stated if one[1] is not None] == expected, source
        assert len(expected) >= 10


def test_document_states_the_claims_of_other_sources() -> None:
    text = document()
    stated = [parts(found) for found in STATED.finditer(text.replace("\n", " "))]
    others = [row for row in measured() if row["source"] not in SOURCES]
    assert others
    for row in others:
        assert row["source"].partition(" ")[0] in text
        assert written(row) in stated, row


def test_document_states_the_claims_of_runs_kept_before() -> None:
    text = document().partition("The same claims of figure 6")[2].partition("Claims of the text")[0]
    stated = [parts(found) for found in STATED.finditer(text)]
    holds = {True: "yes", False: "no", None: "not clear"}
    both = zip(of_kept_runs("default"), of_kept_runs("paper"), strict=True)
    assert stated == [
        (holds[claim.holds], short(claim.value), short(claim.low), short(claim.high))
        for row in both
        for claim in row
    ]
    assert len(stated) == 6
