"""Pictures of a room: light, depth, and which part is where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Pose, is_rigid
from curiosight.rooms.lighting import lit
from curiosight.rooms.mesh import Floats, join
from curiosight.rooms.mipmaps import mipmaps
from curiosight.rooms.scene import Scene
from curiosight.rooms.shading import Rays, light_table, paint, polish, surfaces
from curiosight.rooms.tracing import RayCaster, portions

# Rows of one call: fixed, so that no result depends on the number of threads.
N_ROWS = 120


@dataclass(frozen=True, slots=True, eq=False)
class Rendering:
    """What a perfect camera sees.

    radiance: (H, W, 3) float32 linear light, before any exposure.
    depth: (H, W) float32 metres along z, NaN = nothing there.
    ids: (H, W) int32 number of the part, its place in the scene + 1; 0 = nothing.
    cosine: (H, W) float32 of the angle between the ray and the face's normal, either way; 0 =
        nothing.
    infrared: (H, W) float32 share of a depth sensor's light that the material sends back.
    """

    radiance: Floats
    depth: Depth
    ids: npt.NDArray[np.int32]
    cosine: Floats
    infrared: Floats


class Renderer:
    """Draws one scene from any place; its light is worked out when it is made.

    seed: of the pattern in which light is sampled. n_threads: never changes a picture.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, n_threads: int = 1) -> None:
        if n_threads < 1:
            raise ValueError(f"n_threads: expected at least 1, got {n_threads}")
        mesh = join([part.mesh for part in scene.parts])
        self._caster = RayCaster(mesh, n_threads)
        self._surfaces = surfaces(mesh, lit(mesh, scene.lights, self._caster, seed))
        self._mipmaps = mipmaps(mesh.materials)
        self._lights = light_table(scene.lights)
        # A ray that meets nothing has triangle -1, the last place of these tables.
        numbers = np.arange(1, len(scene.parts) + 1, dtype=np.int32)
        n_triangles = [len(part.mesh.triangles) for part in scene.parts]
        self._part_of_triangle = np.append(np.repeat(numbers, n_triangles), np.int32(0))
        infrared = np.array([material.infrared for material in mesh.materials], np.float32)
        self._infrared_of_triangle = np.append(infrared[mesh.surface], np.float32(0))

    def render(self, camera: Camera, T_world_camera: Pose) -> Rendering:
        """Draw what the camera sees; pixel [v, u] looks along ((u - cx)/fx, (v - cy)/fy, 1)."""
        if not is_rigid(T_world_camera):
            raise ValueError(
                "T_world_camera: expected a (4, 4) rotation and translation, "
                f"got {np.shape(T_world_camera)} {T_world_camera}"
            )
        directions = ray_directions(camera, T_world_camera)
        origin = T_world_camera[:3, 3].astype(np.float32)
        radiance = np.zeros((camera.height, camera.width, 3), np.float32)
        cosine = np.zeros((camera.height, camera.width), np.float32)

        def draw(rows: slice) -> tuple[npt.NDArray[np.int32], Floats]:
            rays = Rays(origin, directions[rows].reshape(-1, 3), 1 / camera.fx)
            hits = self._caster.hits(
                np.broadcast_to(origin, rays.directions.shape), rays.directions
            )
            colours = radiance[rows].reshape(-1, 3)
            paint(hits, rays, self._surfaces, self._mipmaps, colours, cosine[rows].reshape(-1))
            polish(hits, rays, self._surfaces, self._lights, colours)
            return hits.triangle, hits.distance

        drawn = self._caster.map(draw, portions(camera.height, N_ROWS))
        triangle, depth = (np.concatenate(pieces) for pieces in zip(*drawn, strict=True))
        depth[triangle < 0] = np.nan
        size = (camera.height, camera.width)
        return Rendering(
            radiance,
            depth.reshape(size),
            self._part_of_triangle[triangle].reshape(size),
            cosine,
            self._infrared_of_triangle[triangle].reshape(size),
        )


def ray_directions(camera: Camera, T_world_camera: Pose) -> Floats:
    """Return the (H, W, 3) directions of the pixels' rays, of length 1 along the camera's z."""
    x = ((np.arange(camera.width) - camera.cx) / camera.fx).astype(np.float32)
    y = ((np.arange(camera.height) - camera.cy) / camera.fy).astype(np.float32)
    right, down, ahead = T_world_camera[:3, :3].T.astype(np.float32)
    directions: Floats = x[:, None] * right + (y[:, None] * down + ahead)[:, None]
    return directions
