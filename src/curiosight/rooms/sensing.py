"""The depth sensors that a room can be looked at with."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth
from curiosight.rooms.depth_sensor import kinect_depth
from curiosight.rooms.lidar_sensor import lidar_depth
from curiosight.rooms.renderer import Rendering
from curiosight.rooms.settings import SensorName
from curiosight.rooms.stereo_sensor import stereo_depth


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What a sensor gives, as it would be stored.

    depth: (h, w) float32 metres along z, of its own size but colour's shape; NaN = nothing.
    confidence: (h, w) uint8, 0 = none to 2 = high; None where the sensor does not tell.
    """

    depth: Depth
    confidence: npt.NDArray[np.uint8] | None = None

    def registered(self, camera: Camera) -> Depth:
        """Return depth of colour's size, (H, W): the nearest reading, none of confidence 0."""
        depth = self.depth
        if self.confidence is not None:
            depth = np.where(self.confidence > 0, depth, np.float32(np.nan))
        size = (camera.width, camera.height)
        if depth.shape[::-1] == size:
            return depth
        fitted: Depth = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST_EXACT)
        return fitted


def sense(
    sensor: SensorName, rendering: Rendering, camera: Camera, rng: np.random.Generator
) -> Readings:
    """Return what a sensor reads of what a perfect one would see."""
    seen = rendering.depth, rendering.cosine, rendering.infrared
    if sensor == "kinect":
        return Readings(kinect_depth(*seen, camera, rng))
    if sensor == "stereo":
        return Readings(stereo_depth(*seen, rendering.radiance, camera, rng))
    if sensor == "lidar":
        reading = lidar_depth(*seen, camera, rng)
        return Readings(reading.depth, reading.confidence)
    return Readings(rendering.depth)
