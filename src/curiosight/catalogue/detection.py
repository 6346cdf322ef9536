"""What one view shows of a thing: its points in the world, its hues, what it stands on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.catalogue.hues import Hues, count_hues
from curiosight.catalogue.voxels import Voxels, voxels_of
from curiosight.frame import Camera, Frame, Label, Pose
from curiosight.teacher import Cluster, Segmentation, Verdict
from curiosight.teacher.turning import rotation_of

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

# What one view leaves in doubt because of how it looks at it; the map may know it.
UNDECIDED = frozenset({Verdict.CUT, Verdict.FAR, Verdict.SMALL, Verdict.FLAT})
# Of a thing without a cluster, as masks tell it: pixels of a 640x480 image, and the step in depth
# that parts two things, metres.
MIN_MASK_PX, STEP_M = 400, 0.05
# Readings at a thing's edge lie between it and what is behind: so many of them are left out.
EDGE_PX = 1


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """What one view shows of a thing.

    box: (x, y, width, height) in pixels. mask: (height, width) bool, inside the box.
    voxels: of its surface in the world, see `voxels_of`.
    hues: (972,) float32, how many of its pixels have each, see `count_hues`.
    base: metres along up at which it stands; NaN = not known. support: what it stands on.
    distance: median metres along z.
    is_decided: depth says that it is a thing; else only a map can.
    saliency: mean of the map, in [0, 1]; NaN = there is no map.
    """

    box: tuple[int, int, int, int]
    mask: Mask
    voxels: Voxels
    hues: Hues
    base: float
    support: str
    distance: float
    is_decided: bool
    saliency: float

    @property
    def n_pixels(self) -> int:
        return int(np.count_nonzero(self.mask))


def find_detections(
    frame: Frame,
    segmentation: Segmentation,
    saliency: npt.NDArray[np.float32] | None = None,
    *,
    up_world: Array | None = None,
) -> list[Detection]:
    """Return what a posed frame shows of things, as its teacher segmented it.

    saliency: (H, W) in [0, 1], a map of the frame. up_world: (3,) unit vector; None = as the
    supports have it.

    Raises ValueError for a frame without a pose; one without depth shows nothing.
    """
    pose = frame.T_world_camera
    if pose is None:
        raise ValueError(f"frame: expected one with a pose, got {frame.id} without")
    if frame.depth is None or frame.camera is None or segmentation.problem is not None:
        return []
    if not segmentation.clusters:
        return [
            _detection(frame, mask, offset, saliency, None, segmentation, up_world)
            for mask, offset in _salient_pieces(frame, segmentation)
        ]
    found = []
    for number, cluster in enumerate(segmentation.clusters, start=1):
        is_decided = cluster.verdict is Verdict.OBJECT
        if not is_decided and (saliency is None or cluster.verdict not in UNDECIDED):
            continue
        u_min, v_min, u_max, v_max = cluster.box
        here = segmentation.cluster_of_pixel[v_min:v_max, u_min:u_max] == number
        if here.any():
            found.append(
                _detection(frame, here, (u_min, v_min), saliency, cluster, segmentation, up_world)
            )
    return [one for one in found if len(one.voxels)]


def _salient_pieces(
    frame: Frame, segmentation: Segmentation
) -> Iterator[tuple[Mask, tuple[int, int]]]:
    """Yield the pieces of what masks or boxes call salient, parted by steps in depth."""
    assert frame.depth is not None
    whole = segmentation.labels == Label.SALIENT
    depth = np.nan_to_num(frame.depth, nan=0.0)
    low, high = (f(depth, np.ones((3, 3), np.uint8)) for f in (cv2.erode, cv2.dilate))
    salient = whole & (high - low < STEP_M * np.maximum(1.0, depth))
    _, numbers, statistics, _ = cv2.connectedComponentsWithStats(salient.astype(np.uint8))
    least = MIN_MASK_PX * salient.size / (640 * 480)
    for number, (u, v, width, height, n_pixels) in enumerate(statistics.tolist()):
        if number and n_pixels >= least:
            # A step is as wide as two pixels: each side has one of them.
            u, v, right, below = max(0, u - 1), max(0, v - 1), u + width + 1, v + height + 1
            piece = (numbers[v:below, u:right] == number).astype(np.uint8)
            piece = cv2.dilate(piece, np.ones((3, 3), np.uint8))
            yield (piece > 0) & whole[v:below, u:right], (u, v)


def _detection(
    frame: Frame,
    mask: Mask,
    offset: tuple[int, int],
    saliency: npt.NDArray[np.float32] | None,
    cluster: Cluster | None,
    segmentation: Segmentation,
    up_world: Array | None,
) -> Detection:
    u, v = offset
    height, width = mask.shape
    inside = np.s_[v : v + height, u : u + width]
    assert frame.depth is not None
    assert frame.camera is not None
    assert frame.T_world_camera is not None
    points = _points(frame.depth, frame.camera, _without_edge(mask), offset)
    base, support = _standing(segmentation, cluster, points, frame.T_world_camera, up_world)
    pose = frame.T_world_camera
    return Detection(
        box=(u, v, width, height),
        mask=mask,
        voxels=voxels_of(points @ pose[:3, :3].T + pose[:3, 3]),
        hues=count_hues(
            frame.rgb[inside], mask, None if up_world is None else pose[:3, :3].T @ up_world
        ),
        base=base,
        support=support,
        distance=float(np.median(points[:, 2])) if len(points) else np.nan,
        is_decided=cluster is None or cluster.verdict is Verdict.OBJECT,
        saliency=np.nan if saliency is None else float(saliency[inside][mask].mean()),
    )


def _without_edge(mask: Mask) -> Mask:
    """Return a mask without its outermost pixels, unless little were left."""
    side = 2 * EDGE_PX + 1
    padded = np.pad(mask.astype(np.uint8), EDGE_PX)
    inner = cv2.erode(padded, np.ones((side, side), np.uint8)) > 0
    kept: Mask = inner[EDGE_PX:-EDGE_PX, EDGE_PX:-EDGE_PX]
    return kept if 2 * np.count_nonzero(kept) > np.count_nonzero(mask) else mask


def _points(
    depth: npt.NDArray[np.float32], camera: Camera, mask: Mask, offset: tuple[int, int]
) -> npt.NDArray[np.float64]:
    """Return the (n, 3) points of a mask's readings in the camera's frame."""
    v, u = np.nonzero(mask)
    u, v = u + offset[0], v + offset[1]
    z = depth[v, u].astype(np.float64)
    is_read = np.isfinite(z)
    u, v, z = u[is_read], v[is_read], z[is_read]
    x, y = (u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z
    return np.stack([x, y, z], axis=1)


def _standing(
    segmentation: Segmentation,
    cluster: Cluster | None,
    points: Array,
    T_world_camera: Pose,
    up_world: Array | None,
) -> tuple[float, str]:
    """Return at which metres along up a thing stands, and the name of what it stands on."""
    supports = segmentation.supports
    if cluster is None or not supports or not len(points):
        return np.nan, "unknown"
    turned = rotation_of(segmentation.n_turns)
    lowest = supports[0].plane
    up = turned.T @ lowest.normal
    if up_world is None:
        up_world = T_world_camera[:3, :3] @ up
    over_lowest = points @ up + lowest.offset
    along_up = points @ (T_world_camera[:3, :3].T @ up_world) + up_world @ T_world_camera[:3, 3]
    level = float(np.median(along_up - over_lowest))
    heights = [lowest.offset - support.plane.offset for support in supports]
    nearest = int(np.argmin(np.abs(np.array(heights) - cluster.support_height)))
    return level + cluster.support_height, supports[nearest].name
