"""Where views have looked: whether a place is seen free, or something is there, and what it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.voxels import Voxels, centres_of
from curiosight.frame import Camera, Depth, Label, Pose

Array = npt.NDArray[Any]
# Every so many rows and columns of a 640x480 image are kept.
STEP = 8
# Metres, and 1/m with the square of the distance, by which a reading must differ to be behind.
GAP, NOISE = 0.05, 0.01
# Nearer than this, metres, nothing is read.
NEAREST = 0.2
# So many cubes of a surface, evenly, tell enough of it.
ENOUGH = 300
# A view shows a thing if it shows this share of its surface: of most things one sees a side.
MIN_SHOWN = 0.2


class Seen(NamedTuple):
    """Shares of a surface: seen through, so that it is not there now; and seen where it was."""

    free: float
    there: float


class Told(NamedTuple):
    """What all the views that show a surface say of it, whether they make a thing of it or not.

    n_views: that show enough of it. free: share of its looks that see through it. Of those that
    see it, the shares that are salient and not salient by the labels, and the mean of the map, in
    [0, 1]; NaN = there is no map.
    """

    n_views: int
    free: float
    salient: float
    not_salient: float
    saliency: float


@dataclass(frozen=True, slots=True, eq=False)
class _Glimpse:
    """A coarse view: depth, labels and map, (h, w), of every `step`-th row and column."""

    depth: npt.NDArray[np.float16]
    labels: npt.NDArray[np.uint8]
    saliency: npt.NDArray[np.float16]
    camera: Camera
    T_camera_world: Pose
    step: int


class Glimpses:
    """Coarse images of a visit, with the poses that they were taken from."""

    def __init__(self) -> None:
        self._views: list[_Glimpse] = []

    def add(
        self,
        depth: Depth,
        camera: Camera,
        T_world_camera: Pose,
        labels: npt.NDArray[np.uint8],
        saliency: npt.NDArray[np.float32] | None = None,
    ) -> None:
        """Keep a view.

        depth: (H, W) float32 metres, NaN = no reading. labels: (H, W) codes of `Label`. saliency:
        (H, W) in [0, 1]; None = there is no map.
        """
        step = max(1, round(STEP * camera.width / 640))
        coarse = depth[::step, ::step].astype(np.float16)
        self._views.append(
            _Glimpse(
                coarse,
                labels[::step, ::step].copy(),
                np.full(coarse.shape, np.nan, np.float16)
                if saliency is None
                else saliency[::step, ::step].astype(np.float16),
                camera,
                np.linalg.inv(T_world_camera).astype(np.float64),
                step,
            )
        )

    def look_for(self, voxels: Voxels) -> Seen:
        """Return of which shares of a surface views saw that it is free, or that it is there.

        A floor, a table or a wall where it would be is free, too: what is flat hardly rises over
        it. What lies before it, or at the border, tells nothing.
        """
        n_free, n_there = np.zeros((2, len(voxels)), np.int64)
        for view, places, where, behind, gap in self._looks(voxels):
            is_known = view.labels[places] == Label.NOT_SALIENT
            n_free[where] += (behind > gap) | ((np.abs(behind) <= gap) & is_known)  # NaN: false
            n_there[where] += (np.abs(behind) <= gap) & ~is_known
        if not len(voxels):
            return Seen(0.0, 0.0)
        is_free = n_free > n_there
        is_there = (n_there > 0) & ~is_free
        return Seen(float(is_free.mean()), float(is_there.mean()))

    def ask_about(self, voxels: Voxels) -> Told:
        """Return what all views that show a surface say of it."""
        voxels = voxels[:: max(1, len(voxels) // ENOUGH)]
        n_views, n_free = 0, 0
        labels, saliency = [np.zeros(0, np.uint8)], [np.zeros(0)]
        for view, places, _, behind, gap in self._looks(voxels):
            is_there = np.abs(behind) <= gap
            n_free += int(np.count_nonzero(behind > gap))
            n_views += bool(np.count_nonzero(is_there) >= MIN_SHOWN * len(voxels))
            labels.append(view.labels[places][is_there])
            saliency.append(view.saliency[places][is_there].astype(np.float64))
        told = np.concatenate(labels)
        n_there = max(1, len(told))
        return Told(
            n_views,
            n_free / max(1, n_free + len(told)),
            np.count_nonzero(told == Label.SALIENT) / n_there,
            np.count_nonzero(told == Label.NOT_SALIENT) / n_there,
            float(np.concatenate(saliency).mean()) if len(told) else np.nan,
        )

    def _looks(
        self, voxels: Voxels
    ) -> Iterator[tuple[_Glimpse, tuple[Array, Array], Array, Array, Array]]:
        """Yield each view that a surface is in the image of, with what it reads there.

        That is: rows and columns, which cubes those are of, the metres by which what is read lies
        behind the cube, and how far it must to be something else.
        """
        points = centres_of(voxels)
        for view in self._towards(points):
            rotation, camera = view.T_camera_world[:3, :3], view.camera
            x, y, z = (points @ rotation.T + view.T_camera_world[:3, 3]).T
            is_before = z > NEAREST
            if not is_before.any():
                continue
            z = np.where(is_before, z, 1.0)
            u = np.rint((x / z * camera.fx + camera.cx) / view.step).astype(np.int64)
            v = np.rint((y / z * camera.fy + camera.cy) / view.step).astype(np.int64)
            height, width = view.depth.shape
            where = np.flatnonzero(is_before & (u >= 0) & (u < width) & (v >= 0) & (v < height))
            if len(where):
                places = v[where], u[where]
                behind = view.depth[places].astype(np.float64) - z[where]
                yield view, places, where, behind, GAP + NOISE * z[where] ** 2

    def _towards(self, points: Array) -> list[_Glimpse]:
        """Return the views that may have some of (n, 3) points in the image."""
        if not self._views or not len(points):
            return []
        low, high = points.min(0), points.max(0)
        centre, reach = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
        poses = np.stack([view.T_camera_world for view in self._views])
        x, y, z = (poses[:, :3, :3] @ centre + poses[:, :3, 3]).T
        widest = np.array([_slopes(view) for view in self._views]).T
        # Of a ball around them the nearest point to the pyramid that a view sees.
        is_seen = z > NEAREST - reach
        for across, slope in zip((x, y), widest, strict=True):
            is_seen &= np.abs(across) - slope * z < reach * np.hypot(1.0, slope)
        return [view for view, is_one in zip(self._views, is_seen, strict=True) if is_one]


def _slopes(view: _Glimpse) -> tuple[float, float]:
    """Return how far to either side, and up or down, a view sees, a metre ahead, or farther."""
    camera, step = view.camera, view.step
    across = (max(camera.cx, camera.width - camera.cx) + step) / camera.fx
    down = (max(camera.cy, camera.height - camera.cy) + step) / camera.fy
    return across, down
