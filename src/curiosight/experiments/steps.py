"""The tables that a run writes line by line: steps.csv, timings.csv, and how they are read back."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

from curiosight.errors import DataError

STEPS, TIMES = "steps.csv", "timings.csv"


@dataclass(frozen=True, slots=True)
class StepRow:
    """One line of steps.csv; travel is summed from the start.

    error, overall_error: of rows (superpixels), before maps follow edges; `Evaluation` scores maps.
    samples: in all forests; one may be in two.
    """

    step: int
    id: str
    region: int
    error: float | None
    learning_progress: float | None
    samples: int
    metres: float
    degrees: float
    overall_error: float | None


STEP_COLUMNS = tuple(field.name for field in fields(StepRow))


def read_steps(path: Path, n_steps: int | None = None) -> list[StepRow]:
    """Return the steps of a file, numbers with their six decimals; DataError for a damaged one.

    n_steps: the first so many; None = all.
    """
    try:
        return [
            StepRow(
                step=int(line["step"]),
                id=line["id"],
                region=int(line["region"]),
                error=_number(line["error"]),
                learning_progress=_number(line["learning_progress"]),
                samples=int(line["samples"]),
                metres=float(line["metres"]),
                degrees=float(line["degrees"]),
                overall_error=_number(line["overall_error"]),
            )
            for line in _lines(path, n_steps)
        ]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise DataError(path, f"is no table of steps ({error})", "give an undamaged run") from error


def read_times(path: Path, n_steps: int | None = None) -> list[dict[str, float]]:
    """Return the milliseconds of each stage in each step; DataError for a damaged file."""
    try:
        return [
            {stage: float(spent) for stage, spent in line.items() if stage != "step"}
            for line in _lines(path, n_steps)
        ]
    except (TypeError, ValueError, csv.Error) as error:
        raise DataError(path, f"is no table of times ({error})", "give an undamaged run") from error


def _lines(path: Path, n_lines: int | None) -> Iterator[dict[str, str]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            for number, line in enumerate(csv.DictReader(file)):
                if number == n_lines:
                    return
                yield line
    except OSError as error:
        found = f"cannot be read ({error.strerror})"
        raise DataError(path, found, "give the folder of a run") from error


def _number(cell: str) -> float | None:
    return float(cell) if cell else None
