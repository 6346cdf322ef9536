"""Pictures of a room: light, depth, and which part is where."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Pose, is_rigid
from curiosight.rooms.disguise import Disguise
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


class Seen(NamedTuple):
    """What N rays meet: the pixels of a `Rendering`, in a row."""

    radiance: Floats
    depth: Floats
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
        return take_picture(self.see, self.each, camera, T_world_camera)

    def each(self, work: Callable[[slice], Seen], items: Sequence[slice]) -> list[Seen]:
        """Return what the work gives for each item, in order, some at a time."""
        return self._caster.map(work, items)

    def disguised(self, disguise: Disguise, rng: np.random.Generator) -> Renderer:
        """Return the same scene in the same light, all its materials changed by chance."""
        other = copy(self)
        dressed = disguise.put_on(self._surfaces, self._mipmaps, rng)
        other._surfaces, other._mipmaps = dressed
        return other

    def see(self, rays: Rays, start: Floats | None = None) -> Seen:
        """Return what rays meet; start: (N,) where on each ray it begins, None = at its origin."""
        directions, n_rays = rays.directions, len(rays.directions)
        origins = np.broadcast_to(rays.origin, directions.shape)
        if start is not None:
            origins = origins + start[:, None] * directions
        hits = self._caster.hits(origins, directions)
        if start is not None:
            hits = hits._replace(distance=hits.distance + start)
        radiance, cosine = np.zeros((n_rays, 3), np.float32), np.zeros(n_rays, np.float32)
        paint(hits, rays, self._surfaces, self._mipmaps, radiance, cosine)
        polish(hits, rays, self._surfaces, self._lights, radiance)
        triangle, depth = hits.triangle, hits.distance
        depth[triangle < 0] = np.nan
        infrared = self._infrared_of_triangle[triangle]
        return Seen(radiance, depth, self._part_of_triangle[triangle], cosine, infrared)


def take_picture(
    see: Callable[[Rays], Seen],
    each: Callable[[Callable[[slice], Seen], Sequence[slice]], list[Seen]],
    camera: Camera,
    T_world_camera: Pose,
) -> Rendering:
    """Return what all the rays of a camera meet; each: how portions of the rows are worked on."""
    directions = ray_directions(camera, T_world_camera)
    origin = T_world_camera[:3, 3].astype(np.float32)

    def draw(rows: slice) -> Seen:
        return see(Rays(origin, directions[rows].reshape(-1, 3), 1 / camera.fx))

    size = (camera.height, camera.width)
    columns = zip(*each(draw, portions(camera.height, N_ROWS)), strict=True)
    radiance, depth, ids, cosine, infrared = map(np.concatenate, columns)
    return Rendering(
        radiance.reshape(*size, 3),
        depth.reshape(size),
        ids.reshape(size),
        cosine.reshape(size),
        infrared.reshape(size),
    )


def ray_directions(camera: Camera, T_world_camera: Pose) -> Floats:
    """Return the (H, W, 3) directions of the pixels' rays, of length 1 along the camera's z."""
    x = ((np.arange(camera.width) - camera.cx) / camera.fx).astype(np.float32)
    y = ((np.arange(camera.height) - camera.cy) / camera.fy).astype(np.float32)
    right, down, ahead = T_world_camera[:3, :3].T.astype(np.float32)
    directions: Floats = x[:, None] * right + (y[:, None] * down + ahead)[:, None]
    return directions
