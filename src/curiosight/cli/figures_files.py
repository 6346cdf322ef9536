"""The files of the paper's figures: each drawn as SVG and PDF, with its numbers as CSV."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from curiosight.experiments.output import OutputFolder, TableFile

ENDINGS = ("svg", "pdf")
Row = Mapping[str, Any]


class CannotDrawError(Exception):
    """Why a source cannot give a figure, in a line."""


class FigureFiles:
    """The folder of the figures."""

    def __init__(self, folder: OutputFolder) -> None:
        self._folder = folder

    def save(self, number: int, draw: Callable[[Path], None], rows: Iterable[Row]) -> None:
        """Draw a figure in all its forms, and write its numbers, at least one row."""
        for ending in ENDINGS:
            draw(self._folder.file(f"figure-{number}.{ending}"))
        self.write_table(f"figure-{number}.csv", rows)

    def write_table(self, name: str, rows: Iterable[Row]) -> None:
        """Write rows, at least one, that have the same columns."""
        rows = iter(rows)
        first = next(rows)
        with closing(TableFile(self._folder.file(name), list(first))) as table:
            table.add(first)
            for row in rows:
                table.add(row)
