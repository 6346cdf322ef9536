"""Use curiosight as one who has installed it: run in a fresh environment, and checked by mypy.

The checker must find nothing, so that our types reach the outside; and it must find the mistakes
that are marked to be ignored, or it says that the marks are unused.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import assert_type

import numpy as np
import numpy.typing as npt

import curiosight as cs


def look_around(source: Path | str, n_steps: int) -> npt.NDArray[np.float32]:
    dataset, config = cs.open_dataset(source), cs.load_config("default")
    learner = cs.make_learner(config, cs.make_teacher(config, dataset))
    world = cs.ReplayWorld(dataset, cs.make_regions(None, dataset.poses, dataset.ids).of_view)
    strategy = cs.make_strategy("iac", world.views, learner.rng)
    for step in cs.explore(world, learner, strategy, n_steps=n_steps):
        assert_type(step.index, int)
        assert_type(step.observation.error, float | None)
    frame = dataset[0]
    assert_type(frame, cs.Frame)
    saliency = learner.saliency(frame.rgb)
    assert saliency.shape == frame.rgb.shape[:2]
    return saliency


def never_called(learner: cs.SaliencyLearner) -> None:
    learner.saliency("a.png")  # type: ignore[arg-type]
    cs.explore(learner)  # type: ignore[call-arg, arg-type]
    cs.no_such_name  # type: ignore[attr-defined]  # noqa: B018


if __name__ == "__main__":
    assert Path(cs.__file__).is_relative_to(sys.prefix), cs.__file__
    found = look_around(sys.argv[1], 8)
    assert found.max() > 0.5, found.max()
    print(f"curiosight {cs.__version__}: a map of {found.shape}, up to {found.max():.2f}")
