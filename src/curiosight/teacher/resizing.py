"""Bring a frame to its depth's own size, and what was found in it back to the colour image's.

Depth of a small sensor is often brought to the size of a larger colour image, each reading many
times. What is then seen is the small image: labels follow its readings.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.frame import Frame
from curiosight.teacher.cloud.repeats import Repeats, find_repeats
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.things.verdicts import Cluster


def repeats_in(frame: Frame, known: Repeats | None = None) -> Repeats | None:
    """Return how a frame's depth repeats its readings; None where it does not.

    known: in other frames of the recording; None = not known.
    """
    if frame.depth is None or frame.camera is None:
        return None
    if known is None or known.full_shape != frame.depth.shape:
        known = find_repeats(frame.depth)
    return None if known.shape == known.full_shape else known


def in_own_size(frame: Frame, repeats: Repeats | None) -> Frame:
    """Return a frame as its depth's own size shows it, without its colours."""
    if repeats is None or frame.depth is None or frame.camera is None:
        return frame
    height, width = repeats.shape
    return replace(
        frame,
        rgb=np.broadcast_to(np.uint8(0), (height, width, 3)),
        depth=repeats.pick(frame.depth),
        camera=scaled_camera(frame.camera, (width, height)),
    )


def in_full_size(found: Segmentation, repeats: Repeats | None) -> Segmentation:
    """Return what was found in a frame of its depth's own size, for all pixels.

    Supports and walls stay on the grid that they were found on.
    """
    if repeats is None:
        return found
    clusters = tuple(_enlarged(cluster, repeats) for cluster in found.clusters)
    return replace(found.with_images(repeats.repeat), clusters=clusters)


def found_in_own_size(found: Segmentation, repeats: Repeats | None) -> Segmentation:
    """Return what `in_full_size` did before it enlarged it."""
    if repeats is None:
        return found
    per_pixel = np.prod(repeats.shape) / np.prod(repeats.full_shape)
    clusters = tuple(
        replace(cluster, n_pixels=round(cluster.n_pixels * per_pixel)) for cluster in found.clusters
    )
    return replace(found.with_images(repeats.pick), clusters=clusters)


def picked(image: npt.NDArray[Any], repeats: Repeats | None) -> npt.NDArray[Any]:
    """Return of an (H, W) image one pixel of each reading's block."""
    return image if repeats is None else repeats.pick(image)


def _enlarged(cluster: Cluster, repeats: Repeats) -> Cluster:
    u_min, v_min, u_max, v_max = cluster.box
    left, right = np.searchsorted(repeats.columns, (u_min, u_max)).tolist()
    top, bottom = np.searchsorted(repeats.rows, (v_min, v_max)).tolist()
    factor = np.prod(repeats.full_shape) / np.prod(repeats.shape)
    n_pixels = round(float(cluster.n_pixels * factor))
    return replace(cluster, box=(left, top, right, bottom), n_pixels=n_pixels)
