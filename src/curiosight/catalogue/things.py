"""The things of one visit: what its views show of each, laid over each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.boxes import upright_box
from curiosight.catalogue.detection import Detection
from curiosight.catalogue.grouping import group_detections
from curiosight.catalogue.hues import mean_hues
from curiosight.catalogue.voxels import SIDE, Voxels, centres_of, grown, share_in
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
# What is farther over its support than this, metres, stands on something else that is not known;
# if that is a thing that ends at most so far below, and under this share of it, the two are one.
MAX_GAP, MAX_BETWEEN, MIN_UNDER = 0.15, 0.12, 0.6
# Surfaces that reach so far into each other, metres, may still be one over the other.
MAX_INTO = 0.1


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
        base = None if self.hangs(up) else self.base
        return upright_box(centres_of(self.voxels), up, base)

    @cached_property
    def base(self) -> float | None:
        """At how many metres along up its support is; None = not known."""
        bases = np.array([one.base for _, one in self.seen])
        bases = bases[np.isfinite(bases)]
        return float(np.median(bases)) if len(bases) else None

    def span(self, up: Array) -> tuple[float, float]:
        """Return from where to where it reaches along up, metres."""
        low, high = np.quantile(centres_of(self.voxels) @ up, (0.02, 0.98)).tolist()
        return low, high

    def hangs(self, up: Array) -> bool:
        """Tell whether it seems to hang in the air over its support."""
        return self.base is not None and self.span(up)[0] - self.base > MAX_GAP

    @property
    def support(self) -> str:
        """What most views say that it stands on."""
        names = [one.support for _, one in self.seen]
        return max(sorted(set(names)), key=names.count)

    def is_near(self, other: Thing) -> bool:
        """Tell whether their boxes meet."""
        (low, high), (other_low, other_high) = self.bounds, other.bounds
        return bool((low < other_high).all() and (other_low < high).all())


def find_things(
    seen: Sequence[tuple[int, Detection]], up: tuple[float, float, float] | Array = (0.0, 0.0, 1.0)
) -> list[Thing]:
    """Return the things that views show, those that most views show first.

    seen: the number of a view and what it shows, of all views. What depth leaves in doubt
    counts where the map says salient. Of more than `MAX_DETECTIONS` those of every few views count.
    up: (3,) unit vector in the world.
    """
    certain = _thinned(
        [(view, one) for view, one in seen if one.is_decided or one.saliency > MIN_SALIENCY]
    )
    groups = group_detections([view for view, _ in certain], [one for _, one in certain])
    things = [Thing([certain[place] for place in group]) for group in groups]
    up = np.asarray(up)
    from_below = sorted(_joined(_by_views(things), _are_one), key=lambda one: one.span(up)[0])
    kept = _by_views(_joined(from_below, lambda lower, upper: _is_under(lower, upper, up)))
    return [thing for thing in kept if not (_is_part(thing, kept) or _is_several(thing, kept))]


def _by_views(things: Sequence[Thing]) -> list[Thing]:
    """Return things in order, the best known first."""
    return sorted(things, key=lambda one: (-one.n_decided, -len(one.views), one.seen[0][0]))


def _joined(things: Sequence[Thing], are_one: Callable[[Thing, Thing], bool]) -> list[Thing]:
    """Return things, each joined to the first before it that it is one with."""
    kept: list[Thing] = []
    for thing in things:
        same = next((i for i, other in enumerate(kept) if are_one(other, thing)), None)
        if same is None:
            kept.append(thing)
        else:
            kept[same] = Thing([*kept[same].seen, *thing.seen])
    return kept


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


def _is_under(lower: Thing, upper: Thing, up: Array) -> bool:
    """Tell whether a thing carries another, that else hung in the air: a foot, and a seat."""
    if lower.support != upper.support or not upper.hangs(up):
        return False
    between = upper.span(up)[0] - lower.span(up)[1]
    if not -MAX_INTO < between < MAX_BETWEEN:
        return False
    return max(_share_over(lower, upper, up), _share_over(upper, lower, up)) > MIN_UNDER


def _share_over(thing: Thing, other: Thing, up: Array) -> float:
    """Return the share of a thing's surface that lies over or under the box around another."""
    pose, size = other.box(up)
    aside = np.abs((centres_of(thing.voxels) - pose[:3, 3]) @ pose[:3, :2])
    return float((aside <= np.array(size[:2]) / 2 + SIDE).all(axis=1).mean())


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
