"""The views of a source, their regions, and where they are seen from above (fig. 8)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.tour import views_in_regions
from curiosight.experiments.dividing import choose_regions
from curiosight.explorer import Regions
from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Pose
from curiosight.rooms.drawn_views import DrawnViews

_UP = np.array([0.0, 0.0, 1.0])  # of what is drawn


@dataclass(frozen=True, slots=True, eq=False)
class ViewsFromAbove:
    """The views that can be chosen.

    up: (3,) against gravity, None = not known. is_way: whether they follow one another.
    outlines: (n, 2) metres each, walls from above; none where they are not known.
    """

    ids: Sequence[str]
    poses: Sequence[Pose | None]
    regions: Regions
    up: npt.NDArray[np.float64] | None
    is_way: bool = True
    outlines: Sequence[npt.NDArray[np.floating]] = ()

    @classmethod
    def of(cls, config: Config, dataset: Dataset, prepared: Prepared | None) -> ViewsFromAbove:
        """Return them with the regions that strategies choose among; prepared: if it could be."""
        if prepared is None:
            ids, poses, up = dataset.ids, dataset.poses, None
            regions = choose_regions(config, dataset)
        else:
            ids, poses, up = prepared.ids, prepared.poses, prepared.up
            _, regions = views_in_regions(prepared, config)
        if not isinstance(dataset, DrawnViews):
            return cls(ids, poses, regions, up)
        is_way = dataset.settings.path is not None
        return cls(ids, poses, regions, _UP, is_way, dataset.outlines)

    @property
    def has_poses(self) -> bool:
        """Tell whether any view has a pose."""
        return any(pose is not None for pose in self.poses)

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield a row for each view: where it is, metres, where it looks, and its region."""
        above = seen_from_above(self.poses, self.up)
        for id, place, heading, region in zip(
            self.ids, above.positions, above.headings, self.regions.of_view, strict=True
        ):
            yield {
                "id": id,
                "x": _known(place[0]),
                "y": _known(place[1]),
                "heading_deg": _known(np.degrees(heading)),
                "region": "" if region < 0 else self.regions.names[region],
            }


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
