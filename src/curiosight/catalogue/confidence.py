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
FIRST = -0.64
WEIGHTS = {
    # E-folds of views, and of those that show it with 400 pixels and with 1000, see `SHOWN_PX`.
    "views": 0.45,
    "shown": 0.4,
    "shown_well": 0.7,
    # E-folds of metres.
    "width": 1.89,
    "length": -1.05,
    "height": -1.12,
    # Shares: of it in a better known thing, of that in it, and of its views that show both.
    "in_other": -5.9,
    "other_in": 3.71,
    "apart": -2.17,
    # E-folds of the share of the views that show its place; shares of what those say of it.
    "of_shown": 0.95,
    "salient": 1.6,
    "not_salient": -6.01,
    # Whether it stands on a floor; mean share of it that its views find.
    "on_floor": -1.3,
    "agreed": 2.68,
}
# A view shows a thing, or shows it well, by so many pixels in an image of `IMAGE_PX`.
SHOWN_PX, SHOWN_WELL_PX, IMAGE_PX = 400, 1000, 640 * 480
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
        scale = IMAGE_PX / n_image_pixels[place]
        measures[place] = [
            np.log(n_views),
            np.log(_n_views_with(thing, SHOWN_PX / scale) + 0.5),
            np.log(_n_views_with(thing, SHOWN_WELL_PX / scale) + 0.5),
            *np.log(np.maximum(sizes[place], THIN)),
            *_inside(thing, better),
            np.log((n_views + 0.5) / (told.n_views + 1)),
            told.salient,
            told.not_salient,
            thing.support == "floor",
            np.mean([share_in(thing.voxels, grown(one.voxels)) for _, one in thing.seen]),
        ]
    return measures


def _n_views_with(thing: Thing, n_pixels: float) -> int:
    """Return how many views show so much of a thing."""
    return len({view for view, one in thing.seen if one.n_pixels >= n_pixels})


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
