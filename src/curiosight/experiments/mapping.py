"""Write the saliency of images: a learned model on RGB alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Frame
from curiosight.learner import Saliency, SaliencyLearner


def map_recording(
    config: Config, learner: SaliencyLearner, dataset: Dataset, out: OutputFolder
) -> Iterator[tuple[Frame, Saliency | None, str | None]]:
    """Map every frame; yield it with its saliency, or None and why there is none.

    Writes <id>.png, 8 bit, of the colour image's size: 255 is a saliency of 1.
    """
    with Prefetch(dataset, memory_mb=config.run.memory_mb) as frames:
        for frame in frames.in_order(range(len(dataset))):
            saliency, problem = _map(learner, frame)
            if saliency is not None:
                out.write_image(f"{frame.id}.png", np.rint(255 * saliency).astype(np.uint8))
            yield frame, saliency, problem


def _map(learner: SaliencyLearner, frame: Frame) -> tuple[Saliency | None, str | None]:
    """Return an image's saliency, or None and why there is none.

    What is wrong with a frame's depth or pose does not matter: its colour is not black then.
    """
    if frame.problem is not None and not frame.rgb.any():
        return None, frame.problem
    try:
        return learner.saliency(frame.rgb), None
    except ValueError as error:  # too narrow an image to be cut into superpixels
        return None, str(error)
