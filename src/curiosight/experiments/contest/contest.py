"""A contest: which runs there are, which are done, and who does the others."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.errors.files import replace_file
from curiosight.experiments.components import choose_strategy
from curiosight.experiments.contest.backends import Workers
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.runs import RunRecord, read_run
from curiosight.experiments.contest.settings import ContestSettings, folder_name, read_settings
from curiosight.experiments.contest.tasks import PrepareTask, RunTask, Task
from curiosight.experiments.contest.whole import remove_partial
from curiosight.experiments.sole_writer import sole_writer
from curiosight.explorer import make_regions
from curiosight.frame import Viewpoint
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.worlds.sources import is_drawn, open_source

SETTINGS = "compare.toml"


def check_settings(settings: ContestSettings) -> None:
    """Open every source and make every strategy once, so that hours later nothing is refused.

    Raises ValueError or `DataError` for what cannot be compared.
    """
    for name in settings.strategies:
        config = settings.config_of(name)
        views = (Viewpoint(0, 0, np.eye(4)), Viewpoint(1, 0, np.eye(4)))
        rng = np.random.default_rng(0)
        choose_strategy(config, views, rng, lambda _, to: np.zeros(len(to)), trial=lambda _: 0.0)
    first: dict[str, str] = {}
    for source in settings.sources:
        same = first.setdefault(place_of(source), source)
        if same != source:
            raise ValueError(f"sources: expected each once, got {same!r} and {source!r}")
        dataset = open_source(place_of(source), reading=settings.config.reading)
        _check_source(source, dataset, settings)


def _check_source(source: str, dataset: Dataset, settings: ContestSettings) -> None:
    change = dataset.n_before_change if isinstance(dataset, DrawnViews) else None
    if change is not None and settings.n_looks <= change:
        name = "steps" if settings.seconds is None else "seconds"
        raise ValueError(f"{name}: expected more than the {change} looks before {source} changes")
    metres, places = np.zeros((len(dataset), len(dataset))), np.zeros(len(dataset), np.int64)
    specs = {settings.config_of(name).explorer.regions for name in settings.strategies}
    for spec in specs - {""}:  # which finds regions for any views
        make_regions(spec, dataset.poses, dataset.ids, metres=metres, places=places)


def place_of(source: str) -> str:
    """Return where a source is, from any folder."""
    return source if is_drawn(source) else str(Path(source).absolute())


class Contest:
    """A folder of prepared sources and runs, on its way to be whole.

    Iterate with workers to do what is missing; then `records` has everything.
    """

    def __init__(
        self, settings: ContestSettings, folder: Path, *, is_resumed: bool = False
    ) -> None:
        self.settings = settings
        self.folder = folder.absolute()
        self._is_resumed = is_resumed

    @classmethod
    def resumed(cls, folder: Path) -> Contest:
        """Return the contest of a folder."""
        return cls(read_settings(folder / SETTINGS), folder, is_resumed=True)

    @contextmanager
    def begun(self) -> Iterator[None]:
        """Have the folder to oneself, with what is compared written to it.

        What killed processes left half-written is removed, before and after. Raises `DataError`
        where another writes into the folder, or has begun a contest there meanwhile.
        """
        with sole_writer(self.folder):
            if not self._is_resumed and (self.folder / SETTINGS).exists():
                remedy = "choose another --out, or add --resume"
                raise DataError(self.folder, "has become another compare's", remedy)
            self._remove_partial()
            replace_file(self.folder / SETTINGS, self.settings.to_toml().encode(), is_synced=True)
            try:
                yield
            finally:
                self._remove_partial()

    def _remove_partial(self) -> None:
        places = [self.folder, self.folder / "prepared"]
        for place in [*places, *(self.folder / "runs").glob("*")]:
            remove_partial(place)

    @property
    def n_runs(self) -> int:
        """How many runs there are when all are done."""
        settings = self.settings
        return len(settings.sources) * len(settings.strategies) * settings.seeds

    def n_missing(self) -> int:
        """How many runs are not done yet."""
        return sum(len(self._missing_runs(source)) for source in self.settings.sources)

    def is_whole(self) -> bool:
        """Tell whether nothing is left to do."""
        return not self.n_missing() and all(map(self._is_prepared, self.settings.sources))

    def _is_prepared(self, source: str) -> bool:
        return self.prepared_folder(source).exists()

    def finished(self, workers: Workers, is_stopped: Callable[[], bool]) -> Iterator[Task]:
        """Have done what is missing; yield each task once it is."""
        for source in self.settings.sources:
            is_there = self._is_prepared(source)
            for task in self._missing_runs(source) if is_there else [self._preparation(source)]:
                workers.submit(task)
        for task in workers.finished(is_stopped):
            if isinstance(task, PrepareTask):
                for run in self._missing_runs(task.source):
                    workers.submit(run)
            yield task

    def prepared_folder(self, source: str) -> Path:
        return self.folder / "prepared" / folder_name(source)

    def run_folder(self, source: str, strategy: str, seed: int) -> Path:
        name = f"{folder_name(strategy)}-{seed}"
        return self.folder / "runs" / folder_name(source) / name

    def prepared(self, source: str) -> Prepared:
        """Return a source; raises `DataError` where its files are damaged."""
        return Prepared(self.prepared_folder(source))

    def records(self, source: str, strategy: str) -> list[RunRecord]:
        """Return the runs of a strategy, one a seed."""
        seeds = range(self.settings.seeds)
        return [read_run(self.run_folder(source, strategy, seed)) for seed in seeds]

    def _preparation(self, source: str) -> PrepareTask:
        config = self.settings.config_of(self.settings.strategies[0])
        folder = os.fspath(self.prepared_folder(source))
        return PrepareTask(source, place_of(source), folder, config)

    def _missing_runs(self, source: str) -> list[RunTask]:
        """Return the runs that are not done, seed by seed: an early look has all strategies."""
        settings = self.settings
        return [
            RunTask(
                source,
                strategy,
                seed,
                os.fspath(self.prepared_folder(source)),
                os.fspath(folder),
                settings.config_of(strategy),
                settings.n_looks,
                settings.seconds,
            )
            for seed in range(settings.seeds)
            for strategy in settings.strategies
            if not (folder := self.run_folder(source, strategy, seed)).exists()
        ]
