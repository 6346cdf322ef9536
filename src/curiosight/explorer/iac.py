"""Intelligent adaptive curiosity: go where the error falls fastest (sec. II-B)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from curiosight.explorer.ground import Ways
from curiosight.explorer.motivations import BackwardProgress, Motivation, Progress
from curiosight.explorer.progress import Negative, ProgressMeter, Undefined
from curiosight.explorer.stays import Drawn, Stays
from curiosight.frame import Viewpoint

Direction = Literal["forward", "backward"]


class Iac(Stays):
    """Stay in a region for a while, then go where the error falls fastest (sec. II-B).

    Every region is visited once in random order, `n_warm_up` views each; then stays of
    `n_stay` views, each region drawn by `choice_probabilities`. The views of a stay differ
    from each other as far as the region has that many. Views in no region are left out.

    progress: "forward" = of the errors as they were made, as in the paper; "backward" = of a
        few kept frames, scored again after every look, see `BackwardProgress`.
    theta, smoothing, min_errors, undefined: see `ProgressMeter`; random_share, exponent,
    negative: see `choice_probabilities`.
    """

    def __init__(
        self,
        views: Sequence[Viewpoint],
        rng: np.random.Generator,
        *,
        ways: Ways | None = None,
        n_stay: int = 10,
        n_warm_up: int = 2,
        random_share: float = 0.25,
        progress: Direction = "forward",
        theta: int = 15,
        smoothing: int = 1,
        min_errors: int = 2,
        undefined: Undefined = "repeat",
        negative: Negative = "clip",
        exponent: float = 1.0,
    ) -> None:
        meter = ProgressMeter(
            theta=theta, smoothing=smoothing, min_errors=min_errors, undefined=undefined
        )
        motivation = progress_motivation(progress, meter, rng, theta=theta)
        super().__init__(
            views,
            rng,
            motivation,
            Drawn(rng, random_share=random_share, exponent=exponent, negative=negative),
            ways=ways,
            n_stay=n_stay,
            n_warm_up=n_warm_up,
            progress=motivation,
        )


def progress_motivation(
    progress: Direction, meter: ProgressMeter, rng: np.random.Generator, *, theta: int = 15
) -> Motivation:
    """Return what measures progress in that direction; rng: which kept frames are replaced."""
    if progress == "forward":
        return Progress(meter)
    if progress == "backward":
        return BackwardProgress(rng.spawn(1)[0], theta=theta)
    raise ValueError(f"progress: expected forward or backward, got {progress!r}")
