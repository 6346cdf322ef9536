"""The rays of a whole picture, most of which meet what their neighbours met."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.worlds.rooms.mesh import Floats, Mesh
from curiosight.worlds.rooms.tracing import Hits, RayCaster
from curiosight.worlds.rooms.vectors import Triple, cross, dot, kernel

Indices = npt.NDArray[np.int32]

# Rays between others that met one part at distances within this ratio may go without a search.
LARGEST_RATIO = 1.05


class PictureRays:
    """Casts the rays of pictures at a mesh.

    Every second ray is searched, as on a chessboard; one in between is only tried on the
    triangles that its four neighbours met, and searched where these lie on several parts or it
    meets none. So only what is smaller than a pixel may go unseen.
    """

    def __init__(self, caster: RayCaster, mesh: Mesh, part_of_triangle: Indices) -> None:
        """Keep the scene; part_of_triangle: (T,), of the mesh's triangles."""
        corners = mesh.vertices[mesh.triangles]
        self._caster = caster
        self._part_of_triangle = part_of_triangle
        self._corners_and_edges = np.concatenate(
            [corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=1
        )

    def hits(self, origin: Floats, directions: Floats) -> Hits:
        """Return what each of (H, W, 3) directions meets, row after row."""
        height, width = directions.shape[:2]
        hits = Hits(
            np.full(height * width, -1, np.int32), *np.zeros((3, height * width), np.float32)
        )
        rays = directions.reshape(-1, 3)
        is_white = np.indices((height, width)).sum(0) % 2 == 0
        self._search(np.flatnonzero(is_white), origin, rays, hits)
        left_over = fill_between(
            width, origin, rays, self._corners_and_edges, self._part_of_triangle, hits
        )
        self._search(left_over, origin, rays, hits)
        return hits

    def _search(
        self, pixels: npt.NDArray[np.int64], origin: Floats, rays: Floats, hits: Hits
    ) -> None:
        """Put what the rays of some pixels meet to the hits."""
        chosen = rays[pixels]
        found = self._caster.hits(np.broadcast_to(origin, chosen.shape), chosen)
        for all_pixels, some in zip(hits, found, strict=True):
            all_pixels[pixels] = some


@kernel
def fill_between(
    width: int,
    origin: Floats,
    rays: Floats,
    corners_and_edges: Floats,
    part_of_triangle: Indices,
    hits: Hits,
) -> npt.NDArray[np.int64]:
    """Fill the hits of black fields; return the pixels where that failed."""
    triangles, seconds, thirds, distances = hits
    left_over, n_left = np.empty(len(rays), np.int64), 0
    last_row, last_column = len(rays) // width - 1, width - 1
    eye = (origin[0], origin[1], origin[2])
    for pixel in range(len(rays)):
        row, column = pixel // width, pixel % width
        if (row + column) % 2 == 0:
            continue
        # At the picture's edge a pixel is its own neighbour, which met nothing yet.
        around = (
            pixel - width if row > 0 else pixel,
            pixel - 1 if column > 0 else pixel,
            pixel + 1 if column < last_column else pixel,
            pixel + width if row < last_row else pixel,
        )
        ray = (rays[pixel, 0], rays[pixel, 1], rays[pixel, 2])
        distance = -1.0
        if is_one_surface(around, triangles, distances, part_of_triangle):
            for k in range(4):
                triangle = triangles[around[k]]
                distance, second, third = meet(corners_and_edges, triangle, eye, ray)
                if distance > 0:
                    triangles[pixel], distances[pixel] = triangle, distance
                    seconds[pixel], thirds[pixel] = second, third
                    break
        if distance <= 0:
            left_over[n_left] = pixel
            n_left += 1
    return left_over[:n_left]


@kernel
def is_one_surface(
    pixels: tuple[int, int, int, int],
    triangles: Indices,
    distances: Floats,
    part_of_triangle: Indices,
) -> bool:
    """Tell whether four pixels met one part, at nearly one distance."""
    nearest, farthest = distances[pixels[0]], distances[pixels[0]]
    first = triangles[pixels[0]]
    for k in range(4):
        triangle = triangles[pixels[k]]
        if triangle < 0 or part_of_triangle[triangle] != part_of_triangle[first]:
            return False
        nearest = min(nearest, distances[pixels[k]])
        farthest = max(farthest, distances[pixels[k]])
    return bool(farthest < LARGEST_RATIO * nearest)


@kernel
def meet(corners_and_edges: Floats, triangle: int, eye: Triple, ray: Triple) -> Triple:
    """Return where a ray meets a triangle: distance, second and third weight; -1 = it does not.

    Möller and Trumbore's test (1997).
    """
    row = corners_and_edges[triangle]
    to_second, to_third = (row[3], row[4], row[5]), (row[6], row[7], row[8])
    from_first = (eye[0] - row[0], eye[1] - row[1], eye[2] - row[2])
    normal = cross(ray, to_third)
    factor = 1 / dot(to_second, normal)
    second = factor * dot(from_first, normal)
    side = cross(from_first, to_second)
    third = factor * dot(ray, side)
    if second >= 0 and third >= 0 and second + third <= 1:
        return factor * dot(to_third, side), second, third
    return -1.0, 0.0, 0.0
