"""What a place was: samples that leave first, and trees that regrow sooner, once it has changed."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field

from curiosight.frame import Pose
from curiosight.learner.drift import Alarm, Cause, Drift
from curiosight.learner.forest import Forest
from curiosight.learner.scenery import Signs
from curiosight.learner.stays import Stay

# Light comes back in the morning: what was seen in it is worth keeping.
COMES_BACK: frozenset[Cause] = frozenset({"light", "tint"})


@dataclass(slots=True)
class Stale:
    """The samples of what a place was before it changed.

    n: so many have not been made up for by new ones. leaves: whether they leave meanwhile.
    """

    n: int
    leaves: bool


@dataclass(slots=True)
class Staleness:
    """What is known of each place's changes, and how much of its forest is of what it was.

    drifts: by place. stay: the looks that have not counted yet, see `Stay`. stale: of each place
    that has changed; while there is some its forest regrows twice as many trees a frame.
    """

    drifts: dict[int, Drift] = field(default_factory=dict)
    stale: dict[int, Stale] = field(default_factory=dict)
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

    def begin(self, alarm: Alarm, forest: Forest) -> None:
        """Take all that the forest of a place knows for what the place was."""
        self.stale[alarm.place] = Stale(forest.n_samples, alarm.cause not in COMES_BACK)

    def make_room(self, place: int, forest: Forest, n_new: int) -> None:
        """Let stale samples leave for new ones that are about to come, one for one.

        No more: much of what a place was is as before.
        """
        stale = self.stale.get(place)
        if stale is None:
            return
        n_made_up = min(stale.n, n_new)
        if stale.leaves and n_made_up:
            forest.forget(n_made_up)
        stale.n -= n_made_up
        if not stale.n:
            del self.stale[place]

    def regrow(self, place: int, forest: Forest, regrown: tuple[int, ...]) -> tuple[int, ...]:
        """Regrow as many trees again while samples are stale; return all trees that were."""
        if place not in self.stale or not regrown:
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
        self.stale, self.stay = {}, None
