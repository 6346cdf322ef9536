"""Scenes of a few meshes, for the tests of what draws rooms."""

from __future__ import annotations

import numpy as np

from curiosight.frame import Camera
from curiosight.rooms.mesh import Material, Mesh, standing
from curiosight.rooms.renderer import Renderer, Rendering
from curiosight.rooms.round_shapes import ellipsoid
from curiosight.rooms.scene import Light, Part, Role, Scene
from curiosight.rooms.shapes import box, panel

CAMERA = Camera(64, 48, 60.0, 50.0, 31.5, 23.5)


def plain(grey: int | tuple[int, int, int], **looks: float) -> Material:
    """Return an even material of an sRGB code."""
    return Material(np.full((2, 2, 3), grey, np.uint8), **looks)


WHITE = plain(255)


def checks(size: float, **looks: float) -> Material:
    """Return a chessboard of black and white fields of `size` metres."""
    field = np.kron(np.eye(2), np.ones((8, 8)))[..., None] * np.full(3, 255)
    return Material(field.astype(np.uint8), tile=(2 * size, 2 * size), **looks)


def scene_of(*meshes: Mesh, lights: tuple[Light, ...] = ()) -> Scene:
    return Scene(tuple(Part("thing", Role.OBJECT, mesh) for mesh in meshes), lights)


def lamp(height: float, size: float = 0.4, radiance: float = 10.0) -> Light:
    """Return a square lamp above the origin that shines down."""
    along, across = np.array([0, size, 0]), np.array([size, 0, 0])
    return Light(np.array([0, 0, height]), along, across, np.full(3, radiance))


def ground(material: Material = WHITE, half: float = 2.0, spacing: float = 0.1) -> Mesh:
    side = 2 * half
    return panel((-half, -half, 0), (side, 0, 0), (0, side, 0), material, spacing=spacing)


def looking(eye: tuple[float, float, float], at: tuple[float, float, float]) -> np.ndarray:
    """Return T_world_camera of a camera held upright."""
    ahead = np.subtract(at, eye) / np.linalg.norm(np.subtract(at, eye))
    helper = (0, 0, 1) if abs(ahead[2]) < 0.99 else (0, 1, 0)
    right = np.cross(ahead, helper) / np.linalg.norm(np.cross(ahead, helper))
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(ahead, right), ahead, eye], 1)
    return pose


def from_above(scene: Scene, height: float = 2.0, at: tuple[float, float] = (0, 0)) -> Rendering:
    """Draw a scene from straight above a point of the ground."""
    return Renderer(scene).render(CAMERA, looking((*at, height), (*at, 0.0)))


def furnished() -> Scene:
    """Return a small scene with textures, gloss, curves, shadows and two lamps."""
    ball = ellipsoid((0.3, 0.3, 0.3), plain((200, 60, 40), gloss=0.8, sharpness=40.0))
    crate = box((0.5, 0.4, 0.6), checks(0.05, gloss=0.3, infrared=0.2), spacing=0.1)
    wall = panel((1.5, 1.5, 0), (-3, 0, 0), (0, 0, 2), plain((90, 140, 60)), spacing=0.2)
    screen = panel((-1.0, 1.4, 0.5), (0.6, 0, 0), (0, 0, 0.4), plain(120, emission=2.0))
    lights = (lamp(2.5), Light(np.array([-1.8, 0, 1]), np.eye(3)[1], np.eye(3)[2], np.ones(3)))
    things = (ball.moved(standing(-0.5, 0.2)), crate.moved(standing(0.5, 0.3, 0, 0.4)))
    return scene_of(ground(checks(0.2, gloss=0.2)), *things, wall, screen, lights=lights)
