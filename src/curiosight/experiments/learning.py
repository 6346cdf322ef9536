"""Learn a whole recording at once: the paper's off-line model, its lower bound of the error."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.components import (
    make_learner,
    make_teacher,
    note_frames,
    place,
    survey_dataset,
)
from curiosight.experiments.forgetting import Forgetting
from curiosight.experiments.place_tests import PlaceTests
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.snapshot import Snapshot
from curiosight.frame import Frame
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.lesson import Lesson
from curiosight.learner.observation import Teaches
from curiosight.teacher import Segmentation, Survey, TemporalTeacher

SPARE = 4
SO_FAR = 20_000


class OffLine:
    """The off-line model: each frame is sampled once, then every tree grows at once.

    A frame gives up to `learner.n_pixels` labelled pixels; fewer, all alike, where the frames
    together would give more than `SPARE` times what the buffer holds. Of those a uniformly
    random choice of `forest.max_samples` is kept. So every frame counts alike, and memory stays
    the same however long the recording is.

    A teacher that remembers is asked twice: what it could not know when it first saw a frame,
    later ones may have told.

    version: of curiosight, for the state that `keep` writes.
    is_tested: note how well places are known when the first look has left one; see `PlaceTests`.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        teacher: Teaches | None = None,
        version: str = "",
        is_tested: bool = False,
    ) -> None:
        self.config = config
        self.dataset = dataset
        self.teacher = teacher or make_teacher(config, dataset, self.survey)
        self.learner: SaliencyLearner = make_learner(config, self.teacher)
        spare = SPARE * config.forest.max_samples // len(dataset)
        self._n_pixels = max(1, min(config.learner.n_pixels, spare))
        self.problems = Problems()
        self.lessons = Lessons()
        self._lessons: dict[int, Lesson] = {}
        self.n_done = 0
        self._snapshot = Snapshot(version, dataset.ids, {})
        self._tests = PlaceTests(config, dataset) if is_tested else None
        self._left = Forgetting()

    @cached_property
    def survey(self) -> Survey:
        """What the frames of the recording share; not needed where a teacher is given."""
        return survey_dataset(self.config, self.dataset)

    @property
    def n_looks(self) -> int:
        """How many frames iterating over it yields."""
        return len(self.dataset) * (2 if self._remembering else 1)

    @property
    def _remembering(self) -> TemporalTeacher | None:
        """The teacher, if it is one that has something to remember of this recording."""
        teacher = self.learner.teacher
        is_posed = any(pose is not None for pose in self.dataset.poses)
        return teacher if is_posed and isinstance(teacher, TemporalTeacher) else None

    def __iter__(self) -> Iterator[Frame]:
        """Sample each frame; yield it when its samples are taken, see `n_looks`.

        n_done: of the looks, those that are behind it; it goes on with the next.
        """
        n_frames = len(self.dataset)
        for frame, segmentation in self._look(self.n_done):
            self.problems.add_told(frame, segmentation)
            self.lessons.add(frame, segmentation)
            self._note_place()
            yield frame
        if teacher := self._remembering:
            teacher.is_remembering = False
            try:
                yield from (frame for frame, _ in self._look(self.n_done - n_frames))
            finally:  # also where whoever iterates stops early
                teacher.is_remembering = True

    def _look(self, first: int) -> Iterator[tuple[Frame, Segmentation]]:
        """Sample each frame from one on, and yield it with what the teacher said."""
        indices = range(first, len(self.dataset))
        with Prefetch(self.dataset, memory_mb=self.config.run.memory_mb) as frames:
            for index, frame in zip(indices, frames.in_order(indices), strict=True):
                segmentation = self.learner.segment(frame)
                visit = self.learner.visit(frame, segmentation, self._n_pixels)
                self._lessons[index] = visit.lesson
                self.n_done += 1
                yield frame, segmentation

    def _note_place(self) -> None:
        """Keep how well a model of the frames so far knows all places once it has left one."""
        if self._tests is None or (place_of_frame := self._tests.place_of_frame) is None:
            return
        left = self._left.here
        if self._left.is_left(place_of_frame[self.n_done - 1]) and left is not None:
            errors = self._tests.errors(self.so_far(most=None))
            self._left.add(left, errors, self._tests.place_of_test)

    def _forgetting(self) -> dict[str, Any] | None:
        """Return what is left of each place; None where that cannot be told."""
        if self._tests is None or not self._left.qualities:
            return None
        errors = self._tests.errors(self.learner)
        return self._left.summary(errors, self._tests.place_of_test)

    def keep(self, path: Path) -> None:
        """Write all that it takes to go on in another process, see `go_on`."""
        teacher = self._remembering
        state = {
            "n_done": self.n_done,
            "lessons": self._lessons,
            "problems": self.problems,
            "told": self.lessons,
            "left": self._left,
            "learner": self.learner.learned(),
            "teacher": None if teacher is None else teacher.memory(),
        }
        self._snapshot.write(path, state)

    def go_on(self, path: Path) -> None:
        """Go on from what `keep` wrote, with the same settings; DataError for what does not fit."""
        state = self._snapshot.read(path)
        self.n_done, self._lessons = state["n_done"], state["lessons"]
        self.problems, self.lessons = state["problems"], state["told"]
        self._left = state["left"]
        self.learner.take_up(state["learner"])
        if (teacher := self._remembering) is not None:
            teacher.recall(state["teacher"])

    def fit(self, indices: Iterable[int] | None = None) -> SaliencyLearner:
        """Grow the trees on what was sampled from some frames, None = all so far.

        It is always the same model, which forgets what it knew. It stays untrained where the
        frames did not show both objects and what is none.
        """
        self._fit(self.learner, list(self._lessons if indices is None else indices))
        return self.learner

    def so_far(self, most: int | None = SO_FAR) -> SaliencyLearner:
        """Return a model of its own of the frames so far; what `fit` will return stays the same.

        most: samples of all, drawn at random; None = as many as `fit` takes. By `SO_FAR` of them,
        which a kill leaves behind, it takes some tenths of a second however long the recording is.
        """
        # The chance too is copied, and the forest is empty before the first fit: soon done.
        learner = make_learner(self.config, None)
        self._fit(learner, list(self._lessons), most)
        return learner

    def _fit(self, learner: SaliencyLearner, used: list[int], most: int | None = None) -> None:
        """Learn from at most so many samples of the frames `used`, and note those."""
        lessons = [self._lessons[index] for index in used]
        if not lessons:
            return
        n_samples = sum(len(lesson.rows) for lesson in lessons)
        step = 1 if most is None else max(1, -(-n_samples // most))
        # The samples of a frame are in random order.
        learner.fit(
            [
                Lesson(one.rows[::step], one.is_salient[::step], one.sight, one.share)
                for one in lessons
            ]
        )
        learner.cameras.note_all(self.learner.cameras)
        learner.notes.clear()
        note_frames(learner, self.dataset, [self.dataset.ids[index] for index in used])

    def summary(self) -> dict[str, Any]:
        """Return what was learned from, JSON-able."""
        return {
            "source": place(self.dataset),
            "layout": self.dataset.name,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "scene": self.survey.scene,
            "frames": len(self._lessons),
            "samples_drawn": sum(len(lesson.rows) for lesson in self._lessons.values()),
            "samples_kept": self.learner.n_samples,
            "places": self.learner.experts.n_views(),
            "forgetting": self._forgetting(),
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary(),
        }
