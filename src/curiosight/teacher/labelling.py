"""The last stage: things, supports and walls to a label for every pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Depth, Label
from curiosight.teacher.cloud.points import spread
from curiosight.teacher.segmented import CODE_OF, FOUND_AS, UNDER_TABLE, WALL, Segmentation
from curiosight.teacher.supports.slab import ON, ON_DOUBTFUL, ON_FLOOR, under_tables
from curiosight.teacher.supports.supports import FLOOR
from curiosight.teacher.things.objects import Things
from curiosight.teacher.things.verdicts import Cluster, Verdict

Array = npt.NDArray[Any]
NOT_SALIENT, UNKNOWN = np.uint8(Label.NOT_SALIENT), np.uint8(Label.UNKNOWN)
# What follows the kinds of support in the list of codes.
ON_WALL, BELOW = ON_DOUBTFUL + 1, ON_DOUBTFUL + 2
CODE_OF_KIND = np.zeros(BELOW + 1, np.uint8)
CODE_OF_KIND[[ON_FLOOR, ON_WALL, BELOW]] = [CODE_OF[one] for one in (FLOOR, WALL, UNDER_TABLE)]
CODE_OF_KIND[[*ON.values()]] = [CODE_OF[FOUND_AS[kind]] for kind in ON]


def label_pixels(things: Things, depth: Depth) -> Segmentation:
    """Return what is salient, what is not, and what is unknown.

    Objects are salient, supports and walls are not; a doubtful support is unknown, and what an
    object encloses, which may be its bottom. What has no reading or lies beyond the range is
    unavailable.

    depth: (H, W) metres, the image that the points are of.
    """
    around = things.around
    labels, found, number = spread(
        _packed(things),
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


def _packed(things: Things) -> Array:
    """(h, w) int32: label, what was found and number of cluster of each point, see `spread`.

    They are one number, so that all that is told of a point goes to the same pixels.
    """
    around = things.around
    packed = np.empty(things.number.shape, np.int32)
    _pack(
        things.number,
        things.hollows,
        around.kinds,
        under_tables(around.points, around.supports),
        around.is_wall,
        _label_of(things.clusters),
        CODE_OF_KIND,
        packed,
    )
    return packed


@njit(cache=True, nogil=True, error_model="numpy")
def _pack(
    number: Array,
    hollows: Array,
    kinds: Array,
    is_under: Array,
    is_wall: Array,
    label_of: Array,
    code_of: Array,
    packed: Array,
) -> None:
    """Set what `_packed` returns; all are (h, w) but `label_of` numbers and `code_of` kinds."""
    for v in range(number.shape[0]):
        for u in range(number.shape[1]):
            label, code, hollow = label_of[number[v, u]], code_of[kinds[v, u]], hollows[v, u]
            if is_wall[v, u]:
                label, code = NOT_SALIENT, code_of[ON_WALL]
            elif kinds[v, u] == ON_DOUBTFUL:
                label = UNKNOWN
            elif code > 0:
                label = NOT_SALIENT if hollow == 0 else label
            elif is_under[v, u]:
                code = code_of[BELOW]
            packed[v, u] = (number[v, u] + hollow) << 16 | np.int32(code) << 8 | label
