"""Write the saliency of images, of a learned model or a baseline: of RGB alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Frame, Rgb
from curiosight.learner import Saliency


def map_recording(
    config: Config, saliency_of: Callable[[Rgb], Saliency], dataset: Dataset, out: OutputFolder
) -> Iterator[tuple[Frame, Saliency | None, str | None]]:
    """Map every frame; yield it with its saliency, or None and why there is none.

    saliency_of: from (H, W, 3) uint8 to (H, W) in [0, 1]; a `ValueError` says why it cannot.
    Writes <id>.png, 8 bit, of the colour image's size: 255 is a saliency of 1.
    """
    with Prefetch(dataset, memory_mb=config.run.memory_mb) as frames:
        for frame in frames.in_order(range(len(dataset))):
            saliency, problem = _map(saliency_of, frame)
            if saliency is not None:
                out.write_image(f"{frame.id}.png", np.rint(255 * saliency).astype(np.uint8))
            yield frame, saliency, problem


def _map(
    saliency_of: Callable[[Rgb], Saliency], frame: Frame
) -> tuple[Saliency | None, str | None]:
    """Return an image's saliency, or None and why there is none.

    What is wrong with a frame's depth or pose does not matter: its colour is not black then.
    """
    if frame.problem is not None and not frame.rgb.any():
        return None, frame.problem
    try:
        return saliency_of(frame.rgb), None
    except ValueError as error:  # too small an image, say
        return None, str(error)
