"""Explore a recording: run the loop, keep everything it says (sec. III-B)."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.datasets.places import known_places
from curiosight.errors import DataError
from curiosight.experiments.command_file import COMMAND, GivenCommand
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
from curiosight.experiments.dividing import choose_regions, graph_ways
from curiosight.experiments.exploration_tests import ExplorationTests
from curiosight.experiments.handing_on import Continued, HandedOn, Rooms, own_regions
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.run_snapshot import run_snapshot
from curiosight.experiments.snapshot import STATE
from curiosight.experiments.so_far import SoFar
from curiosight.experiments.steps import STEPS, TIMES, StepRow, read_steps, read_times
from curiosight.experiments.stopwatch import Stopwatch, summarise
from curiosight.experiments.tables import DECISIONS as DECISIONS
from curiosight.experiments.tables import Tables
from curiosight.experiments.truth import LEAST_TO_LEARN as LEAST_TO_LEARN
from curiosight.explore import Step, explore
from curiosight.explorer import Regions
from curiosight.explorer.decision import Decision
from curiosight.explorer.strategies import check_loadable
from curiosight.frame import Frame, Viewpoint
from curiosight.learner.archive import MODEL as MODEL
from curiosight.learner.archive import find_model
from curiosight.learner.experts import Change
from curiosight.teacher import Segmentation, TemporalTeacher
from curiosight.worlds.travel import travel_seconds

# Files that a run under way may find of an earlier one; others it replaces at its start.
CONFIG, SUMMARY, TIMINGS = "config.toml", "summary.json", "timings.json"
RESULTS = (MODEL, SUMMARY, TIMINGS, STATE, DECISIONS)
# By these a run is known; they go first where another takes the folder.
MAKING = (COMMAND, CONFIG, STEPS, TIMES)
Mode = Literal["new", "resumed", "told"]


class Exploration:
    """One exploration of a recording or a room, written to a folder while it runs.

    test_source: see `ExplorationTests`.
    continued: a model to go on with, see `load_run_model`; its features and forest replace
        those of the settings.
    keeping: when the model is written while the run is under way; None = as `Keeping` does.
    leftovers: what an earlier run may have written to the folder beside `RESULTS`; removed when
        this one begins to write.
    given: the command that it can be gone on with by; None = no state is kept for that.
    mode: "resumed" goes on where a kill or Ctrl-C ended the run of this folder, made with the
        same arguments; "told" only reads what that has come to, and writes nothing.
    unkept: why its state cannot be kept, so that to go on is to begin anew; None = it can.
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
        given: GivenCommand | None = None,
        mode: Mode = "new",
    ) -> None:
        check_loadable(config.explorer.strategy)
        self.dataset = dataset
        self.out = out
        self.so_far = SoFar()
        self.unkept: str | None = None
        self._continued = continued
        self._given = given
        self._is_kept = mode != "new" and (out.path / STATE).is_file()
        self._started = time.perf_counter()
        learner_rng, strategy_rng = np.random.default_rng(config.run.seed).spawn(2)
        self.survey = survey_dataset(config, dataset)
        self.teacher = make_teacher(config, dataset, self.survey)
        version = "" if given is None else given.version
        self.continued: Continued | None = None
        if continued is not None and not self._is_kept:
            self.continued = Continued(continued, config, dataset, version)
        self.regions = self._known_regions() or choose_regions(config, dataset, self.survey)
        if continued is None or self._is_kept:
            self.learner = make_learner(config, self.teacher, learner_rng)
        else:
            self.learner, config = load_learner(continued, config, self.teacher, learner_rng)
        self.config = config
        reachable = np.array(self.regions.of_view) >= 0
        self.tests = ExplorationTests(
            config, dataset, self.learner, self.teacher, reachable, test_source
        )
        # Tests of a home that changes are of two homes.
        changes = self.tests.n_before_change is not None
        self._place_of_view = None if changes else known_places(dataset)
        self._graph_ways = graph_ways(self.regions, dataset.poses)
        self.world = make_world(
            config, dataset, self.regions, self.tests.training, self._graph_ways
        )
        views = tuple(self.world.views)
        ways = self._seconds
        self._strategy = choose_strategy(config, views, strategy_rng, ways=ways)
        self.stopwatch = self._watch()
        self._keeping = keeping or Keeping()
        self._rooms = Rooms.of(config, dataset, self.regions)
        self._snapshot = run_snapshot(
            config, given, dataset.ids, self.learner, self.world.views, self.world.views, ways
        )
        self.last_decisions: Sequence[tuple[int, Decision]] = ()
        if self.continued is not None:
            self.continued.tell(self._strategy, views, ways)
            self.continued.remember(self._remembering)
        sizes = self._take_up() if self._is_kept else None
        self.world.upcoming = self._strategy.upcoming
        if mode != "told":
            self._make_room(leftovers, is_new=mode == "new")
            stages, last = self.stopwatch.stages, self.last_decisions
            self._tables = Tables(out, self._strategy, stages, n_kept=sizes, last=last)
            self.last_decisions = self._tables.last_decisions
        if mode == "new":
            self._write_beginning()

    def __iter__(self) -> Iterator[tuple[Step, StepRow]]:
        """Run the loop; yield each step and its row once both are on disk."""
        n_steps, n_done = self.config.explorer.n_steps, self.so_far.n_steps
        steps = explore(self.world, self.learner, self._strategy, n_steps, n_done=n_done)
        try:
            for step in steps:
                row = self._note(step)
                self._tables.add(row, self.stopwatch.lap())
                self.so_far.n_steps = step.index + 1
                self._keep()
                yield step, row
        finally:
            self._close()

    def finish(self) -> dict[str, Any]:
        """Write the model and the summary of what has been done so far; return the summary.

        And the times. Of a run that is not at its end all is kept that it takes to go on, of
        one that is, what a report tells.
        """
        self._close()
        self._keep_state()
        self._save(is_packed=True)
        summary = self.summary()
        self.out.write_json(SUMMARY, summary)
        self._note_time()
        self.out.write_json(TIMINGS, self.times())
        if not self.is_under_way:
            self._keep_state(is_done=True)
        return summary

    @property
    def given(self) -> GivenCommand:
        """The command that the run can be gone on with by; ValueError where there is none."""
        if self._given is None:
            raise ValueError("given: expected a command, got None")
        return self._given

    def segment_again(self, frame: Frame) -> Segmentation:
        """Return what the teacher says now of a frame that the run has seen; nothing is noted."""
        if (teacher := self._remembering) is None:
            return self.teacher.segment(frame)
        teacher.is_remembering = False
        try:
            return teacher.segment(frame)
        finally:
            teacher.is_remembering = True

    @property
    def is_under_way(self) -> bool:
        """Tell whether the run is not at its end; `summary` is then of what it has come to."""
        return self.so_far.n_steps < self.config.explorer.n_steps

    @property
    def rows(self) -> list[StepRow]:
        """The steps so far, read back from steps.csv."""
        return read_steps(self.out.path / STEPS, self.so_far.n_steps)

    @property
    def problems(self) -> Problems:
        return self.so_far.problems

    @property
    def lessons(self) -> Lessons:
        return self.so_far.lessons

    @property
    def is_other_than_before(self) -> bool:
        """Tell whether steps that were done again came out otherwise than they stood there."""
        return self._tables.is_other_than_before

    def times(self) -> dict[str, Any]:
        """Return what the clock told: seconds until it was last kept, ms per stage, JSON-able."""
        laps = read_times(self.out.path / TIMES, self.so_far.n_steps)
        return {
            "seconds": round(self.so_far.seconds, 2),
            "stages": summarise(laps) if laps else {},
        }

    def _close(self) -> None:
        """End what runs beside the loop; may be called twice."""
        self._tables.close()
        self.world.close()

    def _seconds(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> npt.NDArray[np.float64]:
        if self._graph_ways is not None:
            return self._graph_ways(start, goals)
        return travel_seconds(*self.world.ways(start, goals))

    @property
    def n_learned(self) -> int:
        """How many of the test frames the model knows from learning, in this run or before."""
        truth = self.tests.truth
        return count_learned(self.learner, truth.dataset, truth.indices)

    @property
    def is_tested_on_learned(self) -> bool:
        """Tell whether frames that are tested on are within reach of learning."""
        views, truth = {view.index for view in self.world.views}, self.tests.truth
        return truth.dataset is self.dataset and not views.isdisjoint(truth.indices)

    @property
    def has_learned(self) -> bool:
        """Tell whether the looks so far changed what the model says."""
        return self.so_far.n_regrown > 0

    def _keep(self) -> None:
        """Write the model if it is time to; where that fails the end of the run will say so."""
        if self._keeping.is_due():
            with self._keeping.writing(), suppress(DataError):
                self._keep_state()
                self._save(is_packed=False)

    def _save(self, *, is_packed: bool) -> None:
        note_frames(self.learner, self.dataset, self.so_far.ids)
        self.learner.save(self.out.file(MODEL), is_packed=is_packed)

    def _make_room(self, leftovers: Sequence[str], *, is_new: bool) -> None:
        """Remove an earlier run's results, which would pass for this one's until it ends.

        The model that this run goes on with stays until there is a newer one.
        """
        names = {*RESULTS, *leftovers}
        model = self.out.path / MODEL
        if self._continued is not None and self._continued.resolve() == model.resolve():
            names -= {MODEL, STATE}
            self.out.keep(MODEL)
            self.out.keep(STATE)
        if self._is_kept:
            names -= {MODEL, STATE, DECISIONS}
        self.out.hold()
        self.out.remove_half_written()
        self.out.remove([*(MAKING if is_new else ()), *sorted(names)])
        if is_new:
            self.out.write_text(CONFIG, to_toml(self.config))

    def _write_beginning(self) -> None:
        """Write by what the run can be gone on with; what it was handed on first."""
        if self.continued is not None:
            self._keep_state()
        if self._given is not None:
            self._given.write(self.out)

    def _known_regions(self) -> Regions | None:
        """Return the regions that were handed on; None where they are to be divided."""
        if self.continued is not None:
            return self.continued.regions()
        if self._continued is not None and self._is_kept:
            return own_regions(self.out.path / STATE, self.dataset)
        return None

    def _keep_state(self, *, is_done: bool = False) -> None:
        """Write what it takes to go on, or where it is done to tell of the run."""
        if self._given is None or self.unkept is not None:
            return
        if not is_done:
            self._note_time()
        looks = self.so_far.looks
        memory = teacher.memory() if (teacher := self._remembering) else None
        state: dict[str, Any] = {
            "handed_on": HandedOn(self._rooms, looks, memory),
            "sizes": self._tables.sync(),
            "so_far": self.so_far,
            "decisions": list(self.last_decisions),
        }
        if not is_done:
            state |= {
                "learner": self.learner.learned(),
                "strategy": self._strategy,
                "world": self.world.state(),
                "asked": self.tests.held_out.asked,
            }
        try:
            self._snapshot.write(self.out.file(STATE), state, is_packed=is_done)
        except ValueError as error:
            self.unkept = str(error)
            self.out.remove([STATE])  # of the run that this one continues

    def _note_time(self) -> None:
        now = time.perf_counter()
        self.so_far.seconds, self._started = self.so_far.seconds + now - self._started, now

    def _take_up(self) -> list[int]:
        """Take over the state of the run so far; return how much of each table is of it."""
        state = self._snapshot.read(self.out.path / STATE)
        self.so_far, self.last_decisions = state["so_far"], state["decisions"]
        if (teacher := self._remembering) is not None:
            teacher.recall(state["handed_on"].memory)
        if "learner" in state:
            self._go_on(state)
        else:
            model, _ = load_learner(self.out.path / MODEL, self.config, self.teacher)
            self.learner.take_up(model.learned())
        return list(state["sizes"])

    def _go_on(self, state: Mapping[str, Any]) -> None:
        """Put all that steps change where it was."""
        self.learner.take_up(state["learner"])
        self._strategy = state["strategy"]
        self.world.go_on(state["world"], self.so_far.n_steps)
        changed_at = self.tests.n_before_change
        if changed_at is not None and self.so_far.n_steps > changed_at:
            self._test_after_change()
        if state["asked"]:
            self.tests.held_out.ask_as_before(state["asked"])

    @property
    def _remembering(self) -> TemporalTeacher | None:
        teacher = self.learner.teacher
        return teacher if isinstance(teacher, TemporalTeacher) else None

    def _test_after_change(self) -> None:
        """Go on with tests of what is drawn as it is after its change."""
        self.tests.go_on_after_change()
        self.stopwatch.watch(self.tests.held_out, "overall_error", "test")

    def _watch(self) -> Stopwatch:
        stopwatch = Stopwatch()
        stopwatch.watch(self.world, "capture")
        for method in ("describe", "segment", "vote", "learn"):
            stopwatch.watch(self.learner, method, "predict" if method == "vote" else method)
        stopwatch.watch(self.tests.held_out, "overall_error", "test")
        return stopwatch

    def _note(self, step: Step) -> StepRow:
        """Return the step's row; count what was wrong with its frame."""
        observation = step.observation
        if step.index == self.tests.n_before_change:
            self._test_after_change()
        so_far = self.so_far
        so_far.add(step)
        so_far.last = StepRow(
            step=step.index,
            id=observation.frame.id,
            region=step.viewpoint.region,
            error=observation.error,
            learning_progress=step.learning_progress,
            samples=self.learner.n_samples,
            metres=so_far.odometer.metres,
            degrees=so_far.odometer.degrees,
            overall_error=self.tests.held_out.overall_error(observation.change),
        )
        self._note_place(step)
        return so_far.last

    def _note_place(self, step: Step) -> None:
        """Keep how well all places are known once the run has left one that it has learned."""
        if self._place_of_view is None or self.tests.places is None:
            return
        left, forgetting = self.so_far.forgetting.here, self.so_far.forgetting
        if forgetting.is_left(self._place_of_view[step.viewpoint.index]) and left is not None:
            errors = self.tests.held_out.errors(Change({}))
            forgetting.add(left, errors, self.tests.places)

    def _forgetting(self) -> dict[str, Any] | None:
        """Return what is left of each place; None where they are not known, or only one."""
        if self._place_of_view is None or self.tests.places is None or not self.so_far.n_steps:
            return None
        errors = self.tests.held_out.errors(Change({}))
        return self.so_far.forgetting.summary(errors, self.tests.places)

    def summary(self) -> dict[str, Any]:
        """Return what has been done so far, JSON-able; without what the clock told."""
        last = self.so_far.last
        return {
            "source": place(self.dataset),
            "layout": self.dataset.name,
            "continued": str(self._continued) if self._continued else None,
            "strategy": self.config.explorer.strategy,
            "preset": self.config.preset,
            "seed": self.config.run.seed,
            "regions": self.regions.kind,
            "scene": self.survey.scene,
            "steps": self.so_far.n_steps,
            "distinct_frames": len(self.so_far.ids),
            "training_frames": len(self.world.views),
            "overall_error": last.overall_error if last else None,
            "frames_scored": self.tests.held_out.n_frames,
            "frames_tested": self.tests.held_out.n_given,
            "pooled_error": self.tests.held_out.pooled_error(),
            "tested_on": self.tests.truth.kind,
            "test_source": place(self.tests.truth.dataset) if self.tests.truth.indices else None,
            "test_frames": self.tests.held_out.n_frames,
            "samples": last.samples if last else 0,
            "places": self.learner.experts.n_views(),
            "forgetting": self._forgetting(),
            "n_alarms": self.so_far.n_alarms,
            "alarms": [event.summary() for event in self.so_far.events],
            "metres": last.metres if last else 0.0,
            "degrees": last.degrees if last else 0.0,
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary(),
            "test_frames_learned": self.n_learned,
            "test_problems": self.tests.problems.counts(),
        }


def load_run_model(run: Path) -> Path:
    """Return the model file of a run's folder, or of the file itself."""
    if not run.exists():
        raise DataError(run, "does not exist", "give the folder of a run, or a model file")
    return find_model(run)


def run_settings(run: Path) -> Path | None:
    """Return the file of a run's settings; None where there is a model alone."""
    path = run / CONFIG
    return path if path.is_file() else None
