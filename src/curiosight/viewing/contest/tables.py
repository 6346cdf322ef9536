"""A contest as tables of text: of each source, and of all together."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

Table = Mapping[str, Any]
Cell = Callable[[Table], str]

MISSING = "–"


def whole(figure: Mapping[str, float | None]) -> str:
    """Write seconds, looks or metres with their interval: 1234 [1100, 1400]."""
    return _with_interval(figure, lambda value: f"{value:.0f}", ratio=False)


def share(figure: Mapping[str, float | None]) -> str:
    """Write a share or an error with its interval: .123 [.110, .140]."""
    return _with_interval(figure, _plain, ratio=False)


def ratio(figure: Mapping[str, float | None]) -> str:
    """Write how many times as much one takes as another: 0.31 [0.25, 0.40]."""
    return _with_interval(figure, lambda value: f"{value:.2f}", ratio=True)


def _with_interval(
    figure: Mapping[str, float | None], written: Callable[[float], str], *, ratio: bool
) -> str:
    middle, low, high = figure["ratio" if ratio else "mean"], figure["low"], figure["high"]
    if middle is None:
        return MISSING
    if low is None or high is None:
        return written(middle)
    return f"{written(middle)} [{written(low)}, {written(high)}]"


def reached(row: Table, level: int) -> str:
    """Write how many seeds got there."""
    return f"{row[f'reached_{level}']} of {row['n']}"


def cost(row: Table, unit: str, level: int) -> str:
    """Write what it took to get there; at least so much where not all seeds did: ≥ 1234."""
    bound = "" if row[f"reached_{level}"] == row["n"] else "≥ "
    return bound + whole(row[f"{unit}_to_{level}"])


COLUMNS: dict[str, Cell] = {
    "reached 90 %": lambda row: reached(row, 90),
    "seconds to 90 %": lambda row: cost(row, "seconds", 90),
    "looks to 90 %": lambda row: cost(row, "frames", 90),
    "metres to 90 %": lambda row: cost(row, "metres", 90),
    "reached 95 %": lambda row: reached(row, 95),
    "seconds to 95 %": lambda row: cost(row, "seconds", 95),
    "looks to 95 %": lambda row: cost(row, "frames", 95),
    "error over seconds": lambda row: share(row["area_seconds"]),
    "error over looks": lambda row: share(row["area_frames"]),
    "final error": lambda row: share(row["final_error"]),
    "spread": lambda row: _plain(row["spread"]),
}
# Of the leaderboard: title, unit, share of the F1.
BOARDS = (
    ("Seconds of the robot to 90 %", "seconds", 90),
    ("Looks to 90 %", "frames", 90),
    ("Seconds of the robot to 95 %", "seconds", 95),
)
# Only where there is such a thing.
RARE_COLUMNS: dict[str, tuple[str, Cell]] = {
    "back": ("back", lambda row: f"{row['back']} of {row['n']}"),
    "looks_until_back": ("looks until back", lambda row: whole(row["looks_until_back"])),
    "share_of_unlearnable_after_100": (
        "in the unlearnable room",
        lambda row: _rare_share(row["share_of_unlearnable_after_100"]),
    ),
}


def columns_of(table: Table) -> dict[str, Cell]:
    """Return the columns of a source's table by title."""
    first = next(iter(table["strategies"].values()))
    return COLUMNS | dict(column for key, column in RARE_COLUMNS.items() if key in first)


LEFT_COLUMNS = {
    "average_quality": "average at the end",
    "backward_transfer": "backward transfer",
    "forgetting": "forgetting",
}
PLACES_LEFT = (
    "Means over the seeds of the F1 of test frames, with their 95 % intervals and ± the standard "
    "deviation. A place is learned when a run first left it after ten looks there, or more. "
    "Average at the end: of all places that it saw. Backward transfer: of those that it had "
    "learned, at the end less when it had: below 0 what came later harmed it. Forgetting: when it "
    "was known best less at the end."
)
IN_ORDER = (
    "Row i: when the i-th place had been learned, column j: the j-th; runs learn them in orders of "
    "their own, and what not all of them learned is left out."
)


def has_places_left(table: Table) -> bool:
    """Tell whether a source's table says what is left of places."""
    return any(row.get("places_left") for row in table["strategies"].values())


def places_left_rows(table: Table) -> tuple[list[str], dict[str, list[str]]]:
    """Return columns, and rows by strategy, of what is left of the places of a source."""
    rows = {}
    for name in ranked(table):
        left, n = table["strategies"][name]["places_left"], table["strategies"][name]["n"]
        cells = [MISSING] * len(LEFT_COLUMNS)
        if left is not None:
            cells = [_with_deviation(left[key]) for key in LEFT_COLUMNS]
        rows[name] = [f"{0 if left is None else left['n']} of {n}", *cells]
    return ["runs that left a place", *LEFT_COLUMNS.values()], rows


def qualities_rows(table: Table, name: str) -> tuple[list[str], dict[str, list[str]]] | None:
    """Return columns and rows of a strategy's mean matrix; None where no run left a place."""
    left = table["strategies"][name]["places_left"]
    if left is None:
        return None
    titles = [f"place {number}" for number in range(1, len(left["qualities"]))]
    after = [*(f"after {title}" for title in titles), "at the end"]
    cells = [[f"{one:.2f}" for one in row] for row in left["qualities"]]
    return titles, dict(zip(after, cells, strict=True))


def _with_deviation(figure: Mapping[str, float | None]) -> str:
    deviation = figure["deviation"]
    return share(figure) if deviation is None else f"{share(figure)} ± {_plain(deviation)}"


def ranked(table: Table) -> list[str]:
    """Return the strategies of a source, the soonest at 90 % first, those never there last."""
    rows = table["strategies"]

    def place(name: str) -> tuple[bool, float]:
        return not rows[name]["reached_90"], float(rows[name]["seconds_to_90"]["mean"])

    return sorted(rows, key=place)


def markdown_tables(table: Table) -> str:
    """Return all of table.json in Markdown: each source's figures, and its ratios in pairs."""
    parts = ["# Strategies compared\n"]
    for source, of_source in table["sources"].items():
        names, columns = ranked(of_source), columns_of(of_source)
        rows = [
            [name, *(cell(of_source["strategies"][name]) for cell in columns.values())]
            for name in names
        ]
        ratios = [[a, *(_pair(of_source, a, b) for b in names)] for a in names]
        parts += [
            f"## {escaped(source)}\n",
            f"{offline_sentence(of_source)}\n",
            _markdown(["strategy", *columns], rows),
            "Seconds to 90 %, the row's by the column's, seeds drawn in pairs:\n",
            _markdown(["", *names], ratios),
            *_markdown_of_places(of_source),
        ]
    return "\n".join(parts)


def _markdown_of_places(table: Table) -> Iterator[str]:
    """Yield what is left of the places of a source; nothing where they are not known."""
    if not has_places_left(table):
        return
    columns, rows = places_left_rows(table)
    lines = [[name, *cells] for name, cells in rows.items()]
    yield f"### What is left of places\n\n{PLACES_LEFT}\n"
    yield _markdown(["strategy", *columns], lines)
    yield f"{IN_ORDER}\n"
    for name in rows:
        if (matrix := qualities_rows(table, name)) is not None:
            yield _markdown([name, *matrix[0]], [[row, *cells] for row, cells in matrix[1].items()])


def offline_sentence(table: Table) -> str:
    """Say what is waited for, and from when on it counts."""
    offline = table["offline"]
    text = f"Off-line model: error {offline['error']:.3f}, F1 {offline['f1']:.3f}."
    if "from_look" in table:
        text += f" All counts from its change on, after look {table['from_look']}."
    return text


def leaderboard(table: Table) -> str:
    """Return the strategies over all sources in Markdown, the fastest first, board by board.

    Ordered by the geometric mean over the sources of what each takes, by the least of its source;
    who never got there on some source comes after all who did, however short its runs are.
    """
    sources: Mapping[str, Table] = table["sources"]
    n_seeds = next(iter(next(iter(sources.values()))["strategies"].values()))["n"]
    parts = [
        "# Leaderboard\n",
        f"{len(sources)} sources, {n_seeds} {'seed' if n_seeds == 1 else 'seeds'} each. "
        "What it took to come to a share of the off-line model's F1: mean over seeds "
        "with its 95 % interval. A seed that never got there counts with its whole run, so that "
        "the figure is a lower bound (≥), and how many did stands behind. *By the best*: the "
        "geometric mean over the sources of what it took by the least of the source. Who never got "
        "there on some source comes last.\n",
        _markdown(
            ["source", "off-line F1", "fastest to 90 %"],
            [[name, f"{of['offline']['f1']:.3f}", _fastest(of)] for name, of in sources.items()],
        ),
    ]
    for title, unit, level in BOARDS:
        parts += [f"## {title}\n", _board(sources, unit, level)]
    return "\n".join(parts)


def _fastest(table: Table) -> str:
    best = ranked(table)[0]
    return best if table["strategies"][best]["reached_90"] else MISSING


def _board(sources: Mapping[str, Table], unit: str, level: int) -> str:
    """Return the table of one figure: a row a strategy, a column a source."""
    of_sources = list(sources.values())
    names = list(of_sources[0]["strategies"])

    scores = {name: _score(of_sources, name, unit, level) for name in names}

    def place(name: str) -> tuple[int, float]:
        return sum(not of["strategies"][name][f"reached_{level}"] for of in of_sources), scores[
            name
        ]

    rows = []
    for name in sorted(names, key=place):
        of_name = [of["strategies"][name] for of in of_sources]
        is_bound = any(row[f"reached_{level}"] < row["n"] for row in of_name)
        by_best = f"{'≥ ' if is_bound else ''}{scores[name]:.2f}"
        rows.append([name, by_best, *(_cost_and_reached(row, unit, level) for row in of_name)])
    return _markdown(["strategy", "by the best", *sources], rows)


def _score(sources: Sequence[Table], name: str, unit: str, level: int) -> float:
    """Return the geometric mean of what it took by the least that it took anybody who got there."""
    ratios = []
    for table in sources:
        rows = table["strategies"].values()
        there = [row for row in rows if row[f"reached_{level}"]] or rows
        least = min(row[f"{unit}_to_{level}"]["mean"] for row in there)
        ratios.append(table["strategies"][name][f"{unit}_to_{level}"]["mean"] / least)
    return float(np.exp(np.mean(np.log(ratios))))


def _cost_and_reached(row: Table, unit: str, level: int) -> str:
    is_whole = row[f"reached_{level}"] == row["n"]
    return cost(row, unit, level) + ("" if is_whole else f" ({reached(row, level)})")


def _pair(table: Table, a: str, b: str) -> str:
    return "" if a == b else ratio(table["pairs"][f"{a}/{b}"]["seconds_to_90"])


def _plain(value: float | None) -> str:
    return MISSING if value is None else f"{value:.3f}".removeprefix("0").replace("-0.", "-.")


def _rare_share(figure: Mapping[str, float | None] | None) -> str:
    return MISSING if figure is None else share(figure)


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    rule = [":--", *["--:"] * (len(head) - 1)]
    lines = [[escaped(cell) for cell in line] for line in (head, *rows)]
    lines.insert(1, rule)
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def escaped(text: str) -> str:
    """Return a text that Markdown shows as it is, also in a table."""
    return re.sub(r"([\\`*_{}<>#|~])", r"\\\1", " ".join(text.split()))
