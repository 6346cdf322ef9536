"""The renderer beside MuJoCo's ray caster, which shares no line with it."""

from __future__ import annotations

import os

import numpy as np
import pytest

from curiosight.frame import Camera
from curiosight.rooms.mesh import Material, Mesh, standing
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe
from curiosight.rooms.scene import Part, Role, Scene
from curiosight.rooms.shapes import box, panel

if "CURIOSIGHT_TEST_DATA" in os.environ:
    import mujoco
else:
    mujoco = pytest.importorskip("mujoco")

CAMERA = Camera(320, 240, 262.5, 260.0, 158.7, 121.3)
GREY = Material(np.full((2, 2, 3), 128, np.uint8))


def furnished() -> Scene:
    """Return a room's corner with a table and things on and under it."""
    place = standing
    legs = [box((0.06, 0.06, 0.7), GREY).moved(place(x, y)) for x in (-0.6, 0.6) for y in (1, 1.7)]
    bowl = [(0.04, 0.0), (0.15, 0.08), (0.14, 0.09), (0.03, 0.01)]
    meshes = [
        panel((-2, -1, 0), (4, 0, 0), (0, 4, 0), GREY, spacing=0.5),
        panel((-2, 3, 0), (4, 0, 0), (0, 0, 2.5), GREY, spacing=0.5),
        panel((2, 3, 0), (0, -4, 0), (0, 0, 2.5), GREY, spacing=0.5),
        *legs,
        box((1.4, 0.9, 0.04), GREY, lift=0.7).moved(place(0, 1.35)),
        box((0.3, 0.2, 0.35), GREY).moved(place(-0.3, 1.2, 0.74, 0.5)),
        ellipsoid((0.12, 0.12, 0.12), GREY).moved(place(0.2, 1.3, 0.74)),
        cylinder(0.05, 0.25, GREY).moved(place(0.45, 1.5, 0.74)),
        lathe(bowl, GREY).moved(place(0.0, 1.1, 0.74)),
        ellipsoid((0.3, 0.2, 0.25), GREY).moved(place(-1.2, 0.8, 0.0, 0.7)),
        box((0.4, 0.4, 0.4), GREY).moved(place(1.1, 0.6, 0.0, -0.3)),
    ]
    return Scene(tuple(Part("thing", Role.OBJECT, mesh) for mesh in meshes), ())


def add_mesh(spec: mujoco.MjSpec, name: str, mesh: Mesh) -> None:
    """Add a mesh that stands still, may be flat, and is no obstacle: it needs no hull."""
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    vertices, faces = mesh.vertices.astype(float).ravel(), mesh.triangles.ravel()
    spec.add_mesh(name=name, uservert=vertices, userface=faces, inertia=shell)
    kind = mujoco.mjtGeom.mjGEOM_MESH
    spec.worldbody.add_geom(type=kind, meshname=name, contype=0, conaffinity=0)


def cast(scene: Scene, T_world_camera: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ids and the depth that MuJoCo finds, by the pinhole model written anew."""
    spec = mujoco.MjSpec()
    for number, part in enumerate(scene.parts):
        add_mesh(spec, f"part {number}", part.mesh)
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    n_rays = CAMERA.width * CAMERA.height
    v, u = np.divmod(np.arange(n_rays), CAMERA.width)
    intrinsics = [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]]
    in_camera = np.linalg.solve(intrinsics, np.stack([u, v, np.ones(n_rays)]))
    in_camera /= np.linalg.norm(in_camera, axis=0)
    in_world = T_world_camera[:3, :3] @ in_camera
    geoms, distances = np.empty(n_rays, np.int32), np.empty(n_rays)
    mujoco.mj_multiRay(
        *(model, state, T_world_camera[:3, 3], in_world.T.ravel()),
        *(None, True, -1, geoms, distances, None, n_rays, mujoco.mjMAXVAL),
    )
    ids = np.where(geoms < 0, 0, geoms + 1).reshape(CAMERA.height, CAMERA.width)
    return ids, (distances * in_camera[2]).reshape(ids.shape)


@pytest.mark.parametrize("eye", [(0.3, -0.6, 1.0), (-1.5, -0.3, 1.5), (1.2, -0.8, 0.4)])
def test_ids_and_depth_agree_with_mujoco(eye: tuple[float, float, float]) -> None:
    ahead = np.subtract((0, 1.4, 0.6), eye)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0, 0, 1))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(ahead, right), ahead, eye], 1)
    ours = Renderer(furnished()).render(CAMERA, pose)
    ids, depth = cast(furnished(), pose)
    assert len(np.unique(ids)) >= 12
    assert (ours.ids == ids).mean() >= 0.999
    both = (ids > 0) & (ours.ids > 0)
    assert np.median(np.abs(ours.depth - depth)[both]) <= 1e-3
    assert (np.abs(ours.depth - depth)[both] <= 1e-3).mean() >= 0.999
