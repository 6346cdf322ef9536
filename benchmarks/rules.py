"""What each rule of the teacher is worth: it is left out, and every recording scored again.

    python benchmarks/rules.py DATA [--rules T3 W2 …] [--columns arm exact …] [--frames 30]
    python benchmarks/rules.py --table

The first leaves out one rule after the other on the recordings in the folder DATA and in drawn
rooms, and keeps the figures in results/rules.json, each beside those of the whole teacher in the
same run; the second writes the table of docs/teacher.md anew from them. A rule is a function, a
test or a threshold, see `ablations.py`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from ablations import RULES, Rule
from furniture import draw_views

from curiosight.config import load_config
from curiosight.datasets import Dataset, KnowsDistances, KnowsInstances
from curiosight.datasets.dataset import InstanceTruth
from curiosight.evaluation import TeacherScores, score_frame
from curiosight.experiments.components import make_teacher
from curiosight.frame import Camera, Frame, Label
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "rules.json"
DOCUMENT = Path(__file__).parents[1] / "docs" / "teacher.md"
BEGIN, END = "<!-- rules: begin -->", "<!-- rules: end -->"
# The folders of recordings, below DATA, and what the table calls them.
REAL = {
    "osd_learn": "osd_learn",
    "redkitchen": "redkitchen/seq-01",
    "over a bin": "others/top-down/plain-clutter",
    "over a table": "others/top-down/plain-single",
    "small tables": "others/small-tables/plain",
    "living room": "others/depth-edge/plain-room",
    "low robot": "others/far-readings/plain",
}
# Not the rooms that figures are reported of.
DRAWN = {
    "Kinect": "room:{seed},sensor=kinect,views=12",
    "from .5 m": "room:{seed},sensor=kinect,views=12,height=0.5,tilt=10",
    "from 1.6 m": "room:{seed},sensor=kinect,views=12,height=1.6,tilt=35",
    "stereo": "room:{seed},sensor=stereo,views=12",
    "lidar": "room:{seed},sensor=lidar,views=12",
    "arm": "room:{seed},sensor=kinect,views=12,over=table",
}
SEEDS = (21, 22)
# Pieces of furniture that stand free, posed views all round, see `furniture.py`.
FURNITURE = {
    "bare furniture": ("cabinet", "armchair", "container", "small-desk"),
    "laden furniture": ("laden-side-table", "laden-coffee-table", "laden-cabinet"),
}
FURNITURE_SEED = 4
# What one column or another is for: a sensor that is as good as its range is long, cupboards that
# are wider than any object and of whose corner no pose tells, and things that show no side.
EXACT = "room:{seed},sensor=perfect,views=12"
CUPBOARDS = ("sideboard", (4, 5, 6))
# As for the figures reported: a Kinect's noise grows with the square of the distance.
DRAWN_RANGE = 3.5
# Less, in points, is not told.
LEAST = 0.05


class Kept:
    """A recording with its frames and truths in memory, so that no rule pays for drawing it."""

    def __init__(
        self,
        source: str | Dataset,
        n_frames: int,
        max_range: float = np.inf,
        *,
        is_posed: bool = True,
    ) -> None:
        self._dataset: Dataset = open_source(source) if isinstance(source, str) else source
        self._frames = [self._dataset[index] for index in range(len(self._dataset))]
        if not is_posed:
            self._frames = [replace(frame, T_world_camera=None) for frame in self._frames]
        known = [i for i in range(len(self)) if self._dataset.has_ground_truth(i)]
        chosen = np.linspace(0, len(known) - 1, min(n_frames, len(known))).astype(int)
        self.truths = {known[i]: self._dataset.ground_truth(known[i]) for i in chosen}
        self._max_range = max_range

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: int) -> Frame:
        return self._frames[index]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._dataset, name)

    def instances(self, index: int) -> InstanceTruth | None:
        """Return the numbers of the true objects of a recorded frame; None = not told apart."""
        is_drawn = isinstance(self._dataset, KnowsDistances)
        if isinstance(self._dataset, KnowsInstances) and not is_drawn:
            return self._dataset.instance_truth(index)
        return None

    def counted(self, index: int) -> npt.NDArray[np.bool_]:
        """(H, W) bool: within the range that counts."""
        depth = self._frames[index].depth
        assert depth is not None
        return ~(depth > self._max_range)


class StraightDown:
    """Three boxes on a table straight below the camera, which shows their tops alone."""

    id = "straight-down"
    has_depth = True
    CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
    # Row and column of each box's corner in the first image, and metres that it is high.
    BOXES = ((120, 100, 0.10), (300, 260, 0.15), (450, 120, 0.20))

    def __len__(self) -> int:
        return 6

    def __getitem__(self, index: int) -> Frame:
        depth = np.random.default_rng(index).normal(1, 0.001, (480, 640)).astype(np.float32)
        for rows, columns, height in self._windows(index):
            depth[rows, columns] -= height
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = -0.02 * index, 0, 1.74
        rgb = np.zeros((480, 640, 3), np.uint8)
        return Frame(str(index), rgb, depth=depth, camera=self.CAMERA, T_world_camera=pose)

    def has_ground_truth(self, index: int) -> bool:
        return True

    def ground_truth(self, index: int) -> npt.NDArray[np.uint8]:
        """(H, W) uint8, codes of `Label`: the boxes and the table."""
        truth = np.full((480, 640), Label.NOT_SALIENT, np.uint8)
        for rows, columns, _ in self._windows(index):
            truth[rows, columns] = Label.SALIENT
        return truth

    def _windows(self, index: int) -> list[tuple[slice, slice, float]]:
        return [
            (slice(v, v + 90), slice(u + 10 * index, u + 10 * index + 110), height)
            for v, u, height in self.BOXES
        ]


@dataclass
class Tally:
    """Figures of a teacher, in points of a hundred.

    good: F of the salient pixels, or without any true ones the share of the rest that is not
    taken for salient. recognised: share of what is truly not salient that is labelled so.
    overlap: F of the objects told apart; None = truth does not.
    """

    good: float
    recognised: float
    overlap: float | None = None


def measure(recordings: Iterable[Kept], settings: Mapping[str, Any] | None = None) -> Tally:
    """Score the teacher of `default`, as it is now, on recordings together."""
    config = load_config(overrides=settings)
    scores = TeacherScores(n_worst=0)
    n_rest, n_recognised, n_wrong = 0, 0, 0
    for recording in recordings:
        teacher = make_teacher(config, recording)
        for index, truth in recording.truths.items():
            frame, counted = recording[index], recording.counted(index)
            found = teacher.segment(frame)
            scores.add(
                score_frame(frame, found, truth, recording.instances(index), counted=counted)
            )
            rest = (truth == Label.NOT_SALIENT) & counted
            n_rest += np.count_nonzero(rest)
            n_recognised += np.count_nonzero(found.labels[rest] == Label.NOT_SALIENT)
            n_wrong += np.count_nonzero(found.labels[rest] == Label.SALIENT)
    good, total = 1 - n_wrong / max(n_rest, 1), scores.total
    if total.n_object:
        both = np.nan_to_num([total.precision, total.recall])
        good = 2 * float(both.prod() / max(both.sum(), 1e-9))
    overlap = (scores.table()["instances"] or {}).get("overlap_f")
    of_objects = None if overlap is None else 100 * overlap
    figures = 100 * good, 100 * n_recognised / max(n_rest, 1), of_objects
    return Tally(*(None if one is None else round(float(one), 3) for one in figures))


def find_columns(data: Path, n_frames: int) -> dict[str, Callable[[], list[Kept]]]:
    """Return what opens the recordings of each column, those of the folder first."""

    def drawn(source: str, farthest: float = DRAWN_RANGE) -> list[Kept]:
        return [Kept(source.format(seed=seed), n_frames, farthest) for seed in SEEDS]

    def pieces(kinds: Iterable[str], seeds: Iterable[int], *, is_posed: bool = True) -> list[Kept]:
        views = [draw_views(kind, seed, "kinect") for kind in kinds for seed in seeds]
        return [Kept(one, n_frames, DRAWN_RANGE, is_posed=is_posed) for one in views]

    columns: dict[str, Callable[[], list[Kept]]] = {
        name: lambda folder=folder: [Kept(str(data / folder), n_frames)]  # type: ignore[misc]
        for name, folder in REAL.items()
    }
    columns |= {name: partial(drawn, source) for name, source in DRAWN.items()}
    columns |= {name: partial(pieces, kinds, [FURNITURE_SEED]) for name, kinds in FURNITURE.items()}
    columns["exact"] = partial(drawn, EXACT, np.inf)
    columns["long cupboards, no poses"] = partial(
        pieces, CUPBOARDS[:1], CUPBOARDS[1], is_posed=False
    )
    columns["straight down"] = lambda: [Kept(StraightDown(), n_frames)]
    return columns


def leave_out(rules: Iterable[Rule], recordings: dict[str, list[Kept]]) -> None:
    """Measure the teacher whole, then without each rule, and keep the figures of both."""
    kept = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    whole = {name: asdict(measure(some)) for name, some in recordings.items()}
    kept["whole"] = kept.get("whole", {}) | whole
    print("whole", whole, flush=True)
    for rule in rules:
        with rule.left_out() as settings:
            without = {name: asdict(measure(some, settings)) for name, some in recordings.items()}
        pairs = {name: [whole[name], without[name]] for name in recordings}
        kept[rule.key] = kept.get(rule.key, {}) | pairs
        print(rule.key, _row(rule.key, kept), flush=True)
        lines = [f"{json.dumps(key)}: {json.dumps(figures)}" for key, figures in kept.items()]
        RESULTS.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def _row(key: str, kept: dict[str, Any]) -> list[str]:
    """Return what leaving a rule out costs on each recording, in points; "" = not measured."""
    return [_cell(*kept[key][name]) if name in kept[key] else "" for name in kept["whole"]]


def _cell(whole: dict[str, Any], without: dict[str, Any]) -> str:
    costs = [whole[figure] - without[figure] for figure in ("good", "recognised")]
    if whole["overlap"] is not None:
        costs.append(whole["overlap"] - without["overlap"])
    if all(abs(cost) < LEAST for cost in costs):
        return "·"
    return " / ".join("0" if abs(cost) < LEAST else f"{cost:.1f}" for cost in costs)


def write_table() -> None:
    """Write the table of the document anew from the figures that are kept."""
    kept = json.loads(RESULTS.read_text())
    names = list(kept["whole"])
    lines = ["| left out | " + " | ".join(names) + " |", "|" + "---|" * (1 + len(names))]
    lines += [
        f"| {rule.key} | " + " | ".join(_row(rule.key, kept)) + " |"
        for rule in RULES
        if rule.key in kept
    ]
    whole = [f"{one['good']:.1f} / {one['recognised']:.1f}" for one in kept["whole"].values()]
    lines.append("| *with all rules* | " + " | ".join(whole) + " |")
    text = DOCUMENT.read_text()
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    DOCUMENT.write_text(before + BEGIN + "\n" + "\n".join(lines) + "\n" + END + after)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("data", nargs="?", type=Path, help="folder of the recordings")
    parser.add_argument("--rules", nargs="+", help="keys of the rules to leave out; all")
    parser.add_argument("--columns", nargs="+", help="of the table, to be measured; all")
    parser.add_argument("--frames", type=int, default=30, help="of each recording that count")
    parser.add_argument("--table", action="store_true", help="only write the table anew")
    arguments = parser.parse_args()
    if not arguments.table:
        chosen = [one for one in RULES if arguments.rules is None or one.key in arguments.rules]
        columns = find_columns(arguments.data, arguments.frames)
        names = arguments.columns or list(columns)
        leave_out(chosen, {name: columns[name]() for name in names})
    write_table()


if __name__ == "__main__":
    main()
