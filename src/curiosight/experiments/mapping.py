"""Write the saliency of images: of a learned model or of a baseline."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.learner.learner import Saliency

# Of decoded frames: the few that are decoded ahead.
FRAMES_MB = 8


class Mapping:
    """Map every frame of a recording, frame by frame.

    saliency_of: from a frame to (H, W) in [0, 1]; a `ValueError` says why it cannot.
    n_seen, n_mapped: frames so far, and those that have a map.
    """

    def __init__(
        self,
        config: Config,
        saliency_of: Callable[[Frame], Saliency],
        dataset: Dataset,
        out: OutputFolder,
    ) -> None:
        self.problems = Problems()
        self.n_seen = self.n_mapped = 0
        # Each frame is looked at once: what was is not kept.
        self._memory_mb = min(config.run.memory_mb, FRAMES_MB)
        self._saliency_of = saliency_of
        self._dataset = dataset
        self._out = out

    def __iter__(self) -> Iterator[tuple[Frame, Saliency | None]]:
        """Yield each frame with its saliency, None where there is none, once it is written.

        <id>.png is 8 bit, of the colour image's size: 255 is a saliency of 1.
        """
        with Prefetch(self._dataset, memory_mb=self._memory_mb) as frames:
            for frame in frames.in_order(range(len(self._dataset))):
                saliency, problem = _map(self._saliency_of, frame)
                self.n_seen += 1
                if saliency is None:
                    self.problems.add(frame, problem)
                else:
                    self.n_mapped += 1
                    grey = np.rint(255 * saliency).astype(np.uint8)
                    self._out.write_image(f"{frame.id}.png", grey)
                yield frame, saliency


def _map(
    saliency_of: Callable[[Frame], Saliency], frame: Frame
) -> tuple[Saliency | None, str | None]:
    """Return an image's saliency, or None and why there is none.

    What is wrong with a frame's depth or pose does not matter: its colour is not black then.
    """
    if frame.problem is not None and not frame.rgb.any():
        return None, frame.problem
    try:
        return saliency_of(frame), None
    except ValueError as error:  # too small an image, say
        return None, str(error)
