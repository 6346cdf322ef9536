"""All that is told of the pixels of one image, and the camera that it takes to use its depth."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Frame, Pose, Rgb

Map = npt.NDArray[np.float32]
Size = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Maps:
    """What is told of an image's pixels, each (H, W).

    saliency: float32 in [0, 1]; above 0.5 is what to call salient, for the best F1.
    probability: float32 in [0, 1], the share of such pixels that is salient.
    is_seen: bool, where the depth at hand shows it; elsewhere it is remembered.
    uncertainty: float32 in [0, 1], of what is remembered: trees and experts contradict each
        other, or it is unlike anything seen; None where it was not asked for.
    """

    saliency: Map
    probability: Map
    is_seen: npt.NDArray[np.bool_]
    uncertainty: Map | None = None


class Cameras:
    """The cameras of the frames that were learned from: the last one of each image size."""

    def __init__(self, cameras: Iterable[Camera] = ()) -> None:
        self._of_size: dict[Size, Camera] = {}
        for camera in cameras:
            self.note(camera)

    def note(self, camera: Camera) -> None:
        self._of_size[camera.height, camera.width] = camera

    def note_all(self, others: Cameras) -> None:
        self._of_size.update(others._of_size)

    def frame(
        self, rgb: Rgb, depth: Depth, T_world_camera: Pose | None, camera: Camera | None
    ) -> Frame:
        """Return an image with its depth as a frame; ValueError where no camera is known of it."""
        camera = camera or self._of_size.get((rgb.shape[0], rgb.shape[1]))
        if camera is None:
            known = ", ".join(f"{width}x{height}" for height, width in self._of_size) or "none"
            size = f"{rgb.shape[1]}x{rgb.shape[0]}"
            raise ValueError(f"camera: expected one for {size}, got None (learned from: {known})")
        return Frame("now", rgb, depth, camera, T_world_camera)

    def tables(self) -> list[dict[str, Any]]:
        """Return them JSON-able."""
        return [asdict(camera) for camera in self._of_size.values()]

    @classmethod
    def of_tables(cls, tables: Iterable[dict[str, Any]]) -> Cameras:
        """Return what `tables` told; TypeError or ValueError for anything else."""
        return cls(
            Camera(**table | {"depth_window": window and tuple(window)})
            for table in tables
            for window in [table.get("depth_window")]
        )
