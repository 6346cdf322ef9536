"""What is there, where, since when, what is new, what has moved, and what is gone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from curiosight.catalogue.confidence import confidence_of, measure_things, odds_of, share_of
from curiosight.catalogue.detection import Detection
from curiosight.catalogue.matching import Appearance, match_things
from curiosight.catalogue.things import Thing
from curiosight.catalogue.visit import Visit
from curiosight.catalogue.voxels import share_in
from curiosight.frame import Pose

Change = Literal["new", "moved", "gone", "same"]
CHANGES: tuple[Change, ...] = get_args(Change)
# Which entries are shown: of those that are surer than this nine of ten are right.
MIN_CONFIDENCE = 0.6
# Shares of a thing's surface: seen again, so that it counts; of that seen free, so that it is gone;
# seen where it now is, so that it was there before, though nobody knew it for a thing; and in a
# thing that was known to be there.
MIN_SEEN, MIN_FREE, MIN_THERE, MIN_KNOWN = 0.2, 0.5, 0.6, 0.3
# Of the things, which are taken to stand on the floor: fewer may seem to be below it.
LOWEST = 0.05


@dataclass(frozen=True, slots=True)
class Sighting:
    """A view of an entry: the numbers of the visit and of the view, and what it shows."""

    visit: int
    view: int
    shown: Detection


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A thing of the catalogue.

    id: from 1, kept over visits. place: number of the place; None = places are not known.
    support: what it stands on, in words.
    T_world_centre: (4, 4), the centre of the upright box around it: z is up, y its longer side.
    size_m: width, length and height of that box. T_world_before: where it was before the last
    visit, if it moved then.
    seen: the views of it, in order. confidence: in [0, 1], see `confidence_of`.
    change: since the visit before the last; of a first visit all is new. An entry that was not
    found again, but whose place was not seen free either, is the same.
    """

    id: int
    place: int | None
    support: str
    T_world_centre: Pose
    size_m: tuple[float, float, float]
    seen: tuple[Sighting, ...]
    confidence: float
    change: Change
    thing: Thing
    T_world_before: Pose | None = None

    @property
    def n_views(self) -> int:
        return len({(one.visit, one.view) for one in self.seen})

    @property
    def best(self) -> Sighting:
        """Of its last visit the view that shows most of it."""
        last = max(one.visit for one in self.seen)
        here = [one for one in self.seen if one.visit == last]
        return max(here, key=lambda one: (one.shown.is_decided, one.shown.n_pixels))


class Catalogue:
    """A list of things that is kept over visits of the same rooms, in one world's frame.

    visits: so far. min_confidence: entries that are less sure are kept, but not shown.
    """

    def __init__(self, *, min_confidence: float = MIN_CONFIDENCE) -> None:
        if not 0 <= min_confidence <= 1:
            found = f"got {min_confidence}"
            raise ValueError(f"min_confidence: expected a number in [0, 1], {found}")
        self.min_confidence = min_confidence
        self.visits: list[Visit] = []
        self._entries: list[Entry] = []

    @property
    def entries(self) -> list[Entry]:
        """The entries that are sure enough, by their numbers; what is gone, too."""
        return [one for one in self._entries if one.confidence >= self.min_confidence]

    def add(self, visit: Visit) -> list[Entry]:
        """Take in a visit that is over; return the entries as they are now.

        Raises ValueError for a visit without a frame.
        """
        if not visit.views:
            raise ValueError("visit: expected one with frames, got none")
        self.visits.append(visit)
        found = list(self._found(visit))
        there = [one for one in self._entries if one.change != "gone"]
        after = [one for one in self._entries if one.change == "gone"]
        pairs = match_things(appearances_of(there), appearances_of(found))
        matched = {i: (j, is_same) for i, j, is_same in pairs}
        stay = {i for i, _, is_same in pairs if is_same}, {j for _, j, is_same in pairs if is_same}
        left, came = (
            [one.thing for place, one in enumerate(some) if place not in staying]
            for some, staying in zip((there, found), stay, strict=True)
        )
        for place, entry in enumerate(there):
            if place in matched:
                j, is_same = matched[place]
                after.append(_again(entry, found[j], is_same=is_same))
            else:
                after.append(self._unseen(entry, visit, came))
        known = {j for _, j, _ in pairs}
        n_known = max((one.id for one in self._entries), default=0)
        unknown = [one for j, one in enumerate(found) if j not in known]
        for number, entry in enumerate(unknown, start=n_known + 1):
            after.append(replace(entry, id=number, change=self._arrival(entry, left)))
        self._entries = sorted(after, key=lambda one: one.id)
        return self.entries

    def _found(self, visit: Visit) -> Iterator[Entry]:
        """Yield the things of a visit as entries that are not numbered yet."""
        number, things = len(self.visits) - 1, visit.things()
        boxes = [thing.box(visit.up_world) for thing in things]
        sizes = [size for _, size in boxes]
        n_pixels = [int(np.prod(visit.views[thing.best[0]].size)) for thing in things]
        confidence = confidence_of(measure_things(things, sizes, n_pixels, visit.glimpses))
        for thing, (pose, size), sure in zip(things, boxes, confidence.tolist(), strict=True):
            yield Entry(
                id=0,
                place=visit.place_of(thing),
                support=thing.support,
                T_world_centre=pose,
                size_m=size,
                seen=tuple(Sighting(number, view, shown) for view, shown in thing.seen),
                confidence=sure,
                change="new",
                thing=thing,
            )

    def _unseen(self, entry: Entry, visit: Visit, came: Sequence[Thing]) -> Entry:
        """Return what has become of an entry that a visit did not find.

        came: what now stands where it did not before.
        """
        seen = visit.glimpses.look_for(entry.thing.voxels)
        n_seen = seen.free + seen.there
        is_free = n_seen >= MIN_SEEN and seen.free >= MIN_FREE * n_seen
        is_gone = is_free or (seen.there >= MIN_THERE and _is_among(entry.thing, came))
        return replace(entry, change="gone" if is_gone else "same", T_world_before=None)

    def _arrival(self, entry: Entry, left: Sequence[Thing]) -> Change:
        """Tell whether what was not known before is new: its surface was not there, that is.

        left: what stood where it does not now; that is what was there.
        """
        if len(self.visits) < 2:
            return "new"
        before = self.visits[-2].glimpses.look_for(entry.thing.voxels)
        is_new = before.there < MIN_THERE or _is_among(entry.thing, left)
        return "new" if is_new else "same"


def _is_among(thing: Thing, others: Sequence[Thing]) -> bool:
    """Tell whether the surface of a thing is that of another, in part."""
    return any(
        share_in(thing.voxels, other.grown) > MIN_KNOWN for other in others if other.is_near(thing)
    )


def appearances_of(entries: Sequence[Entry]) -> list[Appearance]:
    """Return what entries are known again by."""
    centres = [one.T_world_centre[:3, 3] for one in entries]
    bottoms = [
        float(one.T_world_centre[:3, 2] @ centre) - one.size_m[2] / 2
        for one, centre in zip(entries, centres, strict=True)
    ]
    lowest = float(np.quantile(bottoms, LOWEST)) if bottoms else 0.0
    return [
        Appearance(
            centre,
            one.size_m,
            one.thing.hues,
            one.thing.voxels,
            bottom - lowest,
            one.place,
            len(one.thing.views),
            one.confidence,
        )
        for one, centre, bottom in zip(entries, centres, bottoms, strict=True)
    ]


def _again(entry: Entry, found: Entry, *, is_same: bool) -> Entry:
    """Return an entry as a later visit has found it."""
    return replace(
        found,
        id=entry.id,
        seen=(*entry.seen, *found.seen),
        confidence=_both_sure(entry.confidence, found.confidence),
        change="same" if is_same else "moved",
        T_world_before=None if is_same else entry.T_world_centre,
    )


def _both_sure(*shares: float) -> float:
    """Return how sure it is of a thing that two visits show: the mean of their log-odds."""
    return float(share_of(np.mean([odds_of(share) for share in shares])))
