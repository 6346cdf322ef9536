"""From settings and a recording, or a drive, to the parts of a watch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.experiments.camera_start import FirstFrames
from curiosight.experiments.components import (
    choose_strategy,
    heard,
    load_learner,
    make_learner,
    make_teacher,
    make_world,
    survey_dataset,
)
from curiosight.experiments.dividing import choose_regions, graph_ways
from curiosight.explorer import Regions, Strategy
from curiosight.explorer.ground import Ways
from curiosight.explorer.regions import is_living
from curiosight.explorer.strategies import check_loadable
from curiosight.frame import Viewpoint
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.robot.sinks.sink import Sink
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.teacher import Survey
from curiosight.worlds.travel import travel_seconds

N_WARM_UP = 4
# Where the way counts and is known; where it is not, what explores a recording.
BY_WAYS, USUAL = "progress-rate", Config().explorer.strategy


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of a watch.

    model: to begin with, a run's folder; None = one that knows nothing.
    strategy: that advises or drives; None = that of the settings where they name another than the
        usual one, else `progress-rate` where all views have poses, else the usual one.
    sinks: that are told, too.
    """

    model: Path | None = None
    is_learning: bool = False
    strategy: str | None = None
    sinks: tuple[Sink, ...] = ()

    def __post_init__(self) -> None:
        if self.strategy is not None:
            check_loadable(self.strategy)


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The parts of a watch.

    config: the settings, with those of the model and the strategy. teacher: None = there is no
    depth to compare with. views: one a frame. up: (3,) in the world; None = not known. ways: see
    `choose_strategy`. survey: of the source; None = nobody asked for it.
    """

    config: Config
    learner: SaliencyLearner
    teacher: Teaches | None
    regions: Regions
    views: tuple[Viewpoint, ...]
    make_strategy: Callable[[tuple[Viewpoint, ...]], Strategy]
    up: npt.NDArray[np.float64] | None
    ways: Ways | None
    survey: Survey | None


def make_parts(
    config: Config,
    dataset: Dataset,
    asked: Asked,
    drawn: DrawnViews | None,
    regions: Regions | None = None,
) -> Parts:
    """Survey a source, divide it into regions, and make all that watches it.

    drawn: the views that the frames were drawn from, which know the ways between them.
    regions: that were handed on; None = it is divided.
    """
    check_regions(config)
    learner_rng, strategy_rng = np.random.default_rng(config.run.seed).spawn(2)
    has_teacher = asked.is_learning or dataset.has_depth or not config.teacher.is_depth
    begun = dataset.begun if isinstance(dataset, FirstFrames) else None
    if begun is not None:
        survey = begun.survey
    else:
        survey = survey_dataset(config, dataset) if has_teacher else None
    teacher = make_teacher(config, dataset, survey) if has_teacher else None
    if asked.model is None:
        learner = make_learner(config, teacher, learner_rng)
    else:
        learner, config = load_learner(asked.model, config, teacher, learner_rng)
    warm_up(config, dataset, teacher)
    if begun is not None:
        regions = begun.regions
    regions = regions or choose_regions(config, drawn or dataset, survey)
    ways = _ways_of(config, drawn or dataset, regions)
    strategy = asked.strategy or _strategy_for(config, dataset, ways)
    config = replace(config, explorer=replace(config.explorer, strategy=strategy))
    views = (
        Viewpoint(index, int(region), dataset.poses[index])
        for index, region in enumerate(regions.of_view)
    )
    return Parts(
        config,
        learner,
        None if teacher is None else heard(config, teacher),
        regions,
        tuple(views),
        partial(choose_strategy, config, rng=strategy_rng, ways=ways),
        None if survey is None else survey.up_world,
        ways,
        survey,
    )


def check_regions(config: Config) -> None:
    """Raise ValueError for regions that change while they are watched."""
    if is_living(config.explorer.regions):
        found = f"regions: expected some that stay, got {config.explorer.regions!r}"
        raise ValueError(f"{found}: a page shows them from above")


def warm_up(config: Config, dataset: Dataset, teacher: Teaches | None) -> None:
    """Do once what will be done to frames, with a learner of no account: kernels are compiled."""
    learner = make_learner(config, teacher)
    for index in np.unique(np.linspace(0, len(dataset) - 1, N_WARM_UP).astype(int)):
        frame = dataset[int(index)]
        if teacher is not None:
            learner.observe(frame)
        learner.saliency(frame.rgb, frame.T_world_camera)
        learner.unsure(learner.describe(frame.rgb), frame.T_world_camera)


def _strategy_for(config: Config, dataset: Dataset, ways: Ways | None) -> str:
    has_all = all(pose is not None for pose in dataset.poses)
    is_open = config.explorer.strategy == USUAL
    return BY_WAYS if is_open and has_all and ways is not None else config.explorer.strategy


def _ways_of(config: Config, dataset: Dataset, regions: Regions) -> Ways | None:
    """Return the seconds of the ways between views: by a graph, by poses; None = not known."""
    by_graph = graph_ways(regions, dataset.poses)
    if by_graph is not None:
        return by_graph
    if not any(pose is not None for pose in dataset.poses):
        return None
    world = make_world(config, dataset, regions, range(len(dataset)))

    def seconds(start: Viewpoint, goals: Sequence[Viewpoint]) -> npt.NDArray[np.float64]:
        return travel_seconds(*world.ways(start, goals))

    return seconds
