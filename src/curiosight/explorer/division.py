"""Views divided into regions, by whatever they were divided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.datasets.listing import natural_key

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """The region of every view, none of them empty.

    of_view: (n_views,) int64 region numbers; -1 = in no region (a view without a pose, say).
    names: what to call regions 0, 1, ... in logs and figures.
    kind: the spec that makes them: "pose:2x2x4", "time:5", "file".
    seconds: (n_regions, n_regions) of the ways from region to region, on the diagonal from one
        view to another, as a navigation graph says; None = there is none.
    """

    of_view: Ints
    names: tuple[str, ...]
    kind: str
    seconds: Floats | None = None

    @property
    def n_regions(self) -> int:
        return len(self.names)


def numbered(labels: Sequence[str], kind: str) -> Regions:
    """Number the regions that occur, in natural order of their labels; "" = no region."""
    names = sorted({label for label in labels if label}, key=natural_key)
    number = {name: region for region, name in enumerate(names)} | {"": -1}
    return Regions(np.array([number[label] for label in labels], np.int64), tuple(names), kind)
