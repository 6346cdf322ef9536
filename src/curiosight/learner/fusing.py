"""What is remembered and what depth says now, as one map of probability.

Both are odds that a pixel is salient. What the teacher finds in depth is a factor on the odds of
memory: how much likelier something salient gets such a verdict than anything else, among what
memory holds for equally likely. So a verdict of "unknown" counts, too: what the image cuts is
often an object, what stands under a table seldom. And since depth tells what is one piece, memory
is asked about each piece as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from curiosight.frame import Label
from curiosight.teacher.segmented import CODE_OF, Segmentation

Map = npt.NDArray[np.float32]

# Natural logarithms of the factors, by what `Segmentation.reasons` tells, as measured in drawn
# rooms (`benchmarks/fusing.py`); 0 for any other.
LOG_ODDS: Mapping[str, float] = {
    "object": 4.0,
    "touches the image border": 1.0,
    "belongs to a wall": 0.8,
    "hardly rises over its support": 0.7,
    "reaches beyond the range": 0.3,
    "in no cluster": 0.3,
    "seat, bed or shelf": -0.4,
    "too large": -1.9,
    "belongs to a piece of furniture": -2.0,
    "table": -2.2,
    "floor": -2.4,
    "under a table": -2.4,
    "wall": -3.1,
    # Labels without supports, as of masks: not salient, no more is known.
    "known": -2.4,
}
# How far a pixel is judged by the piece that it is of, not by itself.
OF_PIECE = 0.8
# What memory is taken to say while nothing was learned: about as much of a view is salient.
PRIOR = 0.1
# Memory is never surer than this: a vote of all trees is no proof.
MOST_SURE = 0.998
# And it denies an object that is seen no more than so, in the logarithm of odds: what is unlike
# anything seen gets the votes of whatever is nearest.
MOST_AGAINST = 3.0


def fuse(remembered: Map, segmentation: Segmentation) -> Map:
    """Return the (H, W) probability that each pixel is salient, by memory and by depth.

    remembered: (H, W) in [0, 1], the probability by memory alone.
    """
    if segmentation.labels.shape != remembered.shape:
        expected, found = remembered.shape, segmentation.labels.shape
        raise ValueError(f"segmentation: expected {expected} labels, got {found}")
    odds = odds_of_pieces(remembered, segmentation.cluster_of_pixel)
    is_object = segmentation.labels == Label.SALIENT
    odds[is_object] = np.maximum(odds[is_object], -MOST_AGAINST)
    fused = 1 / (1 + np.exp(-odds - log_odds(segmentation)))
    is_told = segmentation.labels != Label.UNAVAILABLE
    return np.where(is_told, fused, remembered).astype(np.float32)


def odds_of_pieces(remembered: Map, piece_of_pixel: npt.NDArray[np.uint16]) -> Map:
    """(H, W): logarithms of the odds by memory, drawn to the mean of the piece each is of.

    piece_of_pixel: (H, W), 0 = of none.
    """
    likely = np.clip(remembered, 1 - MOST_SURE, MOST_SURE)
    odds = np.log(likely / (1 - likely))
    pieces = piece_of_pixel.ravel()
    mean = np.bincount(pieces, odds.ravel()) / np.maximum(np.bincount(pieces), 1)
    drawn = (1 - OF_PIECE) * odds + OF_PIECE * mean.astype(np.float32)[piece_of_pixel]
    return np.asarray(np.where(piece_of_pixel > 0, drawn, odds))


def log_odds(segmentation: Segmentation) -> Map:
    """(H, W): what the verdict on each pixel adds to the logarithm of its odds."""
    added = np.zeros(256, np.float32)
    for reason, amount in LOG_ODDS.items():
        added[CODE_OF[reason]] = amount
    of_pixel: Map = added[segmentation.reasons()]
    return of_pixel


def is_seen(segmentation: Segmentation) -> npt.NDArray[np.bool_]:
    """(H, W): where depth tells what is salient and what is not; elsewhere it is remembered."""
    labels = segmentation.labels
    seen: npt.NDArray[np.bool_] = (labels == Label.SALIENT) | (labels == Label.NOT_SALIENT)
    return seen
