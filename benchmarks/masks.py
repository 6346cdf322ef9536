"""Score the teacher that masks tell where objects end, with true masks and with worse ones.

    python benchmarks/masks.py [--seeds 21 22 23 24 25 26] [--views 20] [--osd RECORDING]

Masks are the numbers of all parts of a drawn room, walls and furniture too; then spoilt, as a
segmenter spoils them. RECORDING: osd_learn, whose own annotation are the masks. Prints a table,
keeps benchmarks/results/masks.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight import Frame, load_config
from curiosight.datasets import open_dataset
from curiosight.evaluation import TeacherCounts, score_frame
from curiosight.evaluation.instances import InstanceScore, instance_table
from curiosight.experiments.components import survey_dataset
from curiosight.rooms.room import draw_room
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.views import RoomViews
from curiosight.teacher import Teacher

Regions = npt.NDArray[np.int32]
Spoil = Callable[[Regions, np.random.Generator], Regions]
RESULTS = Path(__file__).parent / "results" / "masks.json"
# A Kinect's noise grows with the square of the distance: the teacher is judged up to here.
KINECT_RANGE = 3.5
EDGE_PX = 4


def eroded(masks: Regions, _: np.random.Generator) -> Regions:
    """Take a rim off every mask."""
    square = np.ones((2 * EDGE_PX + 1, 2 * EDGE_PX + 1), np.uint8)
    numbers = masks.astype(np.float32)
    return np.where(cv2.erode(numbers, square) == cv2.dilate(numbers, square), masks, 0)


def dilated(masks: Regions, rng: np.random.Generator) -> Regions:
    """Let masks, in any order, grow over their surroundings."""
    square = np.ones((2 * EDGE_PX + 1, 2 * EDGE_PX + 1), np.uint8)
    grown = masks.copy()
    for number in rng.permutation(np.unique(masks[masks > 0])):
        grown[cv2.dilate((masks == number).astype(np.uint8), square) > 0] = number
    return grown


def jittered(masks: Regions, rng: np.random.Generator) -> Regions:
    """Fray the outlines: every pixel is looked up some way off."""
    height, width = masks.shape
    shift = rng.normal(0, 1, (2, height, width)).astype(np.float32)
    shift = np.stack([cv2.GaussianBlur(field, (0, 0), 4) for field in shift])
    shift *= EDGE_PX / shift.std()
    v, u = np.mgrid[:height, :width]
    rows = np.clip(v + shift[0].round().astype(int), 0, height - 1)
    columns = np.clip(u + shift[1].round().astype(int), 0, width - 1)
    return masks[rows, columns]


def merged(masks: Regions, rng: np.random.Generator) -> Regions:
    """Make one mask of two that touch; half of all pairs that can be made so."""
    pairs = set()
    for one, other in ((masks[:, :-2], masks[:, 2:]), (masks[:-2], masks[2:])):
        is_edge = (one != other) & (one > 0) & (other > 0)
        pairs |= set(zip(one[is_edge].tolist(), other[is_edge].tolist(), strict=True))
    together, used = masks.copy(), set[int]()
    for place in rng.permutation(len(pairs)):
        one, other = sorted(pairs)[place]
        if not used & {one, other} and rng.random() < 0.5:
            together[masks == other] = one
            used |= {one, other}
    return together


def halved(masks: Regions, rng: np.random.Generator) -> Regions:
    """Cut every mask in two through its middle, in any direction."""
    halves = masks.copy()
    for number in np.unique(masks[masks > 0]):
        v, u = np.nonzero(masks == number)
        angle = rng.uniform(0, np.pi)
        side = (u - u.mean()) * np.cos(angle) + (v - v.mean()) * np.sin(angle) > 0
        halves[v[side], u[side]] = number + masks.max()
    return halves


def missing(masks: Regions, rng: np.random.Generator) -> Regions:
    """Leave out every fifth mask."""
    is_left = rng.random(int(masks.max()) + 1) >= 0.2
    return np.where(is_left[masks], masks, 0)


def spoilt(masks: Regions, rng: np.random.Generator) -> Regions:
    """Do the most of these, one after the other."""
    for spoil in (merged, missing, jittered):
        masks = spoil(masks, rng)
    return masks


SPOILS: dict[str, Spoil] = {
    "true": lambda masks, _: masks,
    "eroded": eroded,
    "dilated": dilated,
    "jittered": jittered,
    "merged pairs": merged,
    "halves": halved,
    "20 % missing": missing,
    "merged, missing, jittered": spoilt,
}


@dataclass
class Scores:
    """What one kind of masks comes to."""

    counts: TeacherCounts = field(default_factory=TeacherCounts)
    instances: list[InstanceScore] = field(default_factory=list)

    def row(self) -> dict[str, Any]:
        table = instance_table(self.instances) or {}
        return {
            "precision": self.counts.precision,
            "recall": self.counts.recall,
            "coverage": self.counts.coverage,
            **{name: table[name] for name in ("overlap_f", "boundary_f")},
            **{name: table[name] for name in ("n_true", "n_predicted", "n_detected")},
        }


@dataclass(frozen=True)
class View:
    """A frame with its truth; counted: (H, W) bool, where it counts, None = everywhere."""

    frame: Frame
    truth: npt.NDArray[np.uint8]
    instances: npt.NDArray[np.int32]
    masks: Regions
    counted: npt.NDArray[np.bool_] | None = None


def room_views(dataset: RoomViews) -> Iterator[View]:
    for index in range(len(dataset)):
        look = dataset.look(index)
        near = look.true_depth <= KINECT_RANGE
        instances = np.where(near, dataset.instance_truth(index), -1)
        yield View(look.frame, look.truth, instances, look.ids, near)


def osd_views(path: Path) -> Iterator[View]:
    dataset = open_dataset(path)
    for index in range(len(dataset)):
        truth = dataset.ground_truth(index)
        if truth is not None:
            instances = dataset.instance_truth(index)
            yield View(dataset[index], truth, instances, np.maximum(instances, 0))


def score(scores: dict[str, Scores], teacher: Teacher, views: Iterator[View], seed: int) -> None:
    """Add what each kind of masks comes to, and depth alone."""
    for place, view in enumerate(views):
        for name in ("depth alone", *SPOILS):
            teacher.masks = None
            if name in SPOILS:
                masks = SPOILS[name](view.masks, np.random.default_rng([seed, place]))
                teacher.masks = lambda _, masks=masks: masks.astype(np.int32)
            said = teacher.segment(view.frame)
            scored = score_frame(view.frame, said, view.truth, view.instances, counted=view.counted)
            one = scores.setdefault(name, Scores())
            one.counts += scored.counts
            one.instances.append(scored.instances)


def show(title: str, rows: dict[str, dict[str, Any]]) -> None:
    print(title)
    for name, row in rows.items():
        print(
            f"  {name:26} precision {row['precision']:.4f}  recall {row['recall']:.4f}  "
            f"coverage {row['coverage']:.4f}  objects {row['n_detected']}/{row['n_true']}, "
            f"{row['n_predicted']} told  overlap F {100 * row['overlap_f']:.1f}  "
            f"boundary F {100 * row['boundary_f']:.1f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[21, 22, 23, 24, 25, 26])
    parser.add_argument("--views", type=int, default=20, help="of every room")
    parser.add_argument("--osd", type=Path, help="a recording whose objects are told apart")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    config, tables = load_config(), dict[str, dict[str, Any]]()
    scores: dict[str, Scores] = {}
    for seed in arguments.seeds:
        room = RoomViews(draw_room(RoomSettings(seed, views=arguments.views)))
        teacher = Teacher(survey_dataset(config, room), config.segmentation)
        score(scores, teacher, room_views(room), seed)
    title = f"rooms {' '.join(map(str, arguments.seeds))}, {arguments.views} views each"
    tables[title] = {name: one.row() for name, one in scores.items()}
    show(title, tables[title])
    if arguments.osd is not None:
        dataset, scores = open_dataset(arguments.osd), {}
        teacher = Teacher(survey_dataset(config, dataset), config.segmentation)
        score(scores, teacher, osd_views(arguments.osd), 0)
        tables[arguments.osd.name] = {name: one.row() for name, one in scores.items()}
        show(arguments.osd.name, tables[arguments.osd.name])
    RESULTS.write_text(json.dumps(tables, indent=1) + "\n")


if __name__ == "__main__":
    main()
