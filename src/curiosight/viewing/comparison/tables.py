"""The comparison as a table to paste into a page or a paper.

Times are left out: everything else is the same whenever it is made again.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from curiosight.viewing.comparison.content import MAIN_KEY, Column, MethodResult
from curiosight.viewing.comparison.standings import (
    Leaders,
    known_columns,
    leaders,
    ranked,
    with_direction,
    written,
    written_interval,
)

Emphasis = Callable[[str, Leaders], str]

_LATEX_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "²": r"\textsuperscript{2}",
    "–": "--",
    "[": "{[}",  # after the end of a line it would be an option
} | {sign: f"\\{sign}" for sign in "&%$#_{}"}


def markdown_table(methods: Sequence[MethodResult]) -> str:
    """Return the table in Markdown, the best AUC first: the best figure bold, ours in italics."""
    columns = _lasting_columns(methods)
    lines = [["method", *[with_direction(column, column.title) for column in columns]]]
    for name, method in _named(methods, _markdown_escaped, "*{}*"):
        lines.append([name, *_cells(methods, method, columns, _in_markdown)])
    widths = [max(3, *map(len, cells)) for cells in zip(*lines, strict=True)]
    rule = [":" + "-" * (widths[0] - 1), *["-" * (width - 1) + ":" for width in widths[1:]]]
    lines.insert(1, rule)
    rows = (_padded(line, widths) for line in lines)
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def latex_table(methods: Sequence[MethodResult]) -> str:
    """Return the table in LaTeX, the best AUC first; it needs the package booktabs.

    The best figure of a column is bold, the second underlined, ours in italics.
    """
    columns = _lasting_columns(methods)
    titles = ["Method"]
    for column in columns:
        arrow = r"\downarrow" if column.is_lower_better else r"\uparrow"
        titles.append(f"{column.latex_title or _latex_escaped(column.title)} ${arrow}$")
    rows = [
        [name, *_cells(methods, method, columns, _in_latex)]
        for name, method in _named(methods, _latex_escaped, r"\emph{{{}}}")
    ]
    return "\n".join(
        [
            "% Needs \\usepackage{booktabs}. Bold: best; underlined: second; italics: ours.",
            f"\\begin{{tabular}}{{l{'c' * len(columns)}}}",
            r"\toprule",
            " & ".join(titles) + r" \\",
            r"\midrule",
            *[" & ".join(row) + r" \\" for row in rows],
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def _lasting_columns(methods: Sequence[MethodResult]) -> list[Column]:
    """Return the columns that do not change from run to run."""
    return [column for column in known_columns(methods) if column.key != "ms"]


def _named(
    methods: Sequence[MethodResult], escaped: Callable[[str], str], marked: str
) -> list[tuple[str, MethodResult]]:
    """Return the methods in order, each with its name as it is written; ours are marked."""
    return [
        (marked.format(escaped(method.name)) if method.is_ours else escaped(method.name), method)
        for method in ranked(methods)
    ]


def _cells(
    methods: Sequence[MethodResult],
    method: MethodResult,
    columns: Sequence[Column],
    emphasised: Emphasis,
) -> list[str]:
    """Return a method's figures; its AUC with the interval."""
    cells = []
    for column in columns:
        cell = emphasised(written(method.figure(column), column), leaders(methods, column))
        interval = written_interval(method, column) if column.key == MAIN_KEY else ""
        cells.append(f"{cell} {interval}".rstrip())
    return cells


def _in_markdown(figure: str, of_column: Leaders) -> str:
    return f"**{figure}**" if figure == of_column.best else figure


def _in_latex(figure: str, of_column: Leaders) -> str:
    if figure == of_column.best:
        return rf"\textbf{{{figure}}}"
    if figure == of_column.second:
        return rf"\underline{{{figure}}}"
    return _latex_escaped(figure)


def _markdown_escaped(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", " ".join(text.split()))


def _latex_escaped(text: str) -> str:
    return "".join(_LATEX_ESCAPES.get(sign, sign) for sign in " ".join(text.split()))


def _padded(line: Sequence[str], widths: Sequence[int]) -> list[str]:
    """Align the names on the left and the figures on the right."""
    name, *figures = line
    return [name.ljust(widths[0])] + [
        figure.rjust(width) for figure, width in zip(figures, widths[1:], strict=True)
    ]
