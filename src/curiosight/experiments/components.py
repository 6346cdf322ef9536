"""From settings and a recording to the parts of the loop."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config, ForestConfig, LearnerConfig, with_model
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.explorer import Regions, Strategy, make_strategy
from curiosight.explorer.ground import Ways
from curiosight.explorer.living import Living
from curiosight.explorer.oracle import Trial
from curiosight.explorer.regions import is_living
from curiosight.frame import Frame, Mount, Viewpoint
from curiosight.learner.features import count_features
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.learner.places import Places
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.teacher import (
    PaperTeacher,
    Survey,
    Teacher,
    TemporalTeacher,
    survey_recording,
)
from curiosight.teacher.depth_and_masks import InstanceMasks
from curiosight.teacher.given import open_teacher
from curiosight.teacher.memory.gravity import UP_OF_MOUNT
from curiosight.teacher.turning import TurnedTeacher, turns_upright
from curiosight.worlds import ReplayWorld, is_drawn
from curiosight.worlds.room_world import RoomWorld


def survey_dataset(config: Config, dataset: Dataset) -> Survey:
    """Look at some frames of a recording and find what they share.

    Raises `DataError` where it has no frame that can be used, or no depth, unless the settings
    name another teacher.
    """
    return survey_frames(config, dataset, _survey_frames(config, dataset))


def make_teacher(
    config: Config, dataset: Dataset, survey: Survey | None = None, *, temporal: bool = False
) -> Teaches:
    """Return what labels a recording's frames: depth, masks, both, or boxes, as settings say.

    survey: of the recording; None = it is made, see `survey_dataset`.
    temporal: the teacher remembers what it sees, and has seen the frames of the survey. Only
        `Teacher` can; raises `ValueError` for another.
    """
    source, pipeline = config.teacher.source, config.teacher.pipeline
    if temporal and not config.teacher.is_depth:
        raise ValueError(f"temporal: expected teacher depth, got {source!r}")
    if temporal and pipeline == "paper":
        raise ValueError("temporal: expected the pipeline 'default', got 'paper'")
    is_turned = getattr(dataset, "is_turned", False)
    if not config.teacher.is_depth:
        return open_teacher(source, dataset.ids, is_turned=is_turned)
    _, _, folder = source.partition(":")
    if folder and pipeline == "paper":
        raise ValueError(f"teacher: expected depth with the pipeline 'paper', got {source!r}")
    masks = InstanceMasks(Path(folder), dataset.ids, is_turned=is_turned) if folder else None
    frames: Iterable[Frame] = _survey_frames(config, dataset)
    if temporal:
        frames = list(frames)
    survey = survey or survey_frames(config, dataset, frames)
    if pipeline == "paper":
        return _held(PaperTeacher(survey.scene, config.paper_segmentation), config, dataset)
    teacher = Teacher(survey, config.segmentation, masks=masks)
    if not temporal:
        return teacher
    remembering = TemporalTeacher(teacher)
    remembering.remember(frames)
    return remembering


def survey_frames(config: Config, dataset: Dataset, frames: Iterable[Frame]) -> Survey:
    """Return what frames of a recording tell together, as the settings or its files ask."""
    return survey_recording(
        frames,
        config.segmentation,
        scene=config.teacher.scene,
        up=_mount_of(config, dataset) or "auto",
    )


def _mount_of(config: Config, dataset: Dataset) -> Mount | None:
    """Return how the camera is held, by the settings, else by its file; None = not said."""
    if config.teacher.up != "auto":
        return config.teacher.up
    mount: Mount | None = getattr(dataset, "mount", None)
    return mount


def _held(teacher: PaperTeacher, config: Config, dataset: Dataset) -> Teaches:
    """Return the paper's teacher, which knows upright cameras only, for one on its side."""
    mount = _mount_of(config, dataset)
    n_turns = 0 if mount is None else turns_upright(UP_OF_MOUNT[mount])
    return TurnedTeacher(teacher, n_turns) if n_turns else teacher


def _survey_frames(config: Config, dataset: Dataset) -> Iterator[Frame]:
    """Yield evenly spaced usable frames, or the first usable one where those are all bad.

    None without depth, where the settings name another teacher; raises as `survey_dataset`.
    """
    if not dataset.has_depth:
        if not config.teacher.is_depth:
            return
        raise DataError(
            place(dataset),
            f"{dataset.name} has no depth to learn from",
            "give a recording with depth; for colour alone there is `curiosight map`",
        )
    n_survey = min(config.teacher.n_survey_frames, len(dataset))
    chosen = np.linspace(0, len(dataset) - 1, n_survey).astype(int)
    n_good = 0
    for frame in _frames(dataset, chosen):
        if frame.problem is None:
            n_good += 1
            yield frame
    if n_good:
        return
    problem = None
    for frame in _frames(dataset, range(len(dataset))):
        if frame.problem is None:
            yield frame
            return
        problem = problem or frame.problem
    raise DataError(
        place(dataset), f"none of its {len(dataset)} frames can be used ({problem})", "mend that"
    )


def _frames(dataset: Dataset, indices: Iterable[int]) -> Iterator[Frame]:
    return (dataset[int(index)] for index in indices)


def place(dataset: Dataset) -> str:
    """Return where a dataset comes from: its folder where it has one."""
    return str(getattr(dataset, "path", dataset.name))


def make_learner(
    config: Config, teacher: Teaches | None, rng: np.random.Generator | None = None
) -> SaliencyLearner:
    """Return a learner that has seen nothing yet.

    teacher: where it can and the settings say so, the learner hears what several views agree
        on (`TemporalTeacher`).
    rng: None = one made from the seed.
    """
    settings, described = config.forest, config.learner
    rng = np.random.default_rng(config.run.seed) if rng is None else rng
    forest = Forest(
        n_features=count_features(
            described.features, described.colour_space, contrast=described.contrast
        ),
        n_trees=settings.n_trees,
        n_regrown=settings.n_regrown,
        share=settings.share,
        max_samples=settings.max_samples,
        max_depth=settings.max_depth,
        min_split=settings.min_split,
        n_split_features=settings.n_split_features or None,
        leaf_share=settings.leaf_share,
        n_levels=settings.n_levels,
        max_rows=settings.max_rows or None,
        vote=settings.vote,
        seed=rng,
        n_threads=config.run.n_threads,
    )
    return SaliencyLearner(
        None if teacher is None else heard(config, teacher),
        forest,
        features=described.features,
        rows_per=described.rows_per,
        colour_space=described.colour_space,
        contrast=described.contrast,
        superpixels=described.superpixels,
        n_superpixels=described.n_superpixels,
        n_pixels=described.n_pixels,
        blind_share=described.blind_share,
        salient_share=described.salient_share,
        follow_edges=described.follow_edges,
        edge_stride=described.edge_stride,
        threshold=described.threshold,
        places=Places(described.max_places) if described.max_places else None,
        is_calibrated=described.is_calibrated,
        seed=rng,
    )


def heard(config: Config, teacher: Teaches) -> Teaches:
    """Return what a learner hears of a teacher, see `make_learner`."""
    if config.teacher.temporal and isinstance(teacher, Teacher):
        return TemporalTeacher(teacher)
    return teacher


def load_learner(
    path: Path, config: Config, teacher: Teaches | None, rng: np.random.Generator | None = None
) -> tuple[SaliencyLearner, Config]:
    """Return a model that was learned before, and the settings with its features and forest."""
    learner = SaliencyLearner.load(
        path,
        None if teacher is None else heard(config, teacher),
        seed=config.run.seed if rng is None else rng,
        n_threads=config.run.n_threads,
    )
    return learner, with_model(
        config,
        LearnerConfig(
            features=learner.describer.features,
            rows_per=learner.describer.rows_per,
            colour_space=learner.describer.colour_space,
            contrast=learner.describer.contrast,
            superpixels=learner.describer.superpixels,
            n_superpixels=learner.describer.n_superpixels,
            n_pixels=learner.n_pixels,
            blind_share=learner.blind_share,
            salient_share=learner.salient_share,
            follow_edges=learner.follow_edges,
            edge_stride=learner.edge_stride,
            threshold=learner.threshold,
            max_places=0 if learner.experts.places is None else learner.experts.places.max_places,
            is_calibrated=learner.calibration is not None,
        ),
        _forest_config(learner.experts.settings()),
    )


def _forest_config(settings: Mapping[str, Any]) -> ForestConfig:
    """Return the settings of a model's forests, as a file of settings has them."""
    is_all = settings["n_split_features"] == settings["n_features"]
    named = {name: settings[name] for name in settings if name != "n_features"}
    return ForestConfig(**named | ({"n_split_features": 0} if is_all else {}))


def note_frames(learner: SaliencyLearner, dataset: Dataset, ids: Iterable[str]) -> None:
    """Note in a model which frames it has learned from, to know them when it is tested."""
    source, learned = _known_as(dataset), learner.notes.setdefault("frames", {})
    learned[source] = sorted({*learned.get(source, ()), *ids})


def count_learned(learner: SaliencyLearner, dataset: Dataset, indices: Iterable[int]) -> int:
    """Count the frames of a recording that a model was taught with."""
    learned = learner.notes.get("frames", {}).get(_known_as(dataset), ())
    return len({dataset.ids[index] for index in indices} & {*learned})


def _known_as(dataset: Dataset) -> str:
    """Return by what name a model knows a recording: its whole path, or what is drawn."""
    source = place(dataset)
    return source if is_drawn(source) else os.path.abspath(source)


def make_world(
    config: Config,
    dataset: Dataset,
    regions: Regions,
    indices: Sequence[int],
    seconds: Ways | None = None,
) -> ReplayWorld | RoomWorld:
    """Return a room or home to move through, or a recording's frames to replay.

    indices: the views within reach. seconds: of the ways between them where poses do not tell.
    """
    if isinstance(dataset, DrawnViews):
        return RoomWorld(dataset, regions.of_view, indices=indices)
    return ReplayWorld(
        dataset,
        regions.of_view,
        indices=indices,
        memory_mb=config.run.memory_mb,
        seconds=seconds,
    )


def choose_strategy(
    config: Config,
    views: tuple[Viewpoint, ...],
    rng: np.random.Generator,
    ways: Ways | None = None,
    trial: Trial | None = None,
) -> Strategy:
    """Return the strategy that the settings ask for; ways: see `Ground`; trial: see `Oracle`.

    Where the regions live it is made anew as they change.
    """
    settings = config.explorer
    make = partial(
        make_strategy,
        settings.strategy,
        rng=rng,
        ways=ways,
        trial=trial,
        random_over=settings.random_over,
        random_n_stay=settings.random_n_stay,
        n_stay=settings.n_stay,
        n_warm_up=settings.n_warm_up,
        random_share=settings.random_share,
        progress=settings.progress,
        theta=settings.theta,
        smoothing=settings.smoothing,
        min_errors=settings.min_errors,
        undefined=settings.undefined,
        negative=settings.negative,
        exponent=settings.exponent,
    )
    if is_living(settings.regions):
        return Living(partial(same_views, views), make, ways=ways)
    return make(views)


def same_views(views: tuple[Viewpoint, ...]) -> tuple[Viewpoint, ...]:
    """Return the views of a world that finds no more."""
    return views
