"""Depth registration: against a plain reference, and against what a camera would see."""

from __future__ import annotations

import math

import numpy as np
import pytest

from curiosight.datasets.cameras.registration import (
    FOOTPRINT_MARGIN_PX,
    covered_window,
    register_depth,
)
from curiosight.datasets.layouts.seven_scenes import COLOUR_CAMERA, DEPTH_CAMERA
from curiosight.frame import Camera, Depth, Pose
from room import look, render

DEPTH = Camera(96, 72, 88.0, 88.0, 48.0, 36.0)
COLOUR = Camera(96, 72, 79.0, 79.0, 48.1, 35.5)


def shift(x: float, y: float, z: float, turn_deg: float = 0.0) -> Pose:
    pose = np.eye(4)
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    pose[:3, :3] = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    pose[:3, 3] = [x, y, z]
    return pose


def register_plainly(
    depth: Depth, depth_camera: Camera, colour_camera: Camera, T_colour_depth: Pose
) -> Depth:
    """Splat pixel by pixel, through points in metres, and keep the nearest."""
    result = np.full((colour_camera.height, colour_camera.width), np.nan, np.float32)
    for v, u in np.argwhere(np.isfinite(depth)):
        z = float(depth[v, u])
        x = (u - depth_camera.cx) * z / depth_camera.fx
        y = (v - depth_camera.cy) * z / depth_camera.fy
        x, y, colour_z, _ = T_colour_depth @ [x, y, z, 1]
        if colour_z <= 0:
            continue
        centre_u = colour_camera.fx * x / colour_z + colour_camera.cx
        centre_v = colour_camera.fy * y / colour_z + colour_camera.cy
        reach_u = 0.5 * z * colour_camera.fx / depth_camera.fx / colour_z + FOOTPRINT_MARGIN_PX
        reach_v = 0.5 * z * colour_camera.fy / depth_camera.fy / colour_z + FOOTPRINT_MARGIN_PX
        rows = slice(
            max(math.ceil(centre_v - reach_v), 0), max(math.floor(centre_v + reach_v) + 1, 0)
        )
        columns = slice(
            max(math.ceil(centre_u - reach_u), 0), max(math.floor(centre_u + reach_u) + 1, 0)
        )
        result[rows, columns] = np.fmin(result[rows, columns], np.float32(colour_z))
    return result


@pytest.mark.parametrize(
    "T_colour_depth",
    [shift(-0.026, 0.004, 0), shift(0.1, 0.02, 0.3, turn_deg=4), shift(0, 0, -1.5)],
    ids=["7-Scenes", "turned", "behind"],
)
def test_kernel_agrees_with_plain_reference(T_colour_depth: Pose) -> None:
    depth = render(DEPTH, look(12)).depth
    depth[10:20, 30:50] = np.nan
    registered = register_depth(depth, DEPTH, COLOUR, T_colour_depth)
    expected = register_plainly(depth, DEPTH, COLOUR, T_colour_depth)
    # Rounding of single pixels on an exact edge is the only difference allowed.
    differs = ~np.isclose(registered, expected, rtol=1e-5, equal_nan=True)
    assert differs.mean() < 0.001
    assert np.isfinite(registered).any()


def test_identity_changes_nothing_inside_surfaces() -> None:
    depth = render(DEPTH, look(0)).depth
    depth[:5] = np.nan
    registered = register_depth(depth, DEPTH, DEPTH, np.eye(4))
    np.testing.assert_array_equal(registered, depth)


def test_equals_what_the_colour_camera_sees() -> None:
    T_world_colour, T_colour_depth = look(8), shift(-0.026, 0.004, 0)
    seen = render(COLOUR_CAMERA, T_world_colour).depth
    depth = render(DEPTH_CAMERA, T_world_colour @ T_colour_depth).depth
    registered = register_depth(depth, DEPTH_CAMERA, COLOUR_CAMERA, T_colour_depth)
    u_min, v_min, u_max, v_max = covered_window(DEPTH_CAMERA, COLOUR_CAMERA, T_colour_depth)
    inside = (slice(v_min, v_max), slice(u_min, u_max))
    error = np.abs(registered[inside] - seen[inside])
    assert np.nanmedian(error) < 0.005
    # Outlines are a pixel uncertain; a background seen through an object would be more.
    assert np.nanmean(error > 0.1) < 0.004


@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8])
def test_no_background_shines_through_a_nearer_slanted_surface(tilt: float) -> None:
    depth = np.full((480, 640), 3.0, np.float32)
    near = 1.2 + tilt * np.linspace(-0.5, 0.5, 300, dtype=np.float32)
    disparity_step = 0.125 / (585 * 0.075)
    depth[100:400, 150:450] = 1 / (np.round(1 / near / disparity_step) * disparity_step)
    T_colour_depth = shift(-0.026, 0.004, 0)
    registered = register_depth(depth, DEPTH_CAMERA, COLOUR_CAMERA, T_colour_depth)
    box = registered < 2
    rows, columns = np.flatnonzero(box.any(1)), np.flatnonzero(box.any(0))
    # The outline itself is shifted by up to 2 px, more where the surface is nearer.
    inner = box[rows[0] + 3 : rows[-1] - 2, columns[0] + 3 : columns[-1] - 2]
    assert inner.shape[0] > 250
    assert inner.shape[1] > 240
    assert inner.all()


def test_window_is_covered_at_every_distance_and_no_smaller_than_needed() -> None:
    T_colour_depth = shift(-0.026, 0.004, 0)
    u_min, v_min, u_max, v_max = covered_window(DEPTH_CAMERA, COLOUR_CAMERA, T_colour_depth)
    always = np.ones((480, 640), bool)
    for distance in (1.0, 1.5, 4.0):
        depth = np.full((480, 640), np.nan, np.float32)
        depth[:, :632] = distance
        always &= np.isfinite(register_depth(depth, DEPTH_CAMERA, COLOUR_CAMERA, T_colour_depth))
    assert always[v_min:v_max, u_min:u_max].all()
    outside = always.copy()
    outside[v_min - 1 : v_max + 1, u_min - 1 : u_max + 1] = False
    assert not outside.any()


def test_wrong_shape_is_named() -> None:
    with pytest.raises(ValueError, match=r"depth: expected \(72, 96\) float32"):
        register_depth(np.zeros((3, 4), np.float32), DEPTH, COLOUR, np.eye(4))
