"""How sure the teacher is of each label: doubt as a value."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Label
from curiosight.teacher.cloud.planes import noise_band
from curiosight.teacher.cloud.points import Points, observe_points, scale_of
from curiosight.teacher.segmented import Segmentation
from curiosight.teacher.settings import SegmentationSettings

Array = npt.NDArray[Any]
# Depth rounded to millimetres, and surfaces that are not flat, metres.
LEAST_NOISE = 0.005
# A cluster of so many pixels of a 640x480 image is as likely noise as not.
DOUBTFUL_PIXELS = 200


def measure_confidence(
    frame: Frame, segmentation: Segmentation, settings: SegmentationSettings
) -> npt.NDArray[np.float32]:
    """(H, W) float32 in [0, 1]: how far the evidence for a label is from saying another.

    It is 1 - exp(-m / noise), where m is the distance in metres from the threshold that would
    change the label: for a support or a wall that of its band, for an object how far it rises
    over its support and stands before the walls. Small objects count less, by n / (n + 200), in
    pixels of a 640x480 image. What is unknown or unavailable has 0.

    settings: those of the teacher, for its sensor.
    """
    confidence = np.zeros(frame.rgb.shape[:2], np.float32)
    if frame.depth is None or frame.camera is None or not segmentation.supports:
        return confidence
    scale = scale_of(frame.camera)
    stride = settings.stride_at(scale)
    points = observe_points(frame.depth, frame.camera, stride=stride)
    on, off = _margins(points, segmentation, settings)
    noise = noise_band(points.depth, LEAST_NOISE, settings.noise)
    height, width = frame.depth.shape
    for label, margin in ((Label.NOT_SALIENT, on), (Label.SALIENT, off)):
        sure = 1 - np.exp(-np.maximum(margin, 0) / noise)
        full = cv2.resize(np.nan_to_num(sure), (width, height), interpolation=cv2.INTER_NEAREST)
        is_labelled = segmentation.labels == label
        confidence[is_labelled] = full[is_labelled]
    n_pixels = np.array([np.inf, *(c.n_pixels for c in segmentation.clusters)])
    is_salient = segmentation.labels == Label.SALIENT
    of_cluster = 1 / (1 + DOUBTFUL_PIXELS * scale**2 / n_pixels)
    confidence[is_salient] *= of_cluster[segmentation.cluster_of_pixel[is_salient]]
    return confidence


def _margins(
    points: Points, segmentation: Segmentation, settings: SegmentationSettings
) -> tuple[Array, Array]:
    """(h, w) metres by which each point is inside a support or a wall, and outside of all."""
    on = np.full(points.depth.shape, -np.inf, np.float32)
    off = np.full(points.depth.shape, np.inf, np.float32)
    for support in segmentation.supports:
        depth_in = noise_band(points.depth, support.settings.slab, settings.noise)
        depth_in -= np.abs(support.heights)
        if support.extent is not None:
            depth_in[~support.extent] = -np.inf
        on, off = np.fmax(on, depth_in), np.fmin(off, -depth_in)
    for wall in segmentation.walls:
        if wall.inliers.any():
            distance = np.abs(wall.distances(points))
            is_straight = wall.near(
                points, np.isfinite(points.depth), np.full_like(distance, np.inf), min_facing=0
            )
            depth_in = np.where(is_straight, settings.wall_gap - distance, -np.inf)
            on, off = np.fmax(on, depth_in), np.fmin(off, -depth_in)
    return on, off
