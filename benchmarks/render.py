"""Time the drawing of a room on one thread, beside MuJoCo's ray caster and its OpenGL renderer.

    python benchmarks/render.py [--seed 1] [--views 20]

Prints a table, keeps benchmarks/results/render.json: median and 90th percentile of the wall time,
and the median of the processor's time, which other programs disturb less; milliseconds of
640 x 480 pixels. MuJoCo draws the same triangles in plain colours; its OpenGL renderer needs
EGL, and draws three times for the colours, the depth and the ids.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from stages import processor

from curiosight.rooms.lighting import lit
from curiosight.rooms.mesh import join
from curiosight.rooms.mipmaps import mipmaps
from curiosight.rooms.renderer import Renderer, ray_directions
from curiosight.rooms.room import draw_room
from curiosight.rooms.scene import Scene
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.shading import Rays, light_table, paint, polish, surfaces
from curiosight.rooms.tracing import Hits, RayCaster
from curiosight.rooms.views import CAMERA, RoomViews

RESULTS = Path(__file__).parent / "results" / "render.json"
N_PIXELS = CAMERA.width * CAMERA.height


def timed(work: Callable[[Any], Any], inputs: list[Any]) -> dict[str, float]:
    """Return median and 90th percentile of the work on each input, after one warm-up."""
    work(inputs[0])
    wall, processing = [], []
    for item in inputs:
        start, start_processing = time.perf_counter(), time.process_time()
        work(item)
        wall.append(1000 * (time.perf_counter() - start))
        processing.append(1000 * (time.process_time() - start_processing))
    return {
        "median_ms": float(np.median(wall)),
        "p90_ms": float(np.percentile(wall, 90)),
        "processor_ms": float(np.median(processing)),
    }


def time_ours(scene: Scene, poses: list[Any]) -> dict[str, Any]:
    """Time the whole, and its stages one by one."""
    renderer = Renderer(scene)
    mesh = join([part.mesh for part in scene.parts])
    caster = RayCaster(mesh)
    light = lit(mesh, scene.lights, caster, seed=0)
    look, maps, lights = surfaces(mesh, light), mipmaps(mesh.materials), light_table(scene.lights)

    def rays(pose: Any) -> Rays:
        directions = ray_directions(CAMERA, pose).reshape(-1, 3)
        return Rays(pose[:3, 3].astype(np.float32), directions, 1 / CAMERA.fx)

    def trace(cast: Rays) -> Hits:
        return caster.hits(np.broadcast_to(cast.origin, cast.directions.shape), cast.directions)

    def shade(hits_and_rays: tuple[Hits, Rays]) -> None:
        radiance, cosine = np.zeros((N_PIXELS, 3), np.float32), np.zeros(N_PIXELS, np.float32)
        paint(*hits_and_rays, look, maps, radiance, cosine)
        polish(*hits_and_rays, look, lights, radiance)

    cast = [rays(pose) for pose in poses]
    return {
        "whole picture": timed(lambda pose: renderer.render(CAMERA, pose), poses),
        "trace": timed(trace, cast),
        "shade": timed(shade, [(trace(some), some) for some in cast]),
        "triangles": len(mesh.triangles),
        "triangles of light": len(light.mesh.leaves),
        "build, 1 thread": timed(lambda n: Renderer(scene, n_threads=n), [1] * 3),
        "build, 2 threads": timed(lambda n: Renderer(scene, n_threads=n), [2] * 3),
    }


def mujoco_model(scene: Scene) -> Any:
    """Return the scene's triangles as MuJoCo's."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = CAMERA.width, CAMERA.height
    fovy = np.degrees(2 * np.arctan(CAMERA.height / 2 / CAMERA.fy))
    spec.worldbody.add_camera(name="camera", fovy=fovy, mode=mujoco.mjtCamLight.mjCAMLIGHT_FIXED)
    spec.worldbody.add_light(pos=[0, 0, 2])
    for number, part in enumerate(scene.parts):
        vertices, faces = part.mesh.vertices.astype(float).ravel(), part.mesh.triangles.ravel()
        shell, name = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL, f"part {number}"
        spec.add_mesh(name=name, uservert=vertices, userface=faces, inertia=shell)
        kind = mujoco.mjtGeom.mjGEOM_MESH
        spec.worldbody.add_geom(type=kind, meshname=name, contype=0, conaffinity=0)
    return spec.compile()


def time_mujoco(scene: Scene, poses: list[Any]) -> dict[str, Any]:
    """Time MuJoCo's two ways to see."""
    model = mujoco_model(scene)
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    geoms, distances = np.empty(N_PIXELS, np.int32), np.empty(N_PIXELS)

    def trace(pose: Any) -> None:
        vectors = ray_directions(CAMERA, pose).astype(float).ravel()
        rays = (pose[:3, 3], vectors, None, True, -1)
        mujoco.mj_multiRay(model, state, *rays, geoms, distances, None, N_PIXELS, 100.0)

    drawing = mujoco.Renderer(model, CAMERA.height, CAMERA.width)

    def draw(pose: Any) -> None:
        state.cam_xpos[0] = pose[:3, 3]
        state.cam_xmat[0] = (pose[:3, :3] * [1, -1, -1]).ravel()
        drawing.update_scene(state, camera="camera")
        drawing.render()
        for switch in ("depth", "segmentation"):
            getattr(drawing, f"enable_{switch}_rendering")()
            drawing.render()
            getattr(drawing, f"disable_{switch}_rendering")()

    figures = {"ray caster, ids and depth only": timed(trace, poses[:5])}
    figures["OpenGL, colours, depth, ids"] = timed(draw, poses)
    drawing.close()
    return figures


def main() -> None:
    """Time both and keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--views", type=int, default=20)
    arguments = parser.parse_args()
    room = draw_room(RoomSettings(seed=arguments.seed, views=arguments.views))
    poses = list(RoomViews(room).poses)
    figures = {
        "room": arguments.seed,
        "views": len(poses),
        "image": [CAMERA.height, CAMERA.width],
        "processor": processor(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        "ours": time_ours(room.scene, poses),
        "mujoco": time_mujoco(room.scene, poses),
    }
    for who in ("ours", "mujoco"):
        print(who)
        for stage, value in figures[who].items():
            line = str(value)
            if isinstance(value, dict):
                line = (
                    f"{value['median_ms']:8.1f} ms, p90 {value['p90_ms']:.1f}, "
                    f"processor {value['processor_ms']:.1f}"
                )
            print(f"  {stage:32s} {line}")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
