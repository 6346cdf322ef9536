"""Watch a source live: from a recording or a drive to the parts that run, and what is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.components import (
    choose_strategy,
    heard,
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
from curiosight.explorer import Regions, Strategy
from curiosight.explorer.regions import is_living
from curiosight.explorer.strategies import check_loadable
from curiosight.frame import Viewpoint
from curiosight.learner.archive import MODEL
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.robot.advice import Advice
from curiosight.robot.feed import Replay
from curiosight.robot.plan import Plan
from curiosight.robot.routes import Drive, rounds
from curiosight.robot.shown import Shown
from curiosight.robot.watch import Look, Watch
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.worlds.travel import travel_seconds

LOOKS, DECISIONS = "looks.csv", "decisions.csv"
RESULTS = (MODEL, "summary.json", LOOKS, DECISIONS)
COLUMNS = ("look", "seconds", "id", "region", "error", "samples")
N_WARM_UP = 4
# Where the way counts and is known; where it is not, what explores a recording.
BY_WAYS, ELSE = "progress-rate", "iac"


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of a watch. model: to begin with; None = one that knows nothing.

    strategy: that advises or drives; None = `progress-rate` where all views have poses, else `iac`.
    """

    model: Path | None = None
    is_learning: bool = False
    strategy: str | None = None

    def __post_init__(self) -> None:
        if self.strategy is not None:
            check_loadable(self.strategy)


class Watching:
    """One watch of a recording or a drive, and the folder it writes.

    drawn: the views that were drawn, where the source is a drive: the explorer drives then, along
        its frames; else somebody has driven already, and it gives advice.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        asked: Asked,
        *,
        drawn: DrawnViews | None = None,
        keeping: Keeping | None = None,
    ) -> None:
        check_regions(config)
        self.dataset, self.out, self.asked = dataset, out, asked
        self._keeping = keeping or Keeping()
        self.problems, self.lessons = Problems(), Lessons()
        self._has_learned = False
        self._ids: set[str] = set()
        learner_rng, strategy_rng = np.random.default_rng(config.run.seed).spawn(2)
        has_teacher = asked.is_learning or dataset.has_depth or not config.teacher.is_depth
        survey = survey_dataset(config, dataset) if has_teacher else None
        teacher = make_teacher(config, dataset, survey) if has_teacher else None
        self.learner, self.config = _learner(config, asked.model, teacher, learner_rng)
        _warm_up(self.config, dataset, teacher)
        up = None if survey is None else survey.up_world
        self.regions = choose_regions(self.config, drawn or dataset, survey)
        self._ways = _ways_of(self.config, drawn or dataset, self.regions)
        drive = None if drawn is None else Drive(len(dataset))
        views = _views(dataset, self.regions)
        self.config = replace(
            self.config, explorer=replace(self.config.explorer, strategy=self._strategy_name())
        )

        def strategy_of(views: tuple[Viewpoint, ...]) -> Strategy:
            return choose_strategy(self.config, views, strategy_rng, ways=self._ways)

        self.advice = Advice(strategy_of, views, self.regions.names, drive=drive)
        self.watch = Watch(
            self.learner,
            Replay(dataset, rounds(len(dataset)) if drive is None else drive),
            None if teacher is None else heard(self.config, teacher),
            is_learning=asked.is_learning,
            advice=self.advice,
            on_look=self._note,
        )
        outlines: Sequence[npt.NDArray[np.floating]] = () if drawn is None else drawn.outlines
        plan = Plan(views, self.regions.names, up=up, outlines=outlines)
        title = f"{place(dataset)}: {'driven by' if drawn else 'advised by'} {self.strategy}"
        self.shown = Shown(self.watch, plan, title=title, save=self._save_now())
        out.remove(RESULTS)
        out.write_text("config.toml", to_toml(self.config))
        self._looks_file = TableFile(out.file(LOOKS), COLUMNS)
        self._decisions = DecisionsFile(out.file(DECISIONS), self.advice.strategy)

    @property
    def strategy(self) -> str:
        return self.config.explorer.strategy

    def _strategy_name(self) -> str:
        if self.asked.strategy is not None:
            return self.asked.strategy
        has_all = all(pose is not None for pose in self.dataset.poses)
        return BY_WAYS if has_all and self._ways is not None else ELSE

    def run(self, seconds: float | None, is_wanted: Callable[[], bool]) -> Iterator[float]:
        """Run until so many seconds after the first map, None = without end, or it is not wanted.

        Yield the seconds since the first map now and then; 0 before it. Raises what went wrong.
        """
        watch = self.watch
        watch.start()
        try:
            while is_wanted() and not watch.wait(0.1):
                passed_s = watch.seconds() or 0.0
                if seconds is not None and passed_s >= seconds:
                    break
                yield passed_s
        finally:
            self.seconds = watch.seconds() or 0.0
            watch.stop()
        if watch.failure is not None:
            raise watch.failure

    def _note(self, look: Look) -> None:
        """Write a look to the tables, and the model now and then; in the learning thread."""
        frame, segmentation = look.verdict.shot.frame, look.verdict.segmentation
        self.problems.add_told(frame, segmentation)
        if self.asked.is_learning:
            self.lessons.add(frame, segmentation)
            self._has_learned |= look.n_regrown > 0
            self._ids.add(frame.id)
        index = look.verdict.shot.index
        region = -1 if index is None else int(self.regions.of_view[index])
        self._looks_file.add(
            {
                "look": look.number,
                "seconds": look.seconds,
                "id": frame.id,
                "region": region,
                "error": look.error,
                "samples": self.learner.n_samples,
            }
        )
        self._decisions.add(look.number)
        if self.asked.is_learning and self._keeping.is_due():
            with self._keeping.writing(), suppress(DataError):
                self.save(is_packed=False)

    def _save_now(self) -> Callable[[], str] | None:
        """Return what the page's button does: nothing where the model does not change."""
        if not self.asked.is_learning:
            return None
        return lambda: str(self.watch.model_do(lambda _: self.save()))

    def save(self, *, is_packed: bool = True) -> Path:
        """Write the model; while it runs only where nothing changes it."""
        note_frames(self.learner, self.dataset, self._ids)
        path = self.out.file(MODEL)
        self.learner.save(path, is_packed=is_packed)
        return path

    @property
    def has_learned(self) -> bool:
        """Tell whether the looks changed what the model says."""
        return self._has_learned

    def finish(self) -> dict[str, Any]:
        """Write the model, where it learned, and the summary; return the summary."""
        self._looks_file.close()
        self._decisions.close()
        if self.asked.is_learning:
            self.save()
        summary = self._summary()
        self.out.write_json("summary.json", summary)
        return summary

    def _summary(self) -> dict[str, Any]:
        watch, seconds = self.watch, self.seconds
        rate = {"maps": watch.maps.n, "learned": watch.lessons.n}
        return {
            "source": place(self.dataset),
            "model": None if self.asked.model is None else str(self.asked.model),
            "strategy": self.strategy,
            "seed": self.config.run.seed,
            "seconds": round(seconds, 2),
            **rate,
            "looks": watch.looks.n,
            "map_hz": round(watch.maps.n / seconds, 2) if seconds else None,
            "learn_hz": round(watch.lessons.n / seconds, 2) if seconds else None,
            "map_age_p50_ms": watch.ages.percentile_ms(50),
            "map_age_p99_ms": watch.ages.percentile_ms(99),
            "dropped": watch.n_dropped,
            "regions": self.advice.regions(),
            "goal": self.advice.goal,
            "why": self.advice.why(),
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary() if self.asked.is_learning else None,
        }


def check_regions(config: Config) -> None:
    """Raise ValueError for regions that change while they are watched."""
    if is_living(config.explorer.regions):
        found = f"regions: expected some that stay, got {config.explorer.regions!r}"
        raise ValueError(f"{found}: a page shows them from above")


def _learner(
    config: Config, model: Path | None, teacher: Teaches | None, rng: np.random.Generator
) -> tuple[SaliencyLearner, Config]:
    """Return a model that was learned before, or a new one, and the settings that fit it."""
    if model is None:
        return make_learner(config, teacher, rng), config
    return load_learner(model, config, teacher, rng)


def _warm_up(config: Config, dataset: Dataset, teacher: Teaches | None) -> None:
    """Do once what will be done to frames, with a learner of no account: kernels are compiled."""
    learner = make_learner(config, None if teacher is None else heard(config, teacher))
    for index in np.unique(np.linspace(0, len(dataset) - 1, N_WARM_UP).astype(int)):
        frame = dataset[int(index)]
        if teacher is not None:
            learner.observe(frame)
        learner.saliency(frame.rgb, frame.T_world_camera)
        learner.unsure(learner.describe(frame.rgb), frame.T_world_camera)


def _views(dataset: Dataset, regions: Regions) -> list[Viewpoint]:
    return [
        Viewpoint(index, int(region), dataset.poses[index])
        for index, region in enumerate(regions.of_view)
    ]


def _ways_of(
    config: Config, dataset: Dataset, regions: Regions
) -> Callable[[Viewpoint, Sequence[Viewpoint]], npt.NDArray[np.float64]] | None:
    """Return the seconds of the ways between views: by a graph, by poses; None = not known."""
    by_graph = graph_ways(regions, dataset.poses)
    if by_graph is not None:
        return by_graph
    if not any(pose is not None for pose in dataset.poses):
        return None
    world = make_world(config, dataset, regions, range(len(dataset)))
    return lambda start, goals: travel_seconds(*world.ways(start, goals))
