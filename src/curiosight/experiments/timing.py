"""Time the stages of the method on one thread, once their kernels are compiled."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.components import (
    make_learner,
    make_teacher,
    place,
    survey_dataset,
)
from curiosight.frame import Frame
from curiosight.learner.description import Description, Labels, fit_labels
from curiosight.learner.observation import Teaches

STAGES = ("segment", "segment_memory", "describe", "predict", "learn", "map", "step")
# Of a model that has learned, and of the model's features alone.
WITH_FOREST = frozenset({"predict", "learn", "map", "step"})
WITH_DESCRIPTION = frozenset({"describe", "predict", "learn"})


class StageTimes:
    """Collect the milliseconds of one stage, wall and processor, call by call."""

    def __init__(self) -> None:
        self.wall_ms: list[float] = []
        self.processor_ms: list[float] = []

    def run(self, work: Callable[[], Any]) -> Any:
        """Do some work, note how long it took, and return its result."""
        wall, processor = time.perf_counter(), time.process_time()
        result = work()
        self.processor_ms.append(1000 * (time.process_time() - processor))
        self.wall_ms.append(1000 * (time.perf_counter() - wall))
        return result

    def summary(self) -> dict[str, float]:
        """Return median and 90th percentile in milliseconds; processor = of all threads."""
        return {
            "median_ms": round(float(np.median(self.wall_ms)), 3),
            "p90_ms": round(float(np.percentile(self.wall_ms, 90)), 3),
            "processor_median_ms": round(float(np.median(self.processor_ms)), 3),
            "processor_p90_ms": round(float(np.percentile(self.processor_ms, 90)), 3),
        }


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep OpenCV to one thread; our own kernels use no more."""
    n_threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(n_threads)


class Timing:
    """Time the stages on evenly spaced frames of a recording.

    `segment` takes every frame by itself. `segment_memory` and, where the settings say so, `step`
    remember what the survey's frames showed, and the frames timed before. The learner's buffer
    is full, as late in a long run. Decoding is not counted.

    stages: of `STAGES`, those to time; None = all that the recording has what they need for.
    n_frames: of fewer, all.
    learner: what is timed; trained where a stage needs it. Its teacher is that of `step`.
    left_out: why a stage is not timed, of those that there are.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        n_frames: int = 40,
        stages: Sequence[str] | None = None,
    ) -> None:
        if n_frames < 1:
            raise ValueError(f"frames: expected 1 or more, got {n_frames}")
        if stages is not None and not (stages and set(stages) <= set(STAGES)):
            raise ValueError(f"stage: expected {', '.join(STAGES)}, got {', '.join(stages)!r}")
        self.config = replace(config, run=replace(config.run, n_threads=1))
        self._dataset = dataset
        self._timed = _spread(n_frames, len(dataset))
        self.left_out: dict[str, str] = {}
        no_memory = self._no_memory()
        if no_memory and "segment_memory" in (stages or ()):
            raise ValueError(f"stage: expected another than segment_memory: {no_memory}")
        if no_memory and stages is None:
            self.left_out["segment_memory"] = no_memory
        chosen = set(STAGES if stages is None else stages) - self.left_out.keys()
        self.times = {stage: StageTimes() for stage in STAGES if stage in chosen}
        self._make_teachers()
        # The more frames the rows are of, the larger the trees, and the longer they take.
        n_filling = -(-config.forest.max_samples // config.learner.n_pixels)
        self._filling = _spread(n_filling, len(dataset)) if chosen & WITH_FOREST else []
        self._image: tuple[int, int] | None = None
        self.n_timed = 0
        self._n_regrown: list[int] = []

    def _no_memory(self) -> str | None:
        """Return why no teacher can remember this recording; None = one can."""
        if self.config.teacher.pipeline == "paper":
            return "the paper's teacher has no memory"
        if not self.config.teacher.is_depth:
            return "only the teacher depth has a memory"
        if all(self._dataset.poses[index] is None for index in self._timed):
            return "the recording has no poses"
        return None

    def _make_teachers(self) -> None:
        """Make what labels frames: alone, with memory, and what the learner hears."""
        config, dataset = self.config, self._dataset
        # Only depth is surveyed; both teachers of it share what that finds.
        survey = survey_dataset(config, dataset) if config.teacher.is_depth else None
        self.teacher = make_teacher(config, dataset, survey)

        def remembering() -> Teaches:
            return make_teacher(config, dataset, survey, temporal=True)

        self._memory = remembering() if "segment_memory" in self.times else None
        recalls = "step" in self.times and config.teacher.temporal and self._no_memory() is None
        self.learner = make_learner(config, remembering() if recalls else self.teacher)

    def __len__(self) -> int:
        """Count the frames that are looked at: to fill the buffer, and to be timed."""
        return len(self._filling) + len(self._timed)

    def __iter__(self) -> Iterator[Frame]:
        """Fill the buffer, warm up, and time; yield each frame when it is done."""
        with one_thread():
            if self._filling:
                yield from self._fill()
            is_warm = False
            for index in self._timed:
                frame = self._dataset[index]
                if frame.problem is None:
                    if not is_warm:
                        self._run(frame, {stage: StageTimes() for stage in self.times})
                        is_warm = True
                    self._run(frame, self.times)
                    self._image = frame.rgb.shape[:2]
                    self.n_timed += 1
                yield frame

    def _fill(self) -> Iterator[Frame]:
        """Teach as many rows as the buffer takes, the same ones again where there are fewer."""
        learner, samples = self.learner, []
        for index in self._filling:
            frame = self._dataset[index]
            if frame.problem is None:
                description = learner.describe(frame.rgb)
                samples.append(learner.sample(description, self._labels(frame, description)))
            yield frame
        is_salient = np.concatenate([np.empty(0, np.bool_), *(labels for _, labels in samples)])
        if not 0 < np.count_nonzero(is_salient) < len(is_salient):
            found = "its frames do not show both an object and its surroundings"
            raise DataError(place(self._dataset), found, "try --stage segment or describe")
        rows = np.concatenate([rows for rows, _ in samples])
        places = np.resize(np.arange(len(rows)), self.config.forest.max_samples)
        learner.experts.common.fit(rows[places], is_salient[places])

    def _labels(self, frame: Frame, description: Description) -> Labels:
        return fit_labels(self.teacher.segment(frame).labels, description)

    def _run(self, frame: Frame, times: dict[str, StageTimes]) -> None:
        """Do the stages that are timed, and what they need."""
        learner, memory = self.learner, self._memory
        if "segment" in times:
            times["segment"].run(lambda: self.teacher.segment(frame))
        if memory is not None and frame.T_world_camera is not None:
            times["segment_memory"].run(lambda: memory.segment(frame))
        if not WITH_DESCRIPTION.isdisjoint(times):
            describe = times.get("describe", StageTimes())
            description = describe.run(lambda: learner.describe(frame.rgb))
            if "predict" in times:
                times["predict"].run(lambda: learner.predict(description))
            if "learn" in times:
                labels = self._labels(frame, description)
                change = times["learn"].run(lambda: learner.learn(description, labels))
                self._n_regrown.append(change.n_regrown)
        if "map" in times:
            times["map"].run(lambda: learner.saliency(frame.rgb))
        if "step" in times:
            observation = times["step"].run(lambda: learner.observe(frame))
            self._n_regrown.append(observation.change.n_regrown)

    def figures(self) -> dict[str, Any]:
        """Return the times of the frames so far and what they were measured on, JSON-able."""
        if self._image is None:
            raise DataError(place(self._dataset), "no frame could be timed", "mend its files")
        height, width = self._image
        return {
            "source": place(self._dataset),
            "preset": self.config.preset,
            "frames": self.n_timed,
            "image": f"{width}x{height}",
            "threads": 1,
            **self._model(),
            "processor": processor(),
            "python": platform.python_version(),
            "stages": {
                stage: times.summary() for stage, times in self.times.items() if times.wall_ms
            },
            "left_out": self.left_out,
        }

    def _model(self) -> dict[str, Any]:
        """Return what the times of a model that has learned depend on; nothing without one."""
        experts = self.learner.experts
        if not experts.is_trained:
            return {}
        forests = experts.of_place or (experts.common,)
        model: dict[str, Any] = {
            "samples": experts.n_samples,
            "places": len(forests),
            "rows_a_tree": round(float(np.mean([forest.n_drawn for forest in forests]))),
        }
        if self._n_regrown:
            model["trees_regrown_a_frame"] = round(float(np.mean(self._n_regrown)), 1)
        return model


def _spread(n_chosen: int, n_frames: int) -> list[int]:
    """Return evenly spaced frames; all where there are no more."""
    chosen = np.linspace(0, n_frames - 1, min(n_chosen, n_frames))
    return [int(index) for index in chosen.round()]


def processor() -> str:
    """Return the processor's name, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if "model name" in line), "")
