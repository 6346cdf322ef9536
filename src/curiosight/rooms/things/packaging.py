"""What is bought packed: boxes, cartons, cans, bottles, jars."""

from __future__ import annotations

import numpy as np

from curiosight.rooms import prints, textures
from curiosight.rooms.materials import chrome, glass, near, plastic, printed, steel
from curiosight.rooms.mesh import Material, Mesh, Texture, join
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.round_shapes import cylinder, lathe
from curiosight.rooms.shapes import box, box_faces, extrude, panel
from curiosight.rooms.surfaces import scaled, sheet, turned
from curiosight.rooms.things.kind import ANYWHERE, TABLE, Kind, assembled, at

BOTTLE_GLASS = ((40, 66, 38), (70, 44, 22), (120, 150, 136), (150, 170, 172), (44, 76, 110))


def packet(
    size: tuple[float, float, float], front: Material, side: Material, lid: Material
) -> Mesh:
    """Return a box with one print in front and behind, another on its sides, and lids."""
    materials = (front, front, side, side, lid, lid)
    faces = zip(box_faces(size), materials, strict=True)
    return join([panel(*face, material, spacing=0.04, fit=True) for face, material in faces])


def draw_cereal_box(rng: np.random.Generator) -> Mesh:
    """Return a flat, upright cardboard box with prints."""
    size = rng.uniform(0.15, 0.22), rng.uniform(0.045, 0.08), rng.uniform(0.22, 0.32)
    front, side = printed(prints.label(rng)), printed(prints.label(rng))
    lid = printed(textures.plain(draw_colour(rng, vivid=0.8)))
    return assembled([packet(size, front, side, lid)])


def draw_packet(rng: np.random.Generator) -> Mesh:
    """Return a small printed box, standing or lying: tea, pasta, medicine."""
    size = rng.uniform(0.07, 0.11), rng.uniform(0.05, 0.09), rng.uniform(0.12, 0.19)
    body = packet(
        size,
        printed(prints.label(rng), gloss=0.2),
        printed(prints.label(rng), gloss=0.2),
        printed(textures.plain(draw_colour(rng, vivid=0.8)), gloss=0.2),
    )
    lies = rng.random() < 0.4
    return assembled([body.moved(turned((1, 0, 0), np.pi / 2)) if lies else body])


def draw_milk_carton(rng: np.random.Generator) -> Mesh:
    """Return a carton with a gabled top and a screw cap."""
    side, height = rng.uniform(0.065, 0.095), rng.uniform(0.17, 0.22)
    face, flank = printed(prints.label(rng)), printed(prints.label(rng))
    white = plastic(near(rng, (226, 226, 220), 6), 0.1)
    gable = 0.55 * side
    roof = extrude([(-side / 2, 0), (side / 2, 0), (0, gable)], side, white)
    upright = roof.moved(turned((1, 0, 0), np.pi / 2, (0, side / 2, height)))
    parts = [
        packet((side, side, height), face, flank, white),
        at(upright, 0, 0, 0, np.pi / 2),
        box((side, 0.004, 0.02), white, lift=height + gable - 0.004),
    ]
    if rng.random() < 0.6:
        cap = cylinder(0.014, 0.014, plastic(draw_colour(rng, vivid=0.9)), n_around=16)
        lean = np.arctan2(gable, side / 2)
        place = (0, -side / 4, height + gable / 2)
        parts.append(cap.moved(turned((1, 0, 0), lean, place)))
    return assembled(parts)


def draw_tin(rng: np.random.Generator) -> Mesh:
    """Return one tin with a paper label, or some on each other."""
    radius, height = rng.uniform(0.036, 0.055), rng.uniform(0.09, 0.13)
    tins = [_tin(rng, radius, height) for _ in range(int(rng.choice([1, 1, 2, 3])))]
    return assembled([at(tin, 0, 0, i * height, rng.uniform(0, 6)) for i, tin in enumerate(tins)])


def _tin(rng: np.random.Generator, radius: float, height: float) -> Mesh:
    metal = steel(rng)
    ends = [(0, 0.004), (radius - 0.003, 0.004), (radius - 0.002, 0), (radius, 0), (radius, height)]
    ends += [(radius - 0.002, height), (radius - 0.003, height - 0.005), (0, height - 0.005)]
    side = radius + 0.0008
    label = lathe([(side, 0.006), (side, height - 0.006)], printed(wrapped_label(rng)))
    return join([lathe(ends, metal, n_around=28, fit=False), label])


def wrapped_label(rng: np.random.Generator) -> Texture:
    """Return a print for something round: its front comes twice."""
    label = prints.label(rng, (192, 240))
    return np.concatenate([label, label], axis=1)


def draw_drink_can(rng: np.random.Generator) -> Mesh:
    """Return a printed aluminium can."""
    radius, height = 0.033, rng.uniform(0.115, 0.168)
    foot = [(0.024, 0.0), (0.026, 0.0), (radius, 0.012)]
    neck = [(radius, height - 0.014), (0.027, height - 0.002), (0.027, height)]
    top = [(0.0255, height), (0.025, height - 0.004), (0, height - 0.004)]
    print_side = lathe([foot[-1], neck[0]], printed(wrapped_label(rng), gloss=0.6))
    metal = chrome(rng)
    return assembled([lathe(foot, metal), print_side, lathe([*neck, *top], metal)])


def draw_wine_bottle(rng: np.random.Generator) -> Mesh:
    """Return a glass bottle with a paper label and a capsule."""
    radius, height = rng.uniform(0.034, 0.042), rng.uniform(0.24, 0.33)
    shoulder, neck = rng.uniform(0.5, 0.66) * height, rng.uniform(0.72, 0.8) * height
    tint = near(rng, BOTTLE_GLASS[rng.integers(len(BOTTLE_GLASS))])
    profile = [(0, 0), (radius * 0.95, 0), (radius, 0.006), (radius, shoulder)]
    profile += [(radius * 0.9, shoulder + 0.02), (0.02, neck - 0.01), (0.0145, neck)]
    body = lathe([*profile, (0.014, height), (0, height)], glass(tint), n_around=28, fit=False)
    low, high = rng.uniform(0.1, 0.2) * height, shoulder - rng.uniform(0.01, 0.03)
    paper = lathe([(radius + 0.0006, low), (radius + 0.0006, high)], printed(wrapped_label(rng)))
    foil = cylinder(0.0155, 0.2 * height, plastic(draw_colour(rng), 0.4), lift=0.81 * height)
    return assembled([body, paper, foil])


def draw_plastic_bottle(rng: np.random.Generator) -> Mesh:
    """Return a bottle of detergent, shampoo or sauce, with a printed band and a cap."""
    width, depth = rng.uniform(0.06, 0.1), rng.uniform(0.045, 0.06)
    height = rng.uniform(0.17, 0.27)
    shell = plastic(draw_colour(rng, vivid=0.65), 0.35)
    profile = [(0, 0), (0.92, 0), (1, 0.03), (1, 0.35), (0.93, 0.45), (0.98, 0.6)]
    profile += [(0.9, 0.74), (0.6, 0.82), (0.3, 0.85), (0.28, 0.88), (0, 0.88)]
    squash = np.array([width / 2, height])
    body = lathe(np.array(profile) * squash, shell, n_around=28, fit=False)
    sleeve = np.array([(1.01, 0.06), (1.01, 0.34)]) * squash
    band = lathe(sleeve, printed(wrapped_label(rng), gloss=0.3))
    cap = plastic(draw_colour(rng, vivid=0.6), 0.3)
    flat = [scaled(part, (1, depth / width, 1)) for part in (body, band)]
    return assembled([*flat, cylinder(0.016, 0.14 * height, cap, lift=0.87 * height)])


def draw_jar(rng: np.random.Generator) -> Mesh:
    """Return a jar of preserves with a label and a bright lid."""
    radius, height = rng.uniform(0.035, 0.05), rng.uniform(0.09, 0.15)
    preserves = ((130, 30, 28), (196, 130, 40), (112, 122, 62), (84, 52, 34))
    content = near(rng, preserves[rng.integers(4)])
    body = [(0, 0), (0.9, 0), (1, 0.05), (1, 0.75), (0.82, 0.86), (0.82, 0.88), (0, 0.88)]
    jar = lathe(np.array(body) * [radius, height], glass(content), n_around=28, fit=False)
    side = radius + 0.0006
    label = lathe([(side, 0.15 * height), (side, 0.62 * height)], printed(wrapped_label(rng)))
    lid = plastic(draw_colour(rng, vivid=0.8), 0.4)
    return assembled([jar, label, cylinder(0.88 * radius, 0.16 * height, lid, lift=0.84 * height)])


def draw_pouch(rng: np.random.Generator) -> Mesh:
    """Return a filled bag of crisps, coffee or flour with a print."""
    width, height, depth = rng.uniform(0.14, 0.24), rng.uniform(0.2, 0.3), rng.uniform(0.07, 0.1)
    across, up = np.linspace(-1, 1, 13), np.linspace(0, 1, 13)
    u, v = np.meshgrid(across, up)
    # Full at the belly, folded flat at the top: its two foils meet along the edges.
    bulge = (1 - u**4) * np.minimum(1, 0.75 + v) * (1 - v**5)
    ripple = 0.004 * np.sin(9 * u + rng.uniform(0, 6)) * np.sin(7 * v + rng.uniform(0, 6))
    x = width / 2 * u * (1 - 0.08 * bulge)
    y = bulge * (depth / 2 + ripple)
    foil = printed(prints.label(rng), gloss=rng.choice([0.1, 0.6]))
    front = sheet(np.stack([x, -y, v * height], -1), foil)
    back = sheet(np.stack([-x, y, v * height], -1), foil)
    return assembled([front, back])


def draw_parcel(rng: np.random.Generator) -> Mesh:
    """Return a cardboard box closed with tape, an address on it."""
    size = rng.uniform(0.22, 0.5), rng.uniform(0.18, 0.38), rng.uniform(0.13, 0.36)
    width, depth, height = size
    card = Material(textures.plaster(rng, near(rng, (176, 136, 92), 10)), (0.4, 0.4))
    tape = plastic(near(rng, (196, 164, 112), 8), 0.4)
    strip = rng.uniform(0.04, 0.06)
    paper = printed(prints.label(rng) if rng.random() < 0.5 else prints.page(rng))
    label = panel((0, 0, 0), (0.3 * width, 0, 0), (0, 0, 0.4 * height), paper, fit=True)
    x, z = rng.uniform(-0.4, 0.1) * width, rng.uniform(0.2, 0.5) * height
    parts = [
        box(size, card),
        *_tape(size, strip, tape),
        at(label, x, -depth / 2 - 0.0008, z),
    ]
    return assembled(parts)


def _tape(size: tuple[float, float, float], strip: float, tape: Material) -> list[Mesh]:
    """Return a strip over the top of a box of this size, and down its sides a little."""
    width, _, height = size
    # No edges: their light would be that of the box's inside, where they start.
    around = box_faces((width + 0.0016, strip, height / 3), lift=2 / 3 * height + 0.0008)
    return [panel(*face, tape) for face in around[2:5]]


KINDS = (
    Kind("cereal box", draw_cereal_box, TABLE),
    Kind("packet", draw_packet, TABLE),
    Kind("milk carton", draw_milk_carton, TABLE),
    Kind("tin", draw_tin, TABLE),
    Kind("drink can", draw_drink_can, TABLE),
    Kind("wine bottle", draw_wine_bottle, TABLE),
    Kind("plastic bottle", draw_plastic_bottle, TABLE),
    Kind("jar", draw_jar, TABLE),
    Kind("pouch", draw_pouch, TABLE),
    Kind("parcel", draw_parcel, ANYWHERE),
)
