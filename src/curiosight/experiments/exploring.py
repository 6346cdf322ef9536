"""Explore a recording: run the loop, keep everything it says (sec. III-B)."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.evaluation import HeldOut, describe_tests
from curiosight.experiments.components import (
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
from curiosight.experiments.deciding import DecisionsFile
from curiosight.experiments.dividing import choose_regions, graph_ways
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.stopwatch import Stopwatch
from curiosight.experiments.truth import LEAST_TO_LEARN as LEAST_TO_LEARN
from curiosight.experiments.truth import Truth, find_truth, split_frames
from curiosight.explore import Step, explore
from curiosight.explorer.strategies import check_loadable
from curiosight.frame import Viewpoint
from curiosight.learner.archive import MODEL as MODEL
from curiosight.learner.archive import find_model
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.worlds import Odometer
from curiosight.worlds.travel import travel_seconds

# Files that a run under way may find of an earlier one; others it replaces at its start.
DECISIONS = "decisions.csv"
RESULTS = (MODEL, "summary.json", DECISIONS)


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


class Exploration:
    """One exploration of a recording or a room, written to a folder while it runs.

    test_source: another recording to test on, instead of the settings' `test.every`. Where
        neither is given a room or home is tested on views of its own, after a change of the home
        on views as it is then, and a recording on its frames with
        ground truth; these and their neighbours (`test.gap`) are not learned from, unless that
        would leave too few others (`LEAST_TO_LEARN`).
    continued: a model to go on with, see `load_run_model`; its features and forest replace
        those of the settings.
    keeping: when the model is written while the run is under way; None = as `Keeping` does.
    leftovers: what an earlier run may have written to the folder beside `RESULTS`; removed when
        this one begins to write.
    is_test_asked: for by settings or `test_source`, or by the room.
    unused_truth: why the ground truth of the recording cannot be tested against, where it was
        not asked for; None = it can, or there is none.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        *,
        test_source: Dataset | None = None,
        continued: Path | None = None,
        keeping: Keeping | None = None,
        leftovers: Sequence[str] = (),
    ) -> None:
        check_loadable(config.explorer.strategy)
        self.dataset = dataset
        self.out = out
        self.rows: list[StepRow] = []
        self.problems = Problems()
        self.lessons = Lessons()
        self._n_regrown = 0
        self.unused_truth: str | None = None
        self._continued = continued
        self._started = time.perf_counter()
        learner_rng, strategy_rng = np.random.default_rng(config.run.seed).spawn(2)
        self._n_before_change: int | None = None
        if test_source is None and not config.test.every and isinstance(dataset, DrawnViews):
            test_source = dataset.own_test_views()
            self._n_before_change = dataset.n_before_change
        self.survey = survey_dataset(config, dataset)
        self.teacher = make_teacher(config, dataset, self.survey)
        self.regions = choose_regions(config, dataset, self.survey)
        if continued is None:
            self.learner = make_learner(config, self.teacher, learner_rng)
        else:
            self.learner, config = load_learner(continued, config, self.teacher, learner_rng)
        self.config = config
        training = self._choose_tests(test_source)
        self._graph_ways = graph_ways(self.regions, dataset.poses)
        self.world = make_world(config, dataset, self.regions, training, self._graph_ways)
        views = tuple(self.world.views)
        self._strategy = choose_strategy(config, views, strategy_rng, ways=self._seconds)
        self.world.upcoming = self._strategy.upcoming
        self.stopwatch = self._watch()
        self._odometer = Odometer()
        self._keeping = keeping or Keeping()
        self._remove_old(leftovers)
        out.write_text("config.toml", to_toml(config))
        self._steps_file = TableFile(out.file("steps.csv"), [f.name for f in fields(StepRow)])
        self._times_file = TableFile(out.file("timings.csv"), ["step", *self.stopwatch.stages])
        self.decisions = DecisionsFile(out.file(DECISIONS), self._strategy)

    def __iter__(self) -> Iterator[tuple[Step, StepRow]]:
        """Run the loop; yield each step and its row once both are on disk."""
        n_steps = self.config.explorer.n_steps
        try:
            for step in explore(self.world, self.learner, self._strategy, n_steps):
                row = self._note(step)
                self.rows.append(row)
                self._steps_file.add(asdict(row))
                self.decisions.add(step.index)
                self._times_file.add({"step": step.index, **self.stopwatch.lap()})
                self._keep()
                yield step, row
        finally:
            self._close()

    def finish(self) -> dict[str, Any]:
        """Write the model and the summary of what has been done so far; return the summary."""
        self._close()
        self._save(is_packed=True)
        summary = self._summary()
        self.out.write_json("summary.json", summary)
        return summary

    def _close(self) -> None:
        """End what runs beside the loop; may be called twice."""
        self._steps_file.close()
        self._times_file.close()
        self.decisions.close()
        self.world.close()

    def _seconds(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> npt.NDArray[np.float64]:
        if self._graph_ways is not None:
            return self._graph_ways(start, goals)
        return travel_seconds(*self.world.ways(start, goals))

    @property
    def n_learned(self) -> int:
        """How many of the test frames the model knows from learning, in this run or before."""
        return count_learned(self.learner, self.truth.dataset, self.truth.indices)

    @property
    def is_tested_on_learned(self) -> bool:
        """Tell whether frames that are tested on are within reach of learning."""
        views = {view.index for view in self.world.views}
        return self.truth.dataset is self.dataset and not views.isdisjoint(self.truth.indices)

    @property
    def has_learned(self) -> bool:
        """Tell whether the looks so far changed what the model says."""
        return self._n_regrown > 0

    def _keep(self) -> None:
        """Write the model if it is time to; where that fails the end of the run will say so."""
        if self._keeping.is_due():
            with self._keeping.writing(), suppress(DataError):
                self._save(is_packed=False)

    def _save(self, *, is_packed: bool) -> None:
        note_frames(self.learner, self.dataset, {row.id for row in self.rows})
        self.learner.save(self.out.file(MODEL), is_packed=is_packed)

    def _remove_old(self, leftovers: Sequence[str]) -> None:
        """Remove an earlier run's results, which would pass for this one's until it ends.

        The model that this run goes on with stays until there is a newer one.
        """
        names = {*RESULTS, *leftovers}
        model = self.out.path / MODEL
        if self._continued is not None and self._continued.resolve() == model.resolve():
            names.remove(MODEL)
            self.out.keep(MODEL)
        self.out.remove(sorted(names))

    def _choose_tests(self, test_source: Dataset | None) -> Sequence[int]:
        """Set up what is tested on, and return the frames to learn from."""
        self.is_test_asked = test_source is not None or self.config.test.every > 0
        training: Sequence[int] = range(len(self.dataset))
        test: Sequence[int] = []
        if test_source is None:
            reachable = np.array(self.regions.of_view) >= 0
            training, test = split_frames(self.config, self.dataset, reachable)
        truth = self._find_truth(test_source, test)
        try:
            self._test_on(truth)
        except DataError as error:
            if self.is_test_asked:
                raise
            self.unused_truth = error.found
            self._test_on(Truth("nothing", self.dataset, (), None))
            return range(len(self.dataset))
        return training

    def _test_on(self, truth: Truth) -> None:
        self.truth = truth
        self.test_problems = Problems()
        labelled = truth.labelled_frames(self.test_problems)
        self.held_out = HeldOut(self.learner, describe_tests(self.learner, labelled))

    def _test_after_change(self) -> None:
        """Go on with tests of what is drawn as it is after its change."""
        assert isinstance(self.dataset, DrawnViews)
        self._test_on(self._find_truth(self.dataset.own_test_views(is_after=True), ()))
        self.stopwatch.watch(self.held_out, "overall_error", "test")

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
        for method in ("describe", "segment", "vote", "learn"):
            stopwatch.watch(self.learner, method, "predict" if method == "vote" else method)
        stopwatch.watch(self.held_out, "overall_error", "test")
        return stopwatch

    def _note(self, step: Step) -> StepRow:
        """Return the step's row; count what was wrong with its frame."""
        observation = step.observation
        if step.index == self._n_before_change:
            self._test_after_change()
        self.problems.add_told(observation.frame, observation.segmentation)
        self.lessons.add(observation.frame, observation.segmentation)
        self._n_regrown += observation.change.n_regrown
        self._odometer.add(step.viewpoint.T_world_camera)
        return StepRow(
            step=step.index,
            id=observation.frame.id,
            region=step.viewpoint.region,
            error=observation.error,
            learning_progress=step.learning_progress,
            samples=self.learner.n_samples,
            metres=self._odometer.metres,
            degrees=self._odometer.degrees,
            overall_error=self.held_out.overall_error(observation.change),
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
            "frames_scored": self.held_out.n_frames,
            "frames_tested": self.held_out.n_given,
            "pooled_error": self.held_out.pooled_error(),
            "tested_on": self.truth.kind,
            "test_source": place(self.truth.dataset) if self.truth.indices else None,
            "test_frames": self.held_out.n_frames,
            "samples": last.samples if last else 0,
            "places": self.learner.experts.n_views(),
            "metres": last.metres if last else 0.0,
            "degrees": last.degrees if last else 0.0,
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary(),
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
