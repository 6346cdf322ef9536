"""What one sits on, light enough to be moved about."""

from __future__ import annotations

import numpy as np

from curiosight.rooms.materials import (
    black_plastic,
    chrome,
    cloth,
    colour,
    leather,
    plastic,
    rubber,
    timber,
)
from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, lathe, tube
from curiosight.rooms.shapes import box, rounded_box
from curiosight.rooms.surfaces import Points, scaled, sheet, turned, warped
from curiosight.rooms.things.kind import FLOOR, Kind, assembled, at


def _frame_material(rng: np.random.Generator) -> Material:
    return timber(rng) if rng.random() < 0.65 else plastic(draw_colour(rng, vivid=0.6), 0.25)


def draw_wooden_chair(rng: np.random.Generator) -> Mesh:
    """Return a four-legged chair with a slatted, barred or padded back."""
    width, depth = rng.uniform(0.4, 0.46), rng.uniform(0.4, 0.45)
    seat, top = rng.uniform(0.43, 0.47), rng.uniform(0.82, 0.96)
    frame = _frame_material(rng)
    leg = rng.uniform(0.032, 0.042)
    lean = rng.uniform(0.04, 0.1)
    x, y = (width - leg) / 2, (depth - leg) / 2
    post = box((leg, leg, seat), frame)
    apron = box((width - leg, 0.02, 0.06), frame, lift=seat - 0.07)
    parts = [at(post, sx * x, sy * y) for sx in (-1, 1) for sy in (-1, 1)]
    parts += [at(apron, 0, -y), at(apron, 0, y)]
    cushion = cloth(rng) if rng.random() < 0.5 else frame
    plate = (width + 0.01, depth + 0.01, 0.035)
    parts.append(rounded_box(plate, 0.012, cushion, lift=seat - 0.005))

    def leaning(points: Points) -> Points:
        share = np.clip((points[:, 2] - seat) / (top - seat), 0, 1)
        return points + share[:, None] * [0.0, lean, 0.0]

    height = top - seat
    back = [at(box((leg, leg, height), frame, lift=seat), side * x, y) for side in (-1, 1)]
    back += [at(part, 0, y) for part in _chair_back(rng, width - leg, seat, height, frame)]
    return assembled([*parts, *(warped(part, leaning) for part in back)])


def _chair_back(
    rng: np.random.Generator, width: float, seat: float, height: float, frame: Material
) -> list[Mesh]:
    rail = box((width, 0.024, 0.07), frame, lift=seat + height - 0.075)
    design = rng.integers(3)
    if design == 0:
        slat = box((0.028, 0.014, height - 0.06), frame, lift=seat)
        places = np.linspace(-0.36, 0.36, int(rng.integers(4, 7))) * width
        return [rail, *(at(slat, x, 0) for x in places)]
    if design == 1:
        levels = np.linspace(0.3, 0.72, int(rng.integers(2, 4))) * height
        return [rail, *(box((width, 0.018, 0.05), frame, lift=seat + level) for level in levels)]
    pad = rounded_box((width, 0.04, 0.5 * height), 0.015, cloth(rng), lift=seat + 0.42 * height)
    return [rail, pad]


def draw_shell_chair(rng: np.random.Generator) -> Mesh:
    """Return a moulded shell on thin legs."""
    shell = plastic(draw_colour(rng, vivid=0.65), 0.3)
    metal = chrome(rng) if rng.random() < 0.6 else plastic(colour(40, 40, 42))
    half = rng.uniform(0.22, 0.24)
    u, v = np.meshgrid(np.linspace(-1, 1, 13), np.linspace(0, 1, 19))
    # Along v: the seat's front edge, the seat, the bend, the back.
    y = np.interp(v, [0, 0.1, 0.5, 0.62, 1.0], [-0.24, -0.22, 0.12, 0.19, 0.27])
    z = np.interp(v, [0, 0.1, 0.5, 0.62, 1.0], [0.42, 0.445, 0.43, 0.5, 0.84])
    curl = u**2 * np.clip(np.sin(np.pi * np.clip(v, 0.05, 0.95)), 0, 1)
    x = half * u * (1 - 0.25 * np.clip(v - 0.75, 0, 1) * 4 * np.abs(u))
    skin = np.stack([x, y - 0.04 * curl, z + 0.06 * curl], -1)
    legs = [
        tube([(0.6 * sx * half, sy * 0.08, 0.43), (sx * 0.23, sy * 0.22, 0.0)], 0.011, metal)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    # Seats differ by a few centimetres in height.
    tall = rng.uniform(0.93, 1.06)
    return assembled([scaled(part, (1, 1, tall)) for part in (sheet(skin, shell), *legs)])


def draw_office_chair(rng: np.random.Generator) -> Mesh:
    """Return a swivel chair on five castors."""
    cover = cloth(rng) if rng.random() < 0.6 else leather(rng, draw_colour(rng, vivid=0.2))
    black = black_plastic(rng)
    base = black if rng.random() < 0.6 else chrome(rng)
    seat, back = rng.uniform(0.43, 0.5), rng.uniform(0.42, 0.54)
    parts = [
        cylinder(0.028, seat - 0.08, base, n_around=14, lift=0.06),
        rounded_box((0.47, 0.46, 0.08), 0.035, cover, lift=seat - 0.05, n_bevel=2),
    ]
    pad = rounded_box((0.43, 0.07, back), 0.034, cover, n_bevel=2)

    def hollow(points: Points) -> Points:
        curve = 0.9 * points[:, 0] ** 2
        taper = 1 - 0.35 * np.clip(points[:, 2] / back - 0.4, 0, 1)
        return np.stack([points[:, 0] * taper, points[:, 1] - curve, points[:, 2]], 1)

    parts.append(warped(pad, hollow).moved(turned((1, 0, 0), -0.12, (0, 0.22, seat + 0.08))))
    spring = [(0, 0.1, seat - 0.04), (0, 0.27, seat - 0.02), (0, 0.3, seat + 0.25)]
    parts += [tube(spring, 0.018, black), *_castors(base)]
    if rng.random() < 0.5:
        parts += _armrests(seat, black)
    return assembled(parts)


def _castors(base: Material) -> list[Mesh]:
    """Return five legs with a wheel each."""
    leg = tube([(0, 0, 0.1), (0.27, 0, 0.07)], [0.026, 0.016], base, n_around=6)
    upright = turned((1, 0, 0), np.pi / 2, (0.27, 0.02, 0.028))
    wheel = cylinder(0.028, 0.04, rubber(), n_around=10).moved(upright)
    headings = 0.3 + np.arange(5) * 2 * np.pi / 5
    return [at(part, 0, 0, 0, heading) for heading in headings for part in (leg, wheel)]


def _armrests(seat: float, stuff: Material) -> list[Mesh]:
    bend = [(0.2, 0.05, seat - 0.02), (0.27, 0.05, seat), (0.27, 0.05, seat + 0.2)]
    stay = tube(bend, 0.016, stuff, n_around=8)
    rest = at(rounded_box((0.06, 0.25, 0.03), 0.012, stuff, lift=seat + 0.19), 0.27, 0)
    return [stay, rest, scaled(stay, (-1, 1, 1)), scaled(rest, (-1, 1, 1))]


def draw_stool(rng: np.random.Generator) -> Mesh:
    """Return a round stool on three or four splayed legs."""
    height, radius = rng.uniform(0.42, 0.7), rng.uniform(0.15, 0.19)
    frame = _frame_material(rng)
    top = cloth(rng, draw_colour(rng)) if rng.random() < 0.4 else frame
    thick = 0.05 if top is not frame else 0.03
    profile = [(0, 0), (0.94, 0), (1, 0.15), (1, 0.7), (0.93, 1), (0, 1.05)]
    seat = lathe(np.array(profile) * [radius, thick], top, fit=False)
    n_legs = int(rng.integers(3, 5))
    low = height - thick
    parts = [at(seat, 0, 0, low)]
    corners = []
    for angle in np.arange(n_legs) * 2 * np.pi / n_legs + 0.4:
        out = np.array([np.cos(angle), np.sin(angle), 0])
        parts.append(tube([1.05 * radius * out, 0.62 * radius * out + [0, 0, low]], 0.016, frame))
        corners.append(0.9 * radius * out + [0, 0, 0.35 * low])
    parts.append(tube(np.array(corners), 0.009, frame, n_around=8, closed=True))
    return assembled(parts)


def draw_pouf(rng: np.random.Generator) -> Mesh:
    """Return a round or square footstool covered in cloth or leather."""
    radius, height = rng.uniform(0.2, 0.28), rng.uniform(0.3, 0.42)
    hue = draw_colour(rng)
    cover = cloth(rng, hue) if rng.random() < 0.7 else leather(rng, hue)
    if rng.random() < 0.5:
        size = (2 * radius, 2 * radius, height)
        return assembled([rounded_box(size, 0.05, cover, n_bevel=3)])
    profile = [(0, 0), (0.8, 0), (0.95, 0.12), (1, 0.4), (1, 0.6)]
    profile += [(0.95, 0.86), (0.8, 0.97), (0, 1)]
    return assembled([lathe(np.array(profile) * [radius, height], cover, fit=False)])


KINDS = (
    Kind("wooden chair", draw_wooden_chair, FLOOR),
    Kind("shell chair", draw_shell_chair, FLOOR),
    Kind("office chair", draw_office_chair, FLOOR),
    Kind("stool", draw_stool, FLOOR),
    Kind("pouf", draw_pouf, FLOOR),
)
