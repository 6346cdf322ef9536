"""The last stage: things, supports and walls to a label for every pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth, Label
from curiosight.teacher.cloud.points import spread
from curiosight.teacher.segmented import CODE_OF, FOUND_AS, UNDER_TABLE, WALL, Segmentation
from curiosight.teacher.supports.slab import ON, ON_DOUBTFUL, ON_FLOOR, under_tables
from curiosight.teacher.supports.supports import FLOOR
from curiosight.teacher.things.objects import Things
from curiosight.teacher.things.verdicts import Cluster, Verdict
from curiosight.teacher.walls.surroundings import Surroundings

Array = npt.NDArray[Any]
CODE_OF_KIND = np.zeros(ON_DOUBTFUL + 1, np.uint8)
CODE_OF_KIND[ON_FLOOR] = CODE_OF[FLOOR]
CODE_OF_KIND[[*ON.values()]] = [CODE_OF[FOUND_AS[kind]] for kind in ON]


def label_pixels(things: Things, depth: Depth) -> Segmentation:
    """Return what is salient, what is not, and what is unknown.

    Objects are salient, supports and walls are not; a doubtful support is unknown, and what an
    object encloses, which may be its bottom. What has no reading or lies beyond the range is
    unavailable.

    depth: (H, W) metres, the image that the points are of.
    """
    around = things.around
    labels = _label_of(things.clusters).take(things.number)
    labels[(around.is_support & (things.hollows == 0)) | around.is_wall] = Label.NOT_SALIENT
    labels[around.kinds == ON_DOUBTFUL] = Label.UNKNOWN
    labels, found, number = spread(
        # One number a point, so that all that is told of it goes to the same pixels.
        ((things.number + things.hollows) << 16) | (_found(around).astype(np.int32) << 8) | labels,
        around.points.depth,
        depth,
        around.points.stride,
        max_depth=around.settings.max_range,
        beyond=Label.UNAVAILABLE,
    )
    return Segmentation(
        labels,
        number,
        tuple(things.clusters),
        tuple(around.supports),
        tuple(around.walls),
        found=found,
    )


def _label_of(clusters: list[Cluster]) -> npt.NDArray[np.uint8]:
    """Return the label of what is in no cluster, and of each cluster."""
    are_objects = [cluster.verdict is Verdict.OBJECT for cluster in clusters]
    return np.where([False, *are_objects], Label.SALIENT, Label.UNKNOWN).astype(np.uint8)


def _found(around: Surroundings) -> Array:
    """(h, w) uint8, what `Segmentation.found` says, on the grid."""
    found = CODE_OF_KIND.take(around.kinds)
    tables = [support for support in around.supports if support.is_table]
    if tables:
        found[under_tables(around.points, tables) & (found == 0)] = CODE_OF[UNDER_TABLE]
    found[around.is_wall] = CODE_OF[WALL]
    return found
