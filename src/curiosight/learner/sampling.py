"""Which labelled pixels of a frame are learned from (sec. II-A.3)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Label
from curiosight.learner.description import Labels

Array = npt.NDArray[Any]
Pixels = npt.NDArray[np.int32]


def draw_pixels(
    labels: Labels,
    n_pixels: int,
    rng: np.random.Generator,
    *,
    blind_share: float = 0.0,
    salient_share: float = 0.0,
) -> tuple[Pixels, npt.NDArray[np.bool_]]:
    """Draw pixels of (h, w) labels without replacement, in random order: where, and how labelled.

    n_pixels: how many; fewer where fewer are known. blind_share, salient_share: see
    `SaliencyLearner`; those of the former are not salient.

    Return (n,) indices of the flat image, and whether each is salient.
    """
    flat = labels.ravel()
    salient = find_labels(flat, Label.SALIENT)
    n_known = len(salient) + int(np.count_nonzero(flat == Label.NOT_SALIENT))
    n_drawn: int = min(n_pixels, n_known)
    n_salient = min(round(salient_share * n_drawn), len(salient))
    if n_salient * n_known <= n_drawn * len(salient):  # there are as many by chance
        drawn = _draw(find_labels(flat, Label.SALIENT, Label.NOT_SALIENT), n_drawn, rng)
    else:
        other = find_labels(flat, Label.NOT_SALIENT)
        n_other = min(n_drawn - n_salient, len(other))
        both = [_draw(salient, n_salient, rng), _draw(other, n_other, rng)]
        drawn = rng.permutation(np.concatenate(both))
    if blind_share:
        blind = find_labels(flat, Label.UNAVAILABLE)
        n_blind = min(round(blind_share * n_drawn), len(blind))
        drawn = np.concatenate([drawn[n_blind:], _draw(blind, n_blind, rng)])
    return drawn, flat[drawn] == Label.SALIENT


def find_labels(flat: Labels, one: Label, other: Label | None = None) -> Pixels:
    """Return the indices of what has a label, or one of two, in their order."""
    second = one if other is None else other
    return np.asarray(_find_values(flat, np.uint8(one), np.uint8(second)))


@njit(cache=True, nogil=True)
def _find_values(values: Array, one: np.uint8, other: np.uint8) -> Array:
    found, n_found = np.empty(values.size, np.int32), 0
    for place in range(values.size):
        found[n_found] = place
        n_found += int((values[place] == one) | (values[place] == other))
    return found[:n_found].copy()


def _draw(pixels: Pixels, n: int, rng: np.random.Generator) -> Pixels:
    return rng.choice(pixels, n, replace=False) if n else pixels[:0]
