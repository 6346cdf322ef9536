"""Explore a recording: run the loop, keep everything it says (sec. III-B)."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, every_nth
from curiosight.experiments.components import (
    choose_regions,
    choose_strategy,
    count_learned,
    load_learner,
    make_learner,
    make_teacher,
    make_world,
    note_frames,
    place,
    survey_dataset,
)
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.problems import Problems
from curiosight.experiments.stopwatch import Stopwatch
from curiosight.experiments.truth import Truth, find_truth
from curiosight.explore import Step, explore
from curiosight.learner.archive import MODEL as MODEL
from curiosight.learner.archive import find_model
from curiosight.rooms.views import RoomViews
from curiosight.worlds import Odometer

N_ROOM_TEST_VIEWS = 40


@dataclass(frozen=True, slots=True)
class StepRow:
    """One line of steps.csv; travel is summed from the start."""

    step: int
    id: str
    region: int
    error: float | None
    learning_progress: float | None
    samples: int
    metres: float
    degrees: float
    overall_error: float | None


class Exploration:
    """One exploration of a recording or a room, written to a folder while it runs.

    test_source: another recording to test on, instead of the settings' `test.every`; a room
        is tested on views of its own unless either is given.
    continued: a model to go on with, see `load_run_model`; its features and forest replace
        those of the settings.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        *,
        test_source: Dataset | None = None,
        continued: Path | None = None,
    ) -> None:
        self.dataset = dataset
        self.out = out
        self.rows: list[StepRow] = []
        self.problems = Problems()
        self._continued = continued
        self._started = time.perf_counter()
        learner_rng, strategy_rng = np.random.default_rng(config.run.seed).spawn(2)
        if test_source is None and not config.test.every and isinstance(dataset, RoomViews):
            test_source = dataset.test_views(N_ROOM_TEST_VIEWS)
        training, test = _split(config, dataset, test_source)
        self.survey = survey_dataset(config, dataset)
        self.teacher = make_teacher(config, dataset, self.survey)
        self.regions = choose_regions(config, dataset, self.survey)
        if continued is None:
            self.learner = make_learner(config, self.teacher, learner_rng)
        else:
            self.learner, config = load_learner(continued, config, self.teacher, learner_rng)
        self.config = config
        self.world = make_world(config, dataset, self.regions, training)
        self._strategy = choose_strategy(config, tuple(self.world.views), strategy_rng)
        self.world.upcoming = self._strategy.upcoming
        self.truth = self._find_truth(test_source, test)
        self.n_learned = count_learned(self.learner, self.truth.dataset, self.truth.indices)
        self.test_problems = Problems()
        self.held_out = HeldOut(self.learner, self.truth.labelled_frames(self.test_problems))
        self.stopwatch = self._watch()
        self._odometer = Odometer()
        out.write_text("config.toml", to_toml(config))
        self._steps_file = TableFile(out.file("steps.csv"), [f.name for f in fields(StepRow)])
        self._times_file = TableFile(out.file("timings.csv"), ["step", *self.stopwatch.stages])

    def __iter__(self) -> Iterator[tuple[Step, StepRow]]:
        """Run the loop; yield each step and its row once both are on disk."""
        n_steps = self.config.explorer.n_steps
        for step in explore(self.world, self.learner, self._strategy, n_steps):
            row = self._note(step)
            self.rows.append(row)
            self._steps_file.add(asdict(row))
            self._times_file.add({"step": step.index, **self.stopwatch.lap()})
            yield step, row

    def finish(self) -> dict[str, Any]:
        """Write the model and the summary of what has been done so far; return the summary."""
        self._steps_file.close()
        self._times_file.close()
        self.world.close()
        note_frames(self.learner, self.dataset, {row.id for row in self.rows})
        self.learner.save(self.out.file(MODEL))
        summary = self._summary()
        self.out.write_json("summary.json", summary)
        return summary

    def _find_truth(self, test_source: Dataset | None, test: Sequence[int]) -> Truth:
        max_frames = self.config.test.max_frames
        if test_source is None:
            return find_truth(self.dataset, test, self.teacher, max_frames=max_frames)
        everything = range(len(test_source))
        has_truth = any(map(test_source.has_ground_truth, everything))
        if has_truth:
            return find_truth(test_source, everything, None, max_frames=max_frames)
        teacher = make_teacher(self.config, test_source)
        return find_truth(test_source, everything, teacher, max_frames=max_frames)

    def _watch(self) -> Stopwatch:
        stopwatch = Stopwatch()
        stopwatch.watch(self.world, "capture")
        for stage in ("describe", "segment", "predict", "learn"):
            stopwatch.watch(self.learner, stage)
        stopwatch.watch(self.held_out, "overall_error", "test")
        return stopwatch

    def _note(self, step: Step) -> StepRow:
        """Return the step's row; count what was wrong with its frame."""
        observation = step.observation
        self.problems.add(observation.frame, observation.segmentation.problem)
        self._odometer.add(step.viewpoint.T_world_camera)
        return StepRow(
            step=step.index,
            id=observation.frame.id,
            region=step.viewpoint.region,
            error=observation.error,
            learning_progress=step.learning_progress,
            samples=self.learner.forest.n_samples,
            metres=self._odometer.metres,
            degrees=self._odometer.degrees,
            overall_error=self.held_out.overall_error(observation.regrown),
        )

    def _summary(self) -> dict[str, Any]:
        last = self.rows[-1] if self.rows else None
        return {
            "source": place(self.dataset),
            "layout": self.dataset.name,
            "continued": str(self._continued) if self._continued else None,
            "strategy": self.config.explorer.strategy,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "regions": self.regions.kind,
            "scene": self.survey.scene,
            "steps": len(self.rows),
            "distinct_frames": len({row.id for row in self.rows}),
            "training_frames": len(self.world.views),
            "overall_error": last.overall_error if last else None,
            "tested_on": self.truth.kind,
            "test_source": place(self.truth.dataset) if self.truth.indices else None,
            "test_frames": self.held_out.n_frames,
            "samples": last.samples if last else 0,
            "metres": last.metres if last else 0.0,
            "degrees": last.degrees if last else 0.0,
            "problems": self.problems.counts(),
            "test_frames_learned": self.n_learned,
            "test_problems": self.test_problems.counts(),
            "stages": self.stopwatch.summary(),
            "seconds": round(time.perf_counter() - self._started, 2),
        }


def load_run_model(run: Path) -> Path:
    """Return the model file of a run's folder, or of the file itself."""
    if not run.exists():
        raise DataError(run, "does not exist", "give the folder of a run, or a model file")
    return find_model(run)


def _split(
    config: Config, dataset: Dataset, test_source: Dataset | None
) -> tuple[Sequence[int], Sequence[int]]:
    """Return the frames to learn from and to test on."""
    if config.test.every and test_source is None:
        training, test = every_nth(len(dataset), config.test.every, gap=config.test.gap)
        return training.tolist(), test.tolist()
    return range(len(dataset)), []
