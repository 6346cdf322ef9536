"""Where objects end in the image, as masks that another program drew say."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth, Label
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.things.verdicts import Verdict

Array = npt.NDArray[Any]
# A region is an object's where so much of what depth knows in it belongs to that.
MIN_OWNED = 0.6
# And it must be seen in so much of the whole: a window in which hardly anything has depth but the
# edge of what stands before it is no object.
MIN_SEEN = 0.3
# With less owned, the mask is drawn loosely: what is open beside the object is likely not its own.
MIN_TIGHT = 0.8
# Of an object, so much in another one's region is a ragged edge.
MAX_EDGE = 0.2


def follow_masks(found: Segmentation, regions: Array, depth: Depth) -> Segmentation:
    """Give an object what depth leaves open in its region of the masks: holes, torn edges.

    So it gets what depth counts to the object beside it, where the two end in one surface. What
    depth knows of supports, walls and other things stays as it is.

    regions: (H, W) int32, a number an instance of the masks, 0 = none. depth: (H, W) metres.
    """
    is_object = np.array([False, *(c.verdict is Verdict.OBJECT for c in found.clusters)])
    if not is_object.any() or not regions.any():
        return found
    owner, is_tight, is_edge = _owners(found, regions, is_object)
    wanted = owner.take(regions)
    is_open = np.isnan(depth) | (found.labels == Label.UNKNOWN)
    is_open &= (found.cluster_of_pixel == 0) | (found.cluster_of_pixel == wanted)
    is_open &= is_tight.take(regions)
    given = (wanted > 0) & (is_open | is_edge[found.cluster_of_pixel, regions])
    labels, number = found.labels.copy(), found.cluster_of_pixel.copy()
    labels[given] = Label.SALIENT
    number[given] = wanted[given]
    return replace(found, labels=labels, cluster_of_pixel=number)


def _owners(found: Segmentation, regions: Array, is_object: Array) -> tuple[Array, Array, Array]:
    """Return the (n_regions,) cluster that each region is the mask of, 0 = of no object.

    And (n_regions,) bool, whether it shows hardly anything else; and (n_clusters + 1, n_regions)
    bool: of an object, only its ragged edge is in the region.
    """
    n_regions, n_clusters = int(regions.max()) + 1, len(is_object)
    is_salient = found.labels == Label.SALIENT
    is_known = (found.labels == Label.NOT_SALIENT) | (found.cluster_of_pixel > 0)
    n_known = np.bincount(regions[is_known], minlength=n_regions)
    place = found.cluster_of_pixel.astype(np.int64) * n_regions + regions
    counts = np.bincount(place[is_salient], minlength=n_clusters * n_regions)
    counts = counts.reshape(n_clusters, n_regions)
    owner = counts.argmax(axis=0)
    share = counts.max(axis=0) / np.maximum(n_known, 1)
    n_pixels = np.bincount(regions.ravel(), minlength=n_regions)
    owner[(share < MIN_OWNED) | (counts.max(axis=0) < MIN_SEEN * n_pixels)] = 0
    owner[0] = 0
    is_edge = is_object[:, None] & (counts <= MAX_EDGE * counts.sum(axis=1, keepdims=True))
    return owner.astype(np.uint16), share >= MIN_TIGHT, is_edge & (owner > 0)
