"""Score the teacher on single pieces of furniture: which are objects, which carry objects.

    python benchmarks/furniture.py [--kinds cabinet armchair …] [--seeds 1 2 3] [--sensor kinect]
        [--unposed] [--sheets DIR]

Each piece stands free in an empty room and is looked at from all sides. Precision and recall are
over all pixels within the sensor's range; recall counts what no image cuts, as everywhere. Carriers
have "not salient" as their truth: of them the share recognised as such counts, and how much of
what they carry is found. Thresholds were made looking at seeds below 10.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from teacher import write_sheet

from curiosight import load_config, make_teacher
from curiosight.evaluation import TeacherCounts, score_frame
from curiosight.frame import Label, Pose
from curiosight.rooms.arrangement import Thing
from curiosight.rooms.blocks import block
from curiosight.rooms.furniture import Furniture, Placed, soft, storage, tables
from curiosight.rooms.materials import plastic
from curiosight.rooms.mesh import Mesh, join, standing
from curiosight.rooms.palette import draw_colour
from curiosight.rooms.plan import FloorPlan
from curiosight.rooms.room import Room
from curiosight.rooms.settings import RoomSettings, SensorName
from curiosight.rooms.shell import draw_shell
from curiosight.rooms.things import KINDS as THINGS
from curiosight.rooms.truth import MAX_SIZE, across
from curiosight.rooms.viewpoints import camera_pose
from curiosight.rooms.views import RoomViews

KINECT_RANGE = 3.5
N_VIEWS = 12
ROOM_SIZE, MIDDLE = 6.0, (3.0, 3.0)
Draw = Callable[[np.random.Generator], Furniture]


def cabinet(rng: np.random.Generator) -> Furniture:
    """Draw a closed cabinet, from a bedside one to a small sideboard."""
    return _solid("cabinet", (0.3, 1.2), (0.3, 0.55), (0.4, 1.0), rng)


def cabinet_of_the_report(rng: np.random.Generator) -> Furniture:
    """Draw a cabinet of .80 × .46 × .55 m."""
    return _solid("cabinet", (0.8, 0.8), (0.46, 0.46), (0.55, 0.55), rng)


def washing_machine(rng: np.random.Generator) -> Furniture:
    """Draw a white block of 60 cm."""
    return _solid("washing machine", (0.58, 0.6), (0.5, 0.62), (0.84, 0.86), rng)


def carton(rng: np.random.Generator) -> Furniture:
    """Draw a box, low or high."""
    return _solid("carton", (0.25, 0.8), (0.25, 0.6), (0.2, 0.6), rng)


def armchair(rng: np.random.Generator) -> Furniture:
    """Draw a chair with arms and a back that is no larger than objects are."""
    while True:
        chair = soft.armchair(rng)
        if across(chair.mesh) < MAX_SIZE - 0.03:
            return chair


def stool(rng: np.random.Generator) -> Furniture:
    """Draw a square seat on four legs."""
    side, height = float(rng.uniform(0.3, 0.42)), float(rng.uniform(0.42, 0.7))
    return tables._long_table("stool", (side, side, height), rng)


def container(rng: np.random.Generator) -> Furniture:
    """Draw an open bin, empty or with something in it."""
    x, y = float(rng.uniform(0.1, 0.3)), float(rng.uniform(0.1, 0.2))
    height, wall, stuff = float(rng.uniform(0.25, 0.6)), 0.01, plastic(draw_colour(rng))
    ends = ((-x, wall - x), (x - wall, x)), ((-y, wall - y), (y - wall, y))
    sides = [block(end, (-y, y), (0, height), stuff) for end in ends[0]]
    sides += [block((-x, x), end, (0, height), stuff) for end in ends[1]]
    sides.append(block((-x, x), (-y, y), (0, wall), stuff))
    if rng.random() < 0.5:
        held = plastic(draw_colour(rng))
        sides.append(block((-0.6 * x, 0.3 * x), (-0.7 * y, 0.5 * y), (wall, 0.7 * height), held))
    return Furniture("container", join(sides), (2 * x, 2 * y, height))


def small_desk(rng: np.random.Generator) -> Furniture:
    """Draw a desk that is no larger than objects are."""
    size = (float(rng.uniform(0.8, 1.05)), float(rng.uniform(0.5, 0.6)), 0.74)
    return tables._long_table("small desk", size, rng)


def side_table(rng: np.random.Generator) -> Furniture:
    """Draw a little table."""
    side, height = float(rng.uniform(0.4, 0.6)), float(rng.uniform(0.4, 0.6))
    return tables._long_table("side table", (side, side, height), rng)


def _solid(name: str, *ranges: object) -> Furniture:
    """Draw a closed cupboard that is no larger than objects are; ranges: metres, then chance."""
    *sides, rng = ranges
    while True:
        width, depth, height = (float(rng.uniform(*side)) for side in sides)
        if np.hypot(np.hypot(width, depth), height) < MAX_SIZE - 0.08:
            size = (width, depth, height)
            return storage._cupboard(name, size, max(1, round(width / 0.5)), 1, rng)


def sideboard(rng: np.random.Generator) -> Furniture:
    """Draw a cupboard that is wider than any object."""
    ranges = (1.7, 2.6), (0.35, 0.5), (0.7, 1.0)
    width, depth, height = (float(rng.uniform(*side)) for side in ranges)
    return storage._cupboard("sideboard", (width, depth, height), 4, 1, rng)


BARE: dict[str, Draw] = {
    "report": cabinet_of_the_report,
    "cabinet": cabinet,
    "washing-machine": washing_machine,
    "carton": carton,
    "armchair": armchair,
    "stool": stool,
    "container": container,
    "coffee-table": tables.coffee_table,
    "small-desk": small_desk,
    "table": tables.table,
    "sofa": soft.sofa,
    "sideboard": sideboard,
}
LADEN: dict[str, Draw] = {
    "laden-side-table": side_table,
    "laden-coffee-table": tables.coffee_table,
    "laden-stool": stool,
    "laden-cabinet": cabinet,
    "laden-table": tables.table,
}
DRAWS = BARE | LADEN


def draw_views(kind: str, seed: int, sensor: SensorName) -> RoomViews:
    """Return views from all sides of a piece in the middle of an empty room."""
    rng = np.random.default_rng(seed)
    plan = FloorPlan(ROOM_SIZE * np.array([(0, 0), (1, 0), (1, 1), (0, 1)]), 2.5)
    shell = draw_shell(plan, rng)
    piece = Placed(DRAWS[kind](rng), standing(*MIDDLE, 0.0, rng.uniform(-np.pi, np.pi)))
    things = tuple(_load(piece, rng)) if kind in LADEN else ()
    settings = RoomSettings(seed, sensor=sensor, views=N_VIEWS)
    room = Room(settings, plan, shell, (piece,), things, things)
    return RoomViews(room, _poses(rng))


def _load(piece: Placed, rng: np.random.Generator) -> list[Thing]:
    """Return one to three things on a piece's top, apart from each other."""
    kinds = [kind for kind in THINGS if kind.places == {"table"}]
    (T_room_top, area), things = piece.tops[0], list[Thing]()
    low, high = np.reshape(area, (2, 2))
    taken: list[np.ndarray] = []
    n_things = int(rng.integers(1, 4))
    for _ in range(60):
        kind = kinds[rng.integers(len(kinds))]
        mesh: Mesh = kind.draw(rng)
        pose: Pose = standing(*rng.uniform(low, high), 0.0, rng.uniform(-np.pi, np.pi))
        corners = np.array(mesh.moved(pose).bounds)[:, :2]
        is_in = (corners[0] > low - 0.02).all() and (corners[1] < high + 0.02).all()
        is_free = all(
            (corners[0] > t[1] + 0.05).any() | (corners[1] < t[0] - 0.05).any() for t in taken
        )
        if is_in and is_free:
            taken.append(corners)
            things.append(Thing(kind, mesh, False, T_room_top @ pose))
        if len(things) == n_things:
            break
    return things


def _poses(rng: np.random.Generator) -> list[Pose]:
    """Return poses on a ring around the middle that look at it, near or far, low or high."""
    poses = []
    for heading in np.linspace(0, 360, N_VIEWS, endpoint=False) + rng.uniform(0, 30):
        distance, height = rng.uniform(1.5, 2.6), rng.uniform(0.7, 1.4)
        tilt = np.degrees(np.arctan2(height - 0.35, distance)) + rng.uniform(-4, 4)
        away = distance * np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading))])
        x, y = np.array(MIDDLE) - away
        poses.append(camera_pose(float(x), float(y), heading, height=height, tilt_deg=float(tilt)))
    return poses


def score(
    kind: str, seed: int, sensor: SensorName, *, posed: bool, sheets: Path | None
) -> tuple[TeacherCounts, np.ndarray]:
    """Return the counts of a piece, and (2,) pixels of truth's 0 on it: all, and recognised."""
    views = draw_views(kind, seed, sensor)
    frames = [views[index] for index in range(len(views))]
    teacher = make_teacher(load_config(), views if posed else _Unposed(views))
    total, on_piece = TeacherCounts(), np.zeros(2, int)
    place = len(views.room.shell.parts) + 1
    for index, frame in enumerate(frames):
        look = views.look(index)
        frame = frame if posed else replace(frame, T_world_camera=None)
        segmentation = teacher.segment(frame)
        near = look.true_depth <= (KINECT_RANGE if sensor == "kinect" else np.inf)
        total += score_frame(frame, segmentation, look.truth, counted=near).counts
        is_piece = near & (look.ids == place) & (look.truth == Label.NOT_SALIENT)
        is_known = is_piece & (segmentation.labels == Label.NOT_SALIENT)
        on_piece += np.count_nonzero(is_piece), np.count_nonzero(is_known)
        if sheets is not None:
            path = sheets / f"{kind}-{seed}-{index:02}.png"
            write_sheet(path, frame, look.truth, segmentation)
    return total, on_piece


class _Unposed:
    """The views as a recording without poses."""

    def __init__(self, views: RoomViews) -> None:
        self._views = views

    def __getattr__(self, name: str) -> object:
        return getattr(self._views, name)

    def __len__(self) -> int:
        return len(self._views)

    def __getitem__(self, index: int) -> object:
        return replace(self._views[index], T_world_camera=None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", nargs="+", default=list(DRAWS), choices=list(DRAWS))
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--sensor", default="kinect")
    parser.add_argument("--unposed", action="store_true", help="as if there were no poses")
    parser.add_argument("--sheets", type=Path, help="write a picture a view")
    arguments = parser.parse_args()
    for kind in arguments.kinds:
        total, on_piece = TeacherCounts(), np.zeros(2, int)
        for seed in arguments.seeds:
            counts, pixels = score(
                kind,
                seed,
                arguments.sensor,
                posed=not arguments.unposed,
                sheets=arguments.sheets,
            )
            total, on_piece = total + counts, on_piece + pixels
        shares = {
            name: "–" if share is None else f"{share:.3f}" for name, share in total.shares().items()
        }
        recognised = f"{on_piece[1] / on_piece[0]:.3f}" if on_piece[0] else "–"
        print(
            f"{kind:20} precision {shares['precision']}  recall {shares['recall']}  "
            f"coverage {shares['coverage']}  its 0 recognised {recognised}",
            flush=True,
        )


if __name__ == "__main__":
    main()
