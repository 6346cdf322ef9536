"""What a place was: samples that leave first, and trees that regrow sooner, once it has changed."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field

from curiosight.frame import Pose
from curiosight.learner.drift import Alarm, Drift
from curiosight.learner.forest import Forest
from curiosight.learner.scenery import Signs
from curiosight.learner.stays import Stay


@dataclass(slots=True)
class Staleness:
    """What is known of each place's changes, and how much of its forest is of what it was.

    drifts: by place. stay: the looks that have not counted yet, see `Stay`. n_stale: of each place
    that has changed, how many of its oldest samples are of what it was; while there are some its
    forest regrows twice as many trees a frame.
    """

    drifts: dict[int, Drift] = field(default_factory=dict)
    n_stale: dict[int, int] = field(default_factory=dict)
    stay: Stay | None = None

    def note(
        self, place: int, pose: Pose | None, signs: Signs, error: float | None
    ) -> Alarm | None:
        """Take in what a look at a place tells of change; error: None = nothing.

        It counts once the camera has left the spot: looks from one spot are alike, and would pass
        for so many signs of one thing.
        """
        ended = None
        if self.stay is None or not self.stay.goes_on(place, pose):
            ended, self.stay = self.stay, Stay(place, pose)
        self.stay.add(signs, error)
        if ended is None:
            return None
        drift = self.drifts.setdefault(ended.place, Drift())
        return drift.add(ended.place, ended.signs(), ended.mean("error"))

    def begin(self, place: int, forest: Forest) -> None:
        """Take all that the forest of a place knows for what the place was."""
        self.n_stale[place] = forest.n_samples

    def make_room(self, place: int, forest: Forest, n_new: int) -> None:
        """Let stale samples leave for new ones that are about to come, one for one.

        No more: much of what a place was is as before.
        """
        n_stale = self.n_stale.get(place, 0)
        n_forgotten = min(n_stale, n_new)
        if n_forgotten:
            forest.forget(n_forgotten)
            self.n_stale[place] = n_stale - n_forgotten

    def regrow(self, place: int, forest: Forest, regrown: tuple[int, ...]) -> tuple[int, ...]:
        """Regrow as many trees again while samples are stale; return all trees that were."""
        if not self.n_stale.get(place) or not regrown:
            return regrown
        return tuple(sorted({*regrown, *forest.regrow()}))

    def move(self, origins: Mapping[int, int]) -> None:
        """Let what is known of changes follow its views to other places.

        origins: of each place that there is now the one that most of its views were of. All samples
        that they have now count as fresh.
        """
        self.drifts = {
            place: deepcopy(self.drifts[origin])
            for place, origin in origins.items()
            if origin in self.drifts
        }
        self.n_stale, self.stay = {}, None
