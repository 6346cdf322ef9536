"""Score teacher and learner in drawn rooms, and how hard the rooms are.

    python benchmarks/rooms.py teacher [--seeds 11 12 13 14 15]
    python benchmarks/rooms.py learner [--seeds 11 12 13 14 15] [--run-seeds 0 1] [--only default]
    python benchmarks/rooms.py sheet FILE [--seeds 1 2 … 12]

Thresholds, features and rooms were made looking at seeds below 10 and above 20.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from teacher import write_sheet

from curiosight import load_config, make_teacher
from curiosight.evaluation import MapScores, TeacherCounts, score_frame
from curiosight.evaluation.baselines import Saliency
from curiosight.evaluation.baselines.opencv import fine_grained, spectral_residual
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Rgb
from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.scene import Role
from curiosight.rooms.settings import RoomSettings, SensorName
from curiosight.rooms.truth import draw_truth
from curiosight.rooms.views import Look, RoomViews

Camera = tuple[float, float]  # metres over the floor, degrees down

RESULTS = Path(__file__).parent / "results"
N_TEACHER_VIEWS = 20
N_TEST_VIEWS = 40
N_STEPS = 200
# A Kinect's noise grows with the square of the distance: the teacher is judged up to here.
KINECT_RANGE = 3.5
SENSORS: tuple[SensorName, ...] = ("perfect", "kinect")
PARTS = ("near", "beyond_range", "missing")
BASELINES: dict[str, Callable[[Rgb], Saliency]] = {
    "fine_grained": fine_grained,
    "spectral_residual": spectral_residual,
}
METHODS = (*BASELINES, "paper", "default")
# The truth of today, and that of before, by which no furniture was an object.
TRUTHS = ("bare small furniture is salient", "no furniture is salient")


def score_teacher(
    seeds: list[int], cameras: list[Camera], sensors: list[SensorName], sheets: Path | None
) -> None:
    """Print precision and recall of the teacher by both truths, and its worst views."""
    rows: dict[str, Any] = {}
    for sensor, (height, tilt) in product(sensors, cameras):
        counts: dict[str, list[TeacherCounts]] = {}
        for seed in seeds:
            room = RoomSettings(
                seed, sensor=sensor, views=N_TEACHER_VIEWS, height=height, tilt=tilt
            )
            counts |= score_views(RoomViews(draw_room(room)), sheets)
        for place, truth in enumerate(TRUTHS):
            total = sum((both[place] for both in counts.values()), TeacherCounts())
            rows.setdefault(f"{sensor} {height} m {tilt:g} deg", {})[truth] = total.shares()
            print(
                f"{sensor:8} {height} m {tilt:2.0f}°  {truth:34} precision {total.precision:.4f}  "
                f"recall {total.recall:.4f}  coverage {total.coverage:.4f}",
                flush=True,
            )
        now = {view: both[0] for view, both in counts.items()}
        wrong = sorted(now, key=lambda view: now[view].n_salient_right - now[view].n_salient)
        missed = sorted(now, key=lambda view: now[view].n_whole_found - now[view].n_whole)
        print("  most wrong:", "; ".join(wrong[:3]), " most missed:", "; ".join(missed[:3]))
    RESULTS.mkdir(exist_ok=True)
    kept = {"seeds": seeds, "views": N_TEACHER_VIEWS, **rows}
    (RESULTS / "rooms-teacher.json").write_text(json.dumps(kept, indent=1) + "\n")


def score_views(views: RoomViews, sheets: Path | None) -> dict[str, list[TeacherCounts]]:
    """Return the teacher's counts of every view, by its name, for each of the truths."""
    settings = views.room.settings
    teacher = make_teacher(load_config(), views)
    max_range = KINECT_RANGE if settings.sensor == "kinect" else np.inf
    furniture = {placed.furniture.name for placed in views.room.furniture}
    parts = [
        replace(part, role=Role.SUPPORT) if part.name in furniture else part
        for part in views.room.scene.parts
    ]
    counts = {}
    for index, id in enumerate(views.ids):
        look = views.look(index)
        segmentation = teacher.segment(look.frame)
        near = look.true_depth <= max_range
        counts[f"{views.path} {id}"] = [
            score_frame(look.frame, segmentation, truth, counted=near).counts
            for truth in (look.truth, draw_truth(look.ids, parts))
        ]
        if sheets:
            path = sheets / f"{settings.sensor}-{settings.seed}-{id}.png"
            write_sheet(path, look.frame, look.truth, segmentation)
    return counts


def score_learner(seeds: list[int], run_seeds: list[int], methods: list[str]) -> None:
    """Explore each room, move its things, and print how well they are found."""
    rows: dict[str, Any] = {}
    for seed in seeds:
        room = draw_room(RoomSettings(seed))
        looks = moved_looks(room)
        for name in methods:
            if name in BASELINES:
                maps = [BASELINES[name]]
            else:
                maps = [explored(room, name, run_seed) for run_seed in run_seeds]
            scored = [score_maps(saliency, looks) for saliency in maps]
            figures = {part: float(np.mean([one[part] for one in scored])) for part in scored[0]}
            rows.setdefault(name, {})[seed] = figures
            written = (f"{part} {figure:.3f}" for part, figure in figures.items())
            print(f"room:{seed} {name:18}", *written, flush=True)
    for name, of_seed in rows.items():
        means = {
            part: np.mean([figures[part] for figures in of_seed.values()])
            for part in ("all", *PARTS, "error")
        }
        print(f"mean    {name:18}", *(f"{part} {mean:.3f}" for part, mean in means.items()))
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / "rooms-learner.json"
    before = json.loads(path.read_text()) if path.exists() else {}
    kept = {**before, "run_seeds": run_seeds, **rows}
    path.write_text(json.dumps(kept, indent=1) + "\n")


def moved_looks(room: Room) -> list[Look]:
    """Return views of a room whose things were moved."""
    moved = RoomViews(room.rearranged(1)).test_views(N_TEST_VIEWS)
    return [moved.look(index) for index in range(len(moved))]


def explored(room: Room, preset: str, run_seed: int) -> Callable[[Rgb], Saliency]:
    """Return the map that an exploration of a room learned."""
    config = load_config(preset, None, {"explorer.n_steps": N_STEPS, "run.seed": run_seed})
    with tempfile.TemporaryDirectory() as folder:
        out = OutputFolder(Path(folder) / "out", "explore", Path("room"))
        run = Exploration(config, RoomViews(room), out)
        for _ in run:
            pass
        run.finish()
    return run.learner.saliency


def score_maps(saliency: Callable[[Rgb], Saliency], looks: list[Look]) -> dict[str, float]:
    """Return the AUC of every part of the pixels, and the overall error."""
    scores = MapScores()
    for number, look in enumerate(looks):
        frame = look.frame
        found = saliency(frame.rgb)
        scores.add(str(number), found, look.truth, depth=frame.depth, true_depth=look.true_depth)
    figures = {part: float(scores.ranking(part).roc_auc or 0) for part in ("all", *PARTS)}
    return figures | {"error": float(scores.table()["overall_error"])}


def draw_sheet(path: Path, seeds: list[int], n_views: int = 4) -> None:
    """Draw some views of each room, a room a row of two columns."""
    strips = []
    for seed in seeds:
        views = RoomViews(draw_room(RoomSettings(seed, views=n_views)))
        pictures = [
            cv2.resize(views[index].rgb, (200, 150), interpolation=cv2.INTER_AREA)
            for index in range(n_views)
        ]
        strips.append(np.hstack(pictures))
    half = len(strips) // 2
    gap = np.full((150 * half, 12, 3), 255, np.uint8)
    sheet = np.hstack([np.vstack(strips[:half]), gap, np.vstack(strips[half : 2 * half])])
    cv2.imwrite(str(path), sheet[..., ::-1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("teacher", "learner", "sheet"):
        command = commands.add_parser(name)
        default = list(range(1, 13)) if name == "sheet" else [11, 12, 13, 14, 15]
        command.add_argument("--seeds", type=int, nargs="+", default=default)
        if name == "teacher":
            command.add_argument("--heights", action="store_true", help="0.4-1.6 m, 0-45° too")
            command.add_argument("--sensors", nargs="+", choices=SENSORS, default=list(SENSORS))
            command.add_argument("--sheets", type=Path, help="write a picture a view")
        if name == "learner":
            command.add_argument("--run-seeds", type=int, nargs="+", default=[0, 1])
            kept = "these; what was measured of the others is kept"
            command.add_argument("--only", nargs="+", choices=METHODS, default=METHODS, help=kept)
        if name == "sheet":
            command.add_argument("file", type=Path)
    arguments = parser.parse_args()
    if arguments.command == "teacher":
        cameras = [(1.0, 10.0)]
        if arguments.heights:
            cameras += [(0.4, 0.0), (0.4, 30.0), (1.6, 20.0), (1.6, 45.0)]
        score_teacher(arguments.seeds, cameras, arguments.sensors, arguments.sheets)
    elif arguments.command == "learner":
        score_learner(arguments.seeds, arguments.run_seeds, arguments.only)
    else:
        draw_sheet(arguments.file, arguments.seeds)


if __name__ == "__main__":
    main()
