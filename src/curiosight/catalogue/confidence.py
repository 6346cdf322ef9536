"""How sure it is that an entry is one thing, whole, and where the catalogue says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.glimpses import Glimpses
from curiosight.catalogue.things import Thing
from curiosight.catalogue.voxels import grown, share_in

Array = npt.NDArray[Any]
# What is known of a thing, and what each tells as log-odds: fitted by logistic regression on drawn
# homes, see benchmarks/objects_fit.py.
FIRST = -0.07
WEIGHTS = {
    # E-folds of views, of those in which depth decided, and of pixels of its best view (of 1000 in
    # a 640x480 image).
    "views": 1.08,
    "decided": 0.15,
    "pixels": 0.17,
    # E-folds of metres.
    "width": 1.85,
    "length": -1.01,
    "height": -0.79,
    # Shares: of it in a better known thing, of that in it, and of its views that show both.
    "in_other": -5.7,
    "other_in": 3.48,
    "apart": -2.23,
    # E-folds of the share of the views that show its place; shares of what those say of it.
    "of_shown": 0.82,
    "salient": 1.67,
    "not_salient": -5.22,
    # Whether it stands on a floor; mean share of it that its views find.
    "on_floor": -1.51,
    "agreed": 2.2,
}
# No thing is thinner, by the cubes that it is made of; metres.
THIN = 0.03
# Nothing is surer than this.
LEAST = 1e-6


def odds_of(share: float) -> float:
    """Return the log-odds of a share in [0, 1]; of one that is none or all, of nearly so."""
    share = min(max(share, LEAST), 1 - LEAST)
    return float(np.log(share / (1 - share)))


def share_of(odds: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the shares in [0, 1] of log-odds, of the same shape."""
    shares: npt.NDArray[np.float64] = 1 / (1 + np.exp(-np.asarray(odds)))
    return shares


def confidence_of(measures: Array) -> npt.NDArray[np.float64]:
    """Return (n,) shares in [0, 1]: of such entries, about so many are right.

    measures: (n, 14), see `measure_things`.
    """
    return share_of(FIRST + measures @ np.array(list(WEIGHTS.values())))


def measure_things(
    things: Sequence[Thing],
    sizes: Sequence[tuple[float, float, float]],
    n_image_pixels: Sequence[int],
    glimpses: Glimpses,
) -> npt.NDArray[np.float64]:
    """Return (n, 14) what is known of each thing of a visit, in the order of `WEIGHTS`.

    sizes: metres, width, length, height. n_image_pixels: of the whole image that shows most of it.
    """
    order = sorted(range(len(things)), key=lambda place: _known(things[place]), reverse=True)
    measures = np.zeros((len(things), len(WEIGHTS)))
    for rank, place in enumerate(order):
        better = [things[other] for other in order[:rank]]
        thing, n_views = things[place], len(things[place].views)
        told = glimpses.ask_about(thing.voxels)
        n_pixels = thing.best[1].n_pixels * 640 * 480 / n_image_pixels[place]
        measures[place] = [
            np.log(n_views),
            np.log(thing.n_decided + 0.5),
            np.log(n_pixels / 1000),
            *np.log(np.maximum(sizes[place], THIN)),
            *_inside(thing, better),
            np.log((n_views + 0.5) / (told.n_views + 1)),
            told.salient,
            told.not_salient,
            thing.support == "floor",
            np.mean([share_in(thing.voxels, grown(one.voxels)) for _, one in thing.seen]),
        ]
    return measures


def _known(thing: Thing) -> tuple[int, int, int]:
    return thing.n_decided, len(thing.views), len(thing.voxels)


def _inside(thing: Thing, others: Sequence[Thing]) -> tuple[float, float, float]:
    """Return shares of the one of others that shares most: in it, of it, and of common views."""
    shares = [
        (share_in(thing.voxels, other.grown), share_in(other.voxels, thing.grown), other)
        for other in others
        if other.is_near(thing)
    ]
    if not shares:
        return 0.0, 0.0, 0.0
    here, there, most = max(shares, key=lambda one: one[0] + one[1])
    if not here + there:
        return 0.0, 0.0, 0.0
    return here, there, len(thing.views & most.views) / len(thing.views)
