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
from curiosight.experiments.components import make_learner, make_teacher, place
from curiosight.frame import Frame
from curiosight.learner.learner import Description, Labels, fit_labels

STAGES = ("segment", "describe", "predict", "learn")


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

    The teacher takes every frame by itself, without memory of others; the learner's buffer is
    full, as late in a long run. Decoding is not counted.

    stages: of `STAGES`, those to time. n_frames: of fewer, all.
    learner: what is timed, without a teacher; trained where predict or learn is timed.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        *,
        n_frames: int = 40,
        stages: Sequence[str] = STAGES,
    ) -> None:
        if n_frames < 1:
            raise ValueError(f"frames: expected 1 or more, got {n_frames}")
        if not stages or not set(stages) <= set(STAGES):
            raise ValueError(f"stage: expected {', '.join(STAGES)}, got {', '.join(stages)!r}")
        self.config = replace(config, run=replace(config.run, n_threads=1))
        self.times = {stage: StageTimes() for stage in STAGES if stage in stages}
        self.teacher = make_teacher(self.config, dataset)
        self.learner = make_learner(self.config, None)
        self._dataset = dataset
        self._timed = _spread(n_frames, len(dataset))
        # The more frames the rows are of, the larger the trees, and the longer they take.
        n_filling = -(-config.forest.max_samples // config.learner.n_pixels)
        has_forest = not {"predict", "learn"}.isdisjoint(stages)
        self._filling = _spread(n_filling, len(dataset)) if has_forest else []
        self._image: tuple[int, int] | None = None

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
        learner.forest.fit(rows[places], is_salient[places])

    def _labels(self, frame: Frame, description: Description) -> Labels:
        return fit_labels(self.teacher.segment(frame).labels, description)

    def _run(self, frame: Frame, times: dict[str, StageTimes]) -> None:
        """Do the stages that are timed, and what they need."""
        if "segment" in times:
            times["segment"].run(lambda: self.teacher.segment(frame))
        if set(times) == {"segment"}:
            return
        learner = self.learner
        describe = times.get("describe", StageTimes())
        description = describe.run(lambda: learner.describe(frame.rgb))
        if "predict" in times:
            times["predict"].run(lambda: learner.predict(description))
        if "learn" in times:
            labels = self._labels(frame, description)
            times["learn"].run(lambda: learner.learn(description, labels))

    @property
    def n_timed(self) -> int:
        """How many frames are timed so far."""
        return min(len(times.wall_ms) for times in self.times.values())

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
            "processor": processor(),
            "python": platform.python_version(),
            "stages": {stage: times.summary() for stage, times in self.times.items()},
        }


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
