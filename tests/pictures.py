"""Small pictures, a detector that labels red things, and learners taught with both."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label
from curiosight.learner.learner import SaliencyLearner
from curiosight.teacher import Segmentation

BACKGROUND, RED = (120, 118, 110), (200, 40, 30)


class RedThings:
    """A detector of one's own: red is salient, and the image's upper quarter unknown."""

    def segment(self, frame: Frame) -> Segmentation:
        red, green = frame.rgb[..., 0].astype(int), frame.rgb[..., 1].astype(int)
        labels = np.where(red - green > 80, Label.SALIENT, Label.NOT_SALIENT).astype(np.uint8)
        known_from = len(labels) if frame.problem else len(labels) // 4
        labels[:known_from] = Label.UNKNOWN
        return Segmentation.of_labels(labels, frame.problem)


def picture(seed: int = 0, *, n_things: int = 2, size: tuple[int, int] = (320, 240)) -> Frame:
    """Paint red rectangles on a grey, slightly noisy ground; size: width, height."""
    rng = np.random.default_rng(seed)
    width, height = size
    rgb = np.full((height, width, 3), BACKGROUND, np.uint8)
    for _ in range(n_things):
        u, v = rng.integers(0, [2 * width // 3, 2 * height // 3])
        rgb[v : v + height // 4, u : u + width // 4] = RED
    rgb += rng.integers(0, 12, rgb.shape).astype(np.uint8)
    return Frame(str(seed), rgb)


def make_learner(seed: int = 0, **options) -> SaliencyLearner:
    return SaliencyLearner(RedThings(), **{"rows_per": "superpixel", "seed": seed} | options)


def taught(n_frames: int = 3, **options) -> SaliencyLearner:
    learner = make_learner(**options)
    for seed in range(n_frames):
        learner.observe(picture(seed))
    return learner


def noise_in_blocks(
    seed: int, *, height: int = 60, width: int = 130
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.int32]]:
    """Return noise, and blocks of random sizes as its superpixels."""
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (height, width, 3), np.uint8)
    rows = np.cumsum(rng.random(height) < 0.1)
    columns = np.cumsum(rng.random(width) < 0.1)
    blocks = rows[:, None] * (columns.max() + 1) + columns
    return rgb, np.unique(blocks, return_inverse=True)[1].reshape(blocks.shape).astype(np.int32)
