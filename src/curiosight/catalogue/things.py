"""The things of one visit: what its views show of each, laid over each other."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.boxes import upright_box
from curiosight.catalogue.detection import Detection
from curiosight.catalogue.grouping import group_detections
from curiosight.catalogue.hues import mean_hues
from curiosight.catalogue.voxels import Voxels, centres_of, grown, share_in
from curiosight.frame import Pose

Array = npt.NDArray[Any]

# A map that says so of what depth leaves in doubt makes a thing of it.
MIN_SALIENCY = 0.65
# Of more detections, those of every few views are taken: pairs take time and room.
MAX_DETECTIONS = 4000
# From so many views on, surface that less than this share of them shows is a slip.
MIN_VOTING, MIN_SHOWN = 4, 0.15
# Two are one thing if each lies in the other by this share; or if one lies in the other by
# `MIN_INSIDE`, and hardly any view shows them apart.
MIN_EACH, MIN_INSIDE, MAX_APART = 0.5, 0.35, 1 / 3
# What lies in a better known thing by this share and is at most so large beside it is a part of it;
# so is what lies in the box around one that twice as many views show, as a chair's legs do.
MIN_PART, MAX_PART, MIN_BOXED = 0.5, 0.5, 0.8
# What is farther over its support than this, metres, stands on something else that is not known.
MAX_GAP = 0.15


class Thing:
    """A thing as the views of one visit show it.

    seen: the number of the view and what it shows, in order; at least one.
    """

    def __init__(self, seen: Sequence[tuple[int, Detection]]) -> None:
        self.seen = sorted(seen, key=lambda one: (one[0], one[1].box))

    @cached_property
    def views(self) -> frozenset[int]:
        return frozenset(view for view, _ in self.seen)

    @cached_property
    def n_decided(self) -> int:
        """In how many views depth says that it is a thing."""
        return len({view for view, one in self.seen if one.is_decided})

    @cached_property
    def voxels(self) -> Voxels:
        """Of its surface, without what too few views show."""
        voxels, counts = np.unique(
            np.concatenate([one.voxels for _, one in self.seen]), return_counts=True
        )
        n_views = len(self.views)
        least = max(2.0, MIN_SHOWN * n_views) if n_views >= MIN_VOTING else 1.0
        kept: Voxels = voxels[counts >= least]
        return kept if len(kept) else voxels

    @cached_property
    def grown(self) -> Voxels:
        return grown(self.voxels)

    @cached_property
    def bounds(self) -> Array:
        """(2, 3) metres, the lowest and the highest corner of what it may reach to."""
        centres = centres_of(self.voxels)
        return np.stack([centres.min(0) - 0.05, centres.max(0) + 0.05])

    @cached_property
    def hues(self) -> npt.NDArray[np.float64]:
        """(972,) the share of each hue, of all views, see `mean_hues`."""
        return mean_hues([one.hues for _, one in self.seen])

    @cached_property
    def saliency(self) -> float:
        """How salient it looks, in [0, 1]; NaN without a map."""
        return float(np.mean([one.saliency for _, one in self.seen]))

    @property
    def best(self) -> tuple[int, Detection]:
        """The view that shows most of it, and what it shows."""
        return max(self.seen, key=lambda one: (one[1].is_decided, one[1].n_pixels))

    def box(self, up: Array) -> tuple[Pose, tuple[float, float, float]]:
        """Return T_world_centre and its size, see `upright_box`. up: (3,) unit vector."""
        points = centres_of(self.voxels)
        bases = np.array([one.base for _, one in self.seen])
        bases = bases[np.isfinite(bases)]
        base = float(np.median(bases)) if len(bases) else None
        if base is not None and np.quantile(points @ up, 0.02) - base > MAX_GAP:
            base = None
        return upright_box(points, up, base)

    @property
    def support(self) -> str:
        """What most views say that it stands on."""
        names = [one.support for _, one in self.seen]
        return max(sorted(set(names)), key=names.count)

    def is_near(self, other: Thing) -> bool:
        """Tell whether their boxes meet."""
        (low, high), (other_low, other_high) = self.bounds, other.bounds
        return bool((low < other_high).all() and (other_low < high).all())


def find_things(seen: Sequence[tuple[int, Detection]]) -> list[Thing]:
    """Return the things that views show, those that most views show first.

    seen: the number of a view and what it shows, of all views. What depth leaves in doubt
    counts where the map says salient. Of more than `MAX_DETECTIONS` those of every few views count.
    """
    certain = _thinned(
        [(view, one) for view, one in seen if one.is_decided or one.saliency > MIN_SALIENCY]
    )
    groups = group_detections([view for view, _ in certain], [one for _, one in certain])
    things = [Thing([certain[place] for place in group]) for group in groups]
    things.sort(key=lambda one: (-one.n_decided, -len(one.views), one.seen[0][0]))
    kept: list[Thing] = []
    for thing in things:
        same = next((i for i, other in enumerate(kept) if _are_one(other, thing)), None)
        if same is None:
            kept.append(thing)
        else:
            kept[same] = Thing([*kept[same].seen, *thing.seen])
    return [thing for thing in kept if not (_is_part(thing, kept) or _is_several(thing, kept))]


def _thinned(seen: list[tuple[int, Detection]]) -> list[tuple[int, Detection]]:
    """Return what every few views show, so that it is not too much to be compared in pairs."""
    views = sorted({view for view, _ in seen})
    kept = set(views[:: -(-len(seen) // MAX_DETECTIONS) or 1])
    return [(view, one) for view, one in seen if view in kept]


def _are_one(known: Thing, other: Thing) -> bool:
    if not known.is_near(other):
        return False
    shares = share_in(known.voxels, other.grown), share_in(other.voxels, known.grown)
    if min(shares) > MIN_EACH:
        return True
    n_apart = len(known.views & other.views)
    is_apart = n_apart > MAX_APART * min(len(known.views), len(other.views))
    return max(shares) > MIN_INSIDE and not is_apart


def _is_part(thing: Thing, things: Sequence[Thing]) -> bool:
    """Tell whether a thing is a leg, say, of one that more views show."""
    return any(
        len(whole.views) > len(thing.views)
        and len(thing.voxels) < MAX_PART * len(whole.voxels)
        and whole.is_near(thing)
        and (share_in(thing.voxels, whole.grown) > MIN_PART or _is_boxed(thing, whole))
        for whole in things
        if whole is not thing
    )


def _is_boxed(thing: Thing, whole: Thing) -> bool:
    """Tell whether a thing lies in the box around one that is known much better."""
    if len(whole.views) < 2 * len(thing.views):
        return False
    centres, (low, high) = centres_of(thing.voxels), whole.bounds
    is_inside = ((centres > low) & (centres < high)).all(axis=1)
    return bool(is_inside.mean() > MIN_BOXED)


def _is_several(thing: Thing, things: Sequence[Thing]) -> bool:
    """Tell whether a thing is two or more others, which are as well known, in one."""
    inside = [
        other
        for other in things
        if other is not thing
        and other.n_decided >= thing.n_decided
        and other.is_near(thing)
        and share_in(other.voxels, thing.grown) > MIN_EACH
    ]
    if len(inside) < 2:
        return False
    together = np.unique(np.concatenate([other.grown for other in inside]))
    return share_in(thing.voxels, together) > MIN_EACH
