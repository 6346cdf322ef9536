"""What a worker does, told in paths and plain settings, so that any worker can do it anywhere."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import cv2

from curiosight.config import Config
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.runs import write_run

# For a worker's environment, before it imports anything: runs are what is done side by side.
ONE_THREAD = dict.fromkeys(
    (
        "NUMBA_NUM_THREADS",
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
    ),
    "1",
)


@dataclass(frozen=True, slots=True)
class PrepareTask:
    """Describe and label a source into a folder.

    source: its name in the contest. place: where it is, from anywhere.
    """

    source: str
    place: str
    folder: str
    config: Config

    def __str__(self) -> str:
        return f"{self.source} prepared"


@dataclass(frozen=True, slots=True)
class RunTask:
    """Make one run on a prepared source into a folder.

    source, strategy: their names in the contest.
    """

    source: str
    strategy: str
    seed: int
    prepared: str
    folder: str
    config: Config
    n_looks: int
    max_seconds: float | None

    def __str__(self) -> str:
        return f"{self.source} {self.strategy} {self.seed}"


Task = PrepareTask | RunTask


def work(task: Task) -> float:
    """Do a task; return the seconds that it took.

    What is there already is not done again, and what is written is there whole or not at all:
    a task can be given to another worker at any time, and both may do it.
    """
    cv2.setNumThreads(1)
    begin = time.perf_counter()
    if isinstance(task, PrepareTask):
        prepare(task.place, task.config, Path(task.folder))
    else:
        prepared = Prepared(Path(task.prepared))
        write_run(
            Path(task.folder), prepared, task.config, task.seed, task.n_looks, task.max_seconds
        )
    return time.perf_counter() - begin
