"""Describe and label a source once, for all strategies and seeds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.datasets.places import known_places
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.experiments.components import (
    heard,
    make_learner,
    make_teacher,
    survey_dataset,
)
from curiosight.experiments.contest.prepared import (
    Prepared,
    Shown,
    ShownViews,
    keep_tables,
    new_table,
    save_array,
    write_meta,
    write_tests,
)
from curiosight.experiments.contest.whole import whole_folder
from curiosight.experiments.dividing import own_region_table
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import find_truth, noting_ids, split_or_every_nth
from curiosight.experiments.ways import ways_between
from curiosight.explorer.outcome import Seen
from curiosight.frame import Frame, Viewpoint
from curiosight.learner.observation import Teaches
from curiosight.rooms import HomeViews
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.rooms.home.settings import HomeSettings
from curiosight.teacher import Survey, TemporalTeacher
from curiosight.worlds.sources import open_source
from curiosight.worlds.travel import straight_ways

# Of a drawn view: each visit has its own noise, exposure and screens.
N_VISITS = 4


def prepare(source: str, config: Config, folder: Path) -> Prepared:
    """Return a source that is described and labelled, from disk where it is there.

    Raises as `open_source` and `survey_dataset`.
    """
    if not folder.is_dir() or not any(folder.iterdir()):
        with whole_folder(folder) as draft:
            Preparation(source, config, draft).write()
    return Prepared(folder)


def reach_and_tests(config: Config, dataset: Dataset) -> tuple[Sequence[int], Sequence[int]]:
    """Return the frames to learn from and those of the same recording to test on.

    What is drawn has views of its own to test on.
    """
    if isinstance(dataset, DrawnViews):
        return range(len(dataset)), []
    return split_or_every_nth(config, dataset)


class Preparation:
    """One source on its way to disk.

    What a view teaches does not depend on what was looked at before: its teacher has seen all of
    the source, as that of `learn` has. The off-line model learns the same labels.
    """

    def __init__(self, source: str, config: Config, folder: Path) -> None:
        self._source, self._config, self._folder = source, config, folder
        self._dataset: Dataset = open_source(source, reading=config.reading)
        self._survey: Survey = survey_dataset(config, self._dataset)
        self._learner = make_learner(config, None)
        self._teacher: Teaches

    def write(self) -> None:
        """Describe and label everything; the last file is that which says that all is there."""
        reachable, _ = self._split()
        phases = [self._write_phase(number, reachable) for number in range(self._n_phases)]
        self._write_ways(reachable)
        table = own_region_table(self._dataset)
        if table is not None:
            keep_tables(table, self._folder)
        up, ids = self._survey.up_world, [self._dataset.ids[index] for index in reachable]
        write_meta(
            self._folder,
            {
                "source": self._source,
                "visits": self._n_visits,
                "ids": ids,
                "places": self._places(self._dataset, ids),
                "knows_places": known_places(self._dataset) is not None,
                "unlearnable": self._unlearnable,
                "changed": self._changed,
                "up": None if up is None else np.asarray(up).tolist(),
                "phases": phases,
            },
        )

    @property
    def _drawn(self) -> DrawnViews | None:
        return self._dataset if isinstance(self._dataset, DrawnViews) else None

    @property
    def _n_visits(self) -> int:
        return 1 if self._drawn is None else N_VISITS

    @property
    def _n_phases(self) -> int:
        return 1 if self._drawn is None or self._drawn.n_before_change is None else 2

    @property
    def _unlearnable(self) -> int | None:
        """The number of the room that looks different at every look; None = there is none."""
        drawn = self._dataset
        if not isinstance(drawn, HomeViews) or not drawn.is_drawn_anew:
            return None
        return drawn.home.unlearnable

    @property
    def _changed(self) -> list[int] | None:
        """The rooms that are other after the change; None = all, or there is no change."""
        settings = None if self._drawn is None else self._drawn.settings
        change = settings.change if isinstance(settings, HomeSettings) else None
        return None if change is None or change.room is None else [change.room]

    def _first_look(self, phase: int) -> int:
        return 0 if not phase or self._drawn is None else self._drawn.n_before_change or 0

    def _split(self) -> tuple[Sequence[int], Sequence[int]]:
        return reach_and_tests(self._config, self._dataset)

    def _write_phase(self, number: int, reachable: Sequence[int]) -> dict[str, Any]:
        folder = self._folder / f"phase{number}"
        folder.mkdir()
        self._teacher = heard(self._config, make_teacher(self._config, self._dataset, self._survey))
        self._learner.teacher = self._teacher
        first_look = self._first_look(number)
        ShownViews(folder).write(list(self._show(reachable, first_look)))
        dataset, indices = self._dataset, self._split()[1]
        if self._drawn is not None:
            dataset = self._drawn.own_test_views(is_after=number > 0)
            indices = range(len(dataset))
        truth = find_truth(dataset, indices, self._teacher, max_frames=self._config.test.max_frames)
        ids: list[str] = []
        labelled = noting_ids(truth.labelled_frames(Problems()), ids)
        tests = list(describe_tests(self._learner, labelled))
        if not any(view.salient.any() for view in tests):
            found = "has no test frame with anything salient"
            raise DataError(Path(self._source), found, "compare strategies on another recording")
        write_tests(folder, tests)
        shown = ShownViews(folder)
        views = range(0, len(shown), self._n_visits)
        self._learner.fit([shown[index].visit.lesson for index in views])
        error = HeldOut(self._learner, tests).overall_error()
        assert error is not None
        return {
            "first_look": first_look,
            "test_places": self._places(dataset, ids),
            "offline": {"error": error, "f1": 1 - error},
        }

    def _show(self, reachable: Sequence[int], first_look: int) -> Iterator[Shown]:
        """Yield the visits of each view, one view after the other.

        A teacher that remembers has seen all views before, whatever a strategy will have seen.
        """
        if isinstance(self._teacher, TemporalTeacher):
            for index in reachable:
                self._teacher.segment(next(self._look(index, first_look, 1)))
            self._teacher.is_remembering = False
        for index in reachable:
            for visit, frame in enumerate(self._look(index, first_look, self._n_visits)):
                segmentation = self._teacher.segment(frame)
                # Of the visit alone, whatever was described before it.
                self._learner.rng = np.random.default_rng([first_look, index, visit])
                taught = self._learner.visit(frame, segmentation)
                yield Shown(taught, Seen.of(frame, segmentation.labels))

    def _look(self, index: int, first_look: int, n_visits: int) -> Iterator[Frame]:
        """Yield the first visits of a view."""
        if self._drawn is None:
            yield self._dataset[index]
            return
        number = (first_look * len(self._drawn) + index) * N_VISITS
        rngs = [self._drawn.visits_stream(number + visit) for visit in range(n_visits)]
        for look in self._drawn.visits(index, rngs, n_looks=first_look):
            yield look.frame

    def _write_ways(self, reachable: Sequence[int]) -> None:
        """Write how long the ways between all views are, and where those are."""
        poses = [self._dataset.poses[index] for index in reachable]
        views = [Viewpoint(number, 0, pose) for number, pose in enumerate(poses)]
        between = ways_between(self._dataset, reachable)
        # Row by row: of thousands of views there are gigabytes of them.
        metres, degrees = (
            new_table(self._folder / f"{name}.npy", len(views)) for name in ("metres", "degrees")
        )
        for number, view in enumerate(views):
            straight, degrees[number] = straight_ways(view, views)
            metres[number] = straight if between is None else between[number]
        if between is not None:
            _even_out(metres)
        unknown = np.full((4, 4), np.nan)
        known = np.array([unknown if pose is None else pose for pose in poses])
        save_array(self._folder / "poses.npy", known)

    def _places(self, dataset: Dataset, ids: Sequence[str]) -> list[int]:
        """Return the true room of each frame, -1 = not said; 0 where there is no such truth."""
        known = known_places(dataset) or (0,) * len(dataset)
        place_of = dict(zip(dataset.ids, known, strict=True))
        return [place_of[id] for id in ids]


def _even_out(metres: npt.NDArray[np.float64]) -> None:
    """Let (n, n) ways be as long there as back, which they are but for rounding; in place."""
    for number in range(len(metres)):
        there, back = metres[number, number:], metres[number:, number]
        there[:] = (there + back) / 2
        back[:] = there
