"""One run on disk: a small folder of what it looked at and how wrong the model was then."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.errors import DataError
from curiosight.errors.files import replace_file
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.running import LookRow, Run
from curiosight.experiments.contest.whole import whole_folder
from curiosight.experiments.output import TableFile, read_cell, write_json_file

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

RUN, LOOKS, ERRORS, TIMINGS = "run.json", "looks.csv", "errors.npy", "timings.json"


@dataclass(frozen=True, slots=True, eq=False)
class RunRecord:
    """A run as it was written.

    ids, regions: of each look. seconds, metres: (n_looks,) since the start, after each look.
    measured: (m,) looks after which the model was tested. errors: (m, n_tests) 1 - F1 of each
    test frame, NaN where it has none. region_names: what regions are called.
    """

    ids: list[str]
    regions: Ints
    seconds: Floats
    metres: Floats
    measured: Ints
    errors: Floats
    region_names: list[str]


def write_run(
    folder: Path,
    prepared: Prepared,
    config: Config,
    seed: int,
    n_looks: int,
    max_seconds: float | None = None,
) -> None:
    """Make a run and write its folder, whole or not at all; one that is there stays."""
    if folder.exists():
        return
    with whole_folder(folder) as draft:
        begin = time.perf_counter()
        run = Run(prepared, config, seed)
        looks = list(run.looks(n_looks, max_seconds))
        spent = time.perf_counter() - begin
        _write_looks(draft / LOOKS, looks)
        _write_errors(draft / ERRORS, [errors for _, errors in run.errors])
        summary = {
            "strategy": config.explorer.strategy,
            "seed": seed,
            **run.summary(),
            "looks": len(looks),
            "seconds": looks[-1].seconds,
            "metres": looks[-1].metres,
            "measured": [look for look, _ in run.errors],
        }
        write_json_file(draft / RUN, summary)
        write_json_file(draft / TIMINGS, {"seconds": spent, "ms_a_look": 1e3 * spent / len(looks)})


def read_run(folder: Path) -> RunRecord:
    """Read what `write_run` wrote; raises `DataError` where files were changed or lost."""
    try:
        summary: dict[str, Any] = json.loads((folder / RUN).read_text(encoding="utf-8"))
        with (folder / LOOKS).open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        record = RunRecord(
            [read_cell(row["id"]) for row in rows],
            np.array([int(row["region"]) for row in rows], np.int64),
            np.array([float(row["seconds"]) for row in rows]),
            np.array([float(row["metres"]) for row in rows]),
            np.array(summary["measured"], np.int64),
            np.load(folder / ERRORS, allow_pickle=False),
            list(summary["names"]),
        )
        if len(record.errors) != len(record.measured) or len(rows) != summary["looks"]:
            raise ValueError("its files do not belong together")
    except (OSError, ValueError, KeyError, TypeError) as error:
        remedy = "remove this folder, and --resume makes the run again"
        raise DataError(folder, f"is not a whole run ({error})", remedy) from error
    return record


def _write_looks(path: Path, looks: Sequence[LookRow]) -> None:
    table = TableFile(path, [field.name for field in fields(LookRow)])
    try:
        for look in looks:
            table.add(asdict(look))
    finally:
        table.close()


def _write_errors(path: Path, errors: Sequence[Floats]) -> None:
    """Write rows of as many tests as the longest has, the others with NaN at their ends."""
    table = np.full((len(errors), max(map(len, errors))), np.nan)
    for row, given in zip(table, errors, strict=True):
        row[: len(given)] = given
    content = io.BytesIO()
    np.save(content, table, allow_pickle=False)
    replace_file(path, content.getvalue())
