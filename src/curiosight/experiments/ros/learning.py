"""The model of a node: loaded, learned with, saved and begun anew, with or without a watch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.components import heard, load_learner, make_learner
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.ros.surveying import SurveyingTeacher, mount_by_poses
from curiosight.frame import Camera, Frame, Label
from curiosight.learner.archive import MODEL
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.robot.feed import Feed, Shot
from curiosight.robot.watch import Look, Mapped, Watch
from curiosight.teacher import Segmentation, Teacher, survey_recording


class Learning:
    """A learner over the life of a node, and the watch that uses it while the node is active.

    version: rises whenever the model is another. Nothing that was learned is lost: what a reset or
    another model replaces is written beside the model, if it was not saved.
    """

    def __init__(self, config: Config, folder: OutputFolder, *, is_learning: bool) -> None:
        if not config.teacher.is_depth:
            raise ValueError(f"teacher: expected depth for a node, got {config.teacher.source!r}")
        self.config, self.folder, self.is_learning = config, folder, is_learning
        self.version = 0
        self.n_unsaved = 0
        self.watch: Watch | None = None
        self.is_paused = self.is_frozen = False
        self._keeping = Keeping()
        self._has_written = False
        self._written = config
        self.learner: SaliencyLearner = make_learner(config, None)
        self.teacher = SurveyingTeacher(self._make_teacher)

    def _make_teacher(self, frames: Sequence[Frame]) -> Teaches:
        config = self.config
        up = config.teacher.up
        if up == "auto":
            up = mount_by_poses(frames) or "auto"
        survey = survey_recording(frames, config.segmentation, scene=config.teacher.scene, up=up)
        return heard(config, Teacher(survey, config.segmentation))

    def begin(self, model: Path | None) -> None:
        """Take a model, None = a new one, and prepare it: kernels are compiled."""
        self._take(self._loaded(model) if model is not None else make_learner(self.config, None))
        warm_up(self.config)

    def _loaded(self, model: Path) -> SaliencyLearner:
        learner, self._written = load_learner(model, self.config, None)
        return learner

    def _take(self, learner: SaliencyLearner) -> None:
        self.learner = learner
        self.version += 1
        self.n_unsaved = 0

    def start(
        self,
        feed: Feed,
        settle: Callable[[Shot], Shot],
        on_map: Callable[[Mapped], None],
        on_look: Callable[[Look], None],
        *,
        has_depth: bool = True,
    ) -> Watch:
        """Begin to map, and where there is depth to compare and learn."""

        def looked(look: Look) -> None:
            self._note(look)
            on_look(look)

        self.watch = Watch(
            self.learner,
            feed,
            self.teacher if has_depth else None,
            is_learning=self.is_learning and has_depth,
            on_look=looked,
            on_map=on_map,
            settle=settle,
        )
        self.watch.is_paused, self.watch.is_frozen = self.is_paused, self.is_frozen
        self.watch.start()
        return self.watch

    def halt(self) -> None:
        """End the watch."""
        if self.watch is not None:
            self.watch.stop()
            self.watch = None

    def stop(self) -> None:
        """End the watch, and save what was learned."""
        self.halt()
        if self.n_unsaved:
            self.save()

    def _note(self, look: Look) -> None:
        if look.n_regrown:
            self.version += 1
            self.n_unsaved += 1
        if self.n_unsaved and self._keeping.is_due():
            with self._keeping.writing(), suppress(DataError):
                self._write(MODEL, is_packed=False)

    def _alone(self, job: Callable[[], Any]) -> Any:
        """Do something while nothing changes the model."""
        if self.watch is None:
            return job()
        return self.watch.model_do(lambda _: job())

    def save(self) -> Path:
        """Write the model; return where."""
        return Path(self._alone(lambda: self._write(MODEL)))

    def _write(self, name: str, *, is_packed: bool = True) -> Path:
        if not self._has_written:
            self.folder.write_text("config.toml", to_toml(self._written))
            self._has_written = True
        path = self.folder.file(name)
        self.learner.save(path, is_packed=is_packed)
        self.n_unsaved = 0
        return path

    def replace(self, model: Path | None) -> str:
        """Go on with another model, None = a new one; return, in words, what was done.

        The watch has to be stopped, and started again.
        """
        learner = make_learner(self.config, None) if model is None else self._loaded(model)
        kept = ""
        if self.n_unsaved:
            kept = f"; the one before is kept as {self._write(self._free_name())}"
        self._take(learner)
        self._has_written = False
        if model is None:
            self._written = self.config
            self.teacher = SurveyingTeacher(self._make_teacher)
        return ("begun anew" if model is None else f"loaded {model}") + kept

    def _free_name(self) -> str:
        number = 1
        while (self.folder.path / f"before-{number}.npz").exists():
            number += 1
        return f"before-{number}.npz"


class _Halves:
    """Say of any frame that its upper half is salient."""

    def segment(self, frame: Frame) -> Segmentation:
        labels = np.full(frame.rgb.shape[:2], Label.NOT_SALIENT, np.uint8)
        labels[: len(labels) // 2] = Label.SALIENT
        return Segmentation.of_labels(labels)


def warm_up(config: Config) -> None:
    """Do once what will be done to frames, with a learner of no account: kernels are compiled."""
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (480, 640, 3), np.uint8)
    camera = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
    frame = Frame("warm-up", rgb, np.full((480, 640), 2, np.float32), camera)
    learner = make_learner(config, _Halves())
    for _ in range(2):
        learner.observe(frame)
    learner.saliency(rgb)
    learner.unsure(learner.describe(rgb))
    Teacher(None, config.segmentation).segment(frame)
