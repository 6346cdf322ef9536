"""Learn places one after the other: what of the first is left after the last?"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.experiments.components import (
    heard,
    make_learner,
    make_teacher,
    note_frames,
    place,
    survey_dataset,
)
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.transfer import Matrix, rounded, transfer
from curiosight.experiments.truth import find_truth_of_all, split_or_every_nth
from curiosight.frame import Frame
from curiosight.learner.drift import Event
from curiosight.learner.observation import Teaches
from curiosight.rooms import HomeViews
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.worlds.sources import is_drawn, open_source


@dataclass(frozen=True, slots=True, eq=False)
class Episode:
    """What is learned in one go, and what tells how well it is known.

    training, tests: numbers of frames of `dataset` and of `test_set`. change: of what is known by
    then, in words; "" = none, so that an alarm is a false one; None = that is not known.
    """

    name: str
    dataset: Dataset
    training: Sequence[int]
    test_set: Dataset
    tests: Sequence[int]
    change: str | None = None


@dataclass(frozen=True, slots=True)
class Alarmed:
    """A place was no longer what had been learned of it. event: its look is from 0, over all."""

    episode: int
    look_in_episode: int
    event: Event

    def summary(self) -> dict[str, Any]:
        """Return it, JSON-able."""
        inside = {"episode": self.episode, "look_in_episode": self.look_in_episode}
        return inside | self.event.summary()


class Continual:
    """Learn episodes in turn, each frame once; test on all of them after each.

    model: tells the file that the model is written to after each episode.
    qualities: (n_episodes, n_episodes) of 1 - overall error (the mean F1 of test frames): row i
        after episode i, column j on the tests of episode j; NaN = not yet, or no test frame
        shows anything salient.
    """

    def __init__(
        self, config: Config, episodes: Sequence[Episode], model: Callable[[], Path]
    ) -> None:
        self.config, self.episodes = config, episodes
        self.learner = make_learner(config, None)
        self.problems, self.lessons = Problems(), Lessons()
        self.alarms: list[Alarmed] = []
        self.n_looks = 0
        self._model = model
        self._teachers: dict[int, Teaches] = {}
        self._tests = [self._describe(episode) for episode in episodes]
        n = len(episodes)
        self.qualities: Matrix = np.full((n, n), np.nan)

    def __len__(self) -> int:
        """Count the looks."""
        return sum(len(episode.training) for episode in self.episodes)

    def __iter__(self) -> Iterator[tuple[int, Frame]]:
        """Yield each frame with its episode's number; after each episode the model is written."""
        for number, episode in enumerate(self.episodes):
            self.learner.teacher = self._teacher_of(episode.dataset)
            with Prefetch(episode.dataset, memory_mb=self.config.run.memory_mb) as frames:
                for look, frame in enumerate(frames.in_order(episode.training)):
                    observation = self.learner.observe(frame)
                    self.problems.add_told(frame, observation.segmentation)
                    self.lessons.add(frame, observation.segmentation)
                    if (alarm := observation.change.alarm) is not None:
                        event = Event(self.n_looks, frame.id, alarm)
                        self.alarms.append(Alarmed(number, look, event))
                    self.n_looks += 1
                    yield number, frame
            self._test(number)
            self._keep(episode)

    def _test(self, number: int) -> None:
        for column, tests in enumerate(self._tests):
            error = tests.overall_error()
            self.qualities[number, column] = np.nan if error is None else 1 - error

    def _keep(self, episode: Episode) -> None:
        ids = [episode.dataset.ids[index] for index in episode.training]
        note_frames(self.learner, episode.dataset, ids)
        self.learner.save(self._model())

    def _teacher_of(self, dataset: Dataset) -> Teaches:
        """Return what labels the frames of a source; it remembers from one episode to the next."""
        if id(dataset) not in self._teachers:
            survey = survey_dataset(self.config, dataset)
            teacher = make_teacher(self.config, dataset, survey)
            self._teachers[id(dataset)] = heard(self.config, teacher)
        return self._teachers[id(dataset)]

    def _describe(self, episode: Episode) -> HeldOut:
        test_set = episode.test_set
        truth = find_truth_of_all(
            test_set,
            episode.tests,
            lambda: self._teacher_of(test_set),
            max_frames=self.config.test.max_frames,
        )
        labelled = truth.labelled_frames(Problems())
        held_out = HeldOut(self.learner, describe_tests(self.learner, labelled))
        if not held_out.n_frames:
            found = f"has no test frame with anything salient ({episode.name})"
            raise DataError(Path(place(test_set)), found, "choose another source")
        return held_out

    def changes(self) -> list[dict[str, Any]]:
        """Return of each episode whose change is known how it was noticed, JSON-able.

        frames_until_alarm: looks of the episode up to and with its first alarm; None = none came.
        false_alarms: those of an episode without any change.
        """
        changes = []
        for number, episode in enumerate(self.episodes):
            alarms = [alarm for alarm in self.alarms if alarm.episode == number]
            if episode.change is None:
                continue
            is_changed = bool(episode.change) and bool(alarms)
            first = alarms[0] if is_changed else None
            changes.append(
                {
                    "episode": episode.name,
                    "change": episode.change,
                    "looks": len(episode.training),
                    "alarms": len(alarms),
                    "frames_until_alarm": None if first is None else 1 + first.look_in_episode,
                    "reason": None if first is None else first.event.alarm.reason,
                    "false_alarms": 0 if episode.change else len(alarms),
                }
            )
        return changes

    def summary(self) -> dict[str, Any]:
        """Return what was learned and what was left of it, JSON-able."""
        return {
            "episodes": [episode.name for episode in self.episodes],
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "looks": self.n_looks,
            "qualities": [[rounded(q) for q in row] for row in self.qualities.tolist()],
            **transfer(self.qualities),
            "alarms": [alarm.summary() for alarm in self.alarms],
            "changes": self.changes(),
            "places": self.learner.experts.n_views(),
            "samples": self.learner.n_samples,
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary(),
        }


def episodes_of(sources: Sequence[str], config: Config) -> list[Episode]:
    """Return the episodes of several sources, one each, or of one home a room each.

    What is drawn is tested on views of its own, a recording on its frames with ground truth or,
    without any, on every tenth. Raises as `open_source`, and ValueError for a single source that
    has no rooms.
    """
    opened = [open_source(source, reading=config.reading) for source in sources]
    if len(opened) > 1:
        short = [source if is_drawn(source) else Path(source).name for source in sources]
        names = short if len(set(short)) == len(short) else sources
        return [_whole(name, one, config) for name, one in zip(names, opened, strict=True)]
    (dataset,) = opened
    if not isinstance(dataset, HomeViews) or dataset.home.n_rooms < 2:
        raise ValueError("sources: expected a home of several rooms, or several sources, got one")
    test_set = dataset.own_test_views()
    rooms_of = [[views.place(i) for i in range(len(views))] for views in (dataset, test_set)]
    return [
        Episode(
            f"room {room}",
            dataset,
            np.flatnonzero(np.array(rooms_of[0]) == room).tolist(),
            test_set,
            np.flatnonzero(np.array(rooms_of[1]) == room).tolist(),
        )
        for room in range(dataset.home.n_rooms)
    ]


def _whole(name: str, dataset: Dataset, config: Config) -> Episode:
    if isinstance(dataset, DrawnViews):
        test_set = dataset.own_test_views()
        return Episode(name, dataset, range(len(dataset)), test_set, range(len(test_set)))
    training, tests = split_or_every_nth(config, dataset)
    return Episode(name, dataset, training, dataset, tests)
