"""What a strategy may know of each region, as arrays of a fixed size."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.explorer.ground import Ground
from curiosight.explorer.motivations import Error, Motivation, Progress, Uncertainty
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.progress import ProgressMeter
from curiosight.explorer.tally import Tally

Numbers = npt.NDArray[np.float32]

# What is not known yet is as interesting as it can be, as strategies take it.
UNKNOWN = 1.0


class Known:
    """Take note of looks; measured as strategies measure it.

    tally: where the camera is, and how often it looked where.
    """

    def __init__(self, ground: Ground, config: Config) -> None:
        self.tally = Tally(ground)
        settings = config.explorer
        meter = ProgressMeter(
            theta=settings.theta,
            smoothing=settings.smoothing,
            min_errors=settings.min_errors,
            undefined=settings.undefined,
        )
        self._interests: dict[str, Motivation] = {
            "error": Error(),
            "progress": Progress(meter),
            "uncertainty": Uncertainty(),
        }

    def next_view(self, region: int) -> int:
        """Return the number of the view to look at in a region: the nearest least seen."""
        return self.tally.nearest(self.tally.ground.members[region])

    def add(self, number: int, outcome: Outcome) -> None:
        """Take note of a look at a view."""
        self.tally.go_to(number)
        region = int(self.tally.ground.region_of[number])
        for interest in self._interests.values():
            interest.add(region, outcome)

    def of_regions(self) -> dict[str, Numbers]:
        """Return (n_regions,) of each: looks, error, progress, uncertainty, seconds.

        seconds: of the way to the view that would be looked at there; 0 before the first look.
        """
        ground, tally = self.tally.ground, self.tally
        known = {"looks": tally.n_looks.astype(np.float32)}
        for name, motivation in self._interests.items():
            values = [motivation.interest(region) for region in range(ground.n_regions)]
            known[name] = np.array([UNKNOWN if v is None else v for v in values], np.float32)
        seconds = ground.seconds_from(tally.here)
        views = [self.next_view(region) for region in range(ground.n_regions)]
        return {**known, "seconds": seconds[views].astype(np.float32)}

    def of_views(self) -> dict[str, Numbers]:
        """Return (n_views,) of each: view_looks, and view_seconds, of the way from here."""
        seconds = self.tally.ground.seconds_from(self.tally.here)
        looks = self.tally.n_seen.astype(np.float32)
        return {"view_looks": looks, "view_seconds": seconds.astype(np.float32)}
