"""Things with a plug that work in a household."""

from __future__ import annotations

import numpy as np

from curiosight.rooms.materials import black_plastic, chrome, plastic
from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, lathe, ring, tube
from curiosight.rooms.shapes import box, rounded_box
from curiosight.rooms.surfaces import Points, sheet, stretched, turned, warped
from curiosight.rooms.things.kind import FLOOR, TABLE, Kind, assembled, at


def draw_kettle(rng: np.random.Generator) -> Mesh:
    """Return an electric kettle on its base."""
    radius, height = rng.uniform(0.07, 0.085), rng.uniform(0.19, 0.24)
    is_steel = rng.random() < 0.5
    shell = chrome(rng) if is_steel else plastic(draw_colour(rng), 0.4)
    black = black_plastic(rng)
    profile = [(0, 0.02), (radius, 0.02), (radius * 0.98, 0.3 * height)]
    profile += [(radius * 0.78, 0.9 * height), (radius * 0.7, 0.95 * height), (0, height)]
    bend = _smooth([(0.7, 0, 0.92), (1.3, 0, 1.0), (1.75, 0, 0.85), (1.35, 0, 0.2)])
    spout = [(-0.6 * radius, 0, 0.8 * height), (-1.02 * radius, 0, 0.96 * height)]
    return assembled(
        [
            cylinder(radius * 1.08, 0.022, black),
            lathe(profile, shell, fit=False),
            tube(bend * [radius, 1, height], 0.012, black, n_around=8),
            tube(spout, [0.03, 0.022], shell),
            cylinder(0.016, 0.018, black, lift=height * 0.99),
        ]
    )


def draw_toaster(rng: np.random.Generator) -> Mesh:
    """Return a toaster with two slots and a lever."""
    width, depth, height = rng.uniform(0.25, 0.3), rng.uniform(0.15, 0.18), rng.uniform(0.17, 0.2)
    shell = chrome(rng) if rng.random() < 0.4 else plastic(draw_colour(rng, vivid=0.7), 0.4)
    black = black_plastic(rng)
    slot = box((0.75 * width, 0.024, 0.004), black, lift=height + 0.013)
    knob = cylinder(0.014, 0.01, black).moved(turned((1, 0, 0), np.pi / 2))
    lever = box((0.018, 0.04, 0.012), black, lift=0.6 * height)
    return assembled(
        [
            box((0.92 * width, 0.9 * depth, 0.02), black),
            rounded_box((width, depth, height), 0.035, shell, lift=0.014),
            at(slot, 0, 0.025),
            at(slot, 0, -0.025),
            at(lever, width / 2 + 0.008, 0),
            at(knob, 0.3 * width, -depth / 2, 0.07),
        ]
    )


def draw_fan(rng: np.random.Generator) -> Mesh:
    """Return a fan in a wire cage, on a low foot or a pole."""
    radius, height = rng.uniform(0.13, 0.19), rng.uniform(0.3, 0.85)
    shell = plastic(draw_colour(rng, vivid=0.4), 0.3)
    wire = chrome(rng) if rng.random() < 0.5 else shell
    blade = plastic(draw_colour(rng, vivid=0.6), 0.3)
    motor = lathe([(0, -0.13), (0.04, -0.12), (0.055, -0.03), (0, -0.02)], shell, n_around=16)
    hub = cylinder(0.2 * radius, 0.03, shell, n_around=16)
    head = [motor, hub, *_cage(radius, wire), *_blades(radius, blade)]
    tilt = turned((1, 0, 0), np.pi / 2 - 0.1, (0, 0, height))
    reach = 0.13 if height < 0.5 else 0.19
    profile = [(0, 0), (1, 0), (1, 0.12), (0.25, 0.3), (0, 0.32)]
    foot = lathe(np.array(profile) * reach, shell, n_around=24, fit=False)
    pole = tube([(0, 0.06, 0.02), (0, 0.06, height)], 0.014, shell)
    return assembled([*(part.moved(tilt) for part in head), foot, pole])


def _cage(radius: float, wire: Material) -> list[Mesh]:
    """Return wire hoops and spokes before and behind the blades of a fan that looks up."""
    hoops = [(1.0, 0.0), (0.75, 0.03), (0.45, 0.042), (0.75, -0.04), (0.45, -0.055)]
    parts = [at(ring(share * radius, 0.003, wire, n_rod=5), 0, 0, z) for share, z in hoops]
    spoke = [(0.0, 0, 0.05), (0.6 * radius, 0, 0.04), (radius, 0, 0.0), (0.6 * radius, 0, -0.05)]
    rod = tube(spoke, 0.0018, wire, n_around=4)
    return parts + [at(rod, 0, 0, 0, turn) for turn in np.arange(18) * np.pi / 9]


def _blades(radius: float, stuff: Material) -> list[Mesh]:
    length, sweep = np.meshgrid(np.linspace(0.15, 0.9, 6), np.linspace(-1, 1, 5))
    angle = 0.55 * sweep * np.sqrt(length)
    twisted = np.stack([length * np.cos(angle), length * np.sin(angle), 0.12 * sweep], -1)
    blade = sheet(twisted * radius, stuff)
    return [at(blade, 0, 0, 0, turn) for turn in np.arange(3) * 2 * np.pi / 3]


def draw_vacuum_cleaner(rng: np.random.Generator) -> Mesh:
    """Return a canister vacuum cleaner with its hose and an upright pipe."""
    paint, black = plastic(draw_colour(rng, vivid=0.8), 0.4), black_plastic(rng)
    length, width, height = rng.uniform(0.36, 0.44), 0.26, rng.uniform(0.2, 0.26)

    def rounded_down(points: Points) -> Points:
        slope = np.interp(points[:, 1] / length, [-0.5, 0.0, 0.5], [0.55, 1.0, 0.85])
        return stretched(points, x=0.7 + 0.3 * slope, z=slope)

    body = rounded_box((width, length, height), 0.08, paint, n_bevel=4)
    axle = turned((0, 1, 0), np.pi / 2, (-0.015, 0, 0.085))
    wheel = cylinder(0.085, 0.03, black, n_around=20).moved(axle)
    raised = height + 0.05
    grip = [(0, 0.1, height), (0, 0.06, raised), (0, -0.1, raised), (0, -0.14, height)]
    pipe = [(0.28, -0.1, 0.05), (0.26, 0.02, 0.9)]
    hose = [(0, -0.5 * length, 0.12), (-0.1, -0.8 * length, 0.16), (0.05, -0.95 * length, 0.4)]
    hose += [(0.2, -0.4 * length, 0.75), (0.25, 0.0, 0.95), (0.26, 0.03, 0.86)]
    return assembled(
        [
            at(warped(body, rounded_down), 0, 0, 0.025),
            *(at(wheel, side * 0.5 * width, 0.2 * length) for side in (-1, 1)),
            tube(grip, 0.012, black, n_around=8),
            tube(_smooth(hose), 0.019, black, n_around=8),
            tube(pipe, 0.017, chrome(rng)),
            at(rounded_box((0.27, 0.1, 0.05), 0.02, black), 0.28, -0.12),
        ]
    )


def _smooth(points: list[tuple[float, float, float]]) -> Points:
    """Return a path rounded by cutting its corners twice."""
    path = np.asarray(points)
    for _ in range(2):
        first, second = 0.75 * path[:-1] + 0.25 * path[1:], 0.25 * path[:-1] + 0.75 * path[1:]
        inner = np.stack([first, second], 1).reshape(-1, 3)
        path = np.concatenate([path[:1], inner, path[-1:]])
    return path


KINDS = (
    Kind("kettle", draw_kettle, TABLE),
    Kind("toaster", draw_toaster, TABLE),
    Kind("fan", draw_fan, FLOOR),
    Kind("vacuum cleaner", draw_vacuum_cleaner, FLOOR),
)
