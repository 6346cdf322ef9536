"""What a model merged of two robots' knows of each room, beside theirs.

    python benchmarks/merging.py HOME [--shared 2]

HOME is a recording that `curiosight render home:31` wrote. One robot learned off-line in the first
half of the rooms, the other in the second half; in `--shared` rooms of the middle both did. Every
fifth frame is kept for testing. Figures of each room are kept by the recording's name in
results/merging.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from presets import figures

from curiosight.config import load_config
from curiosight.datasets import Dataset, known_places
from curiosight.evaluation import MapScores
from curiosight.experiments.learning import OffLine
from curiosight.frame import Frame
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.merging import merge_learners
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "merging.json"
EVERY = 5


class Part:
    """Some frames of a recording, as a recording."""

    name, has_depth, remarks = "part", True, ()

    def __init__(self, whole: Dataset, indices: Sequence[int]) -> None:
        self._whole, self._indices = whole, list(indices)
        self.ids = tuple(whole.ids[i] for i in indices)
        self.poses = tuple(whole.poses[i] for i in indices)
        self.camera = whole.camera

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, index: int) -> Frame:
        return self._whole[self._indices[index]]

    def has_ground_truth(self, index: int) -> bool:
        return self._whole.has_ground_truth(self._indices[index])

    def ground_truth(self, index: int) -> Any:
        return self._whole.ground_truth(self._indices[index])


def learned(dataset: Dataset) -> SaliencyLearner:
    """Return the off-line model."""
    off_line = OffLine(load_config(), dataset)
    for _ in off_line:
        pass
    return off_line.fit()


def score(learner: SaliencyLearner, test: Dataset) -> dict[str, float]:
    """Return figures of a model's maps, told from where each was taken."""
    scores = MapScores(threshold=learner.threshold)
    for index in range(len(test)):
        truth, frame = test.ground_truth(index), test[index]
        if truth is not None:
            saliency = learner.saliency(frame.rgb, frame.T_world_camera)
            scores.add(frame.id, saliency, truth, depth=frame.depth)
    return {name: round(value, 4) for name, value in figures(scores).items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("home", type=Path, help="a recording of a drawn home, with places.txt")
    parser.add_argument("--shared", type=int, default=2, help="rooms that both were in")
    arguments = parser.parse_args()
    whole = open_source(arguments.home)
    rooms = known_places(whole)
    assert rooms is not None
    n_rooms = max(rooms) + 1
    first, end = (n_rooms - arguments.shared) // 2, (n_rooms + arguments.shared) // 2
    training = [i for i in range(len(whole)) if i % EVERY]
    parts = {
        "first robot": Part(whole, [i for i in training if rooms[i] < end]),
        "second robot": Part(whole, [i for i in training if rooms[i] >= first]),
    }
    learners = {name: learned(part) for name, part in parts.items()}
    learners["merged"] = merge_learners(*learners.values())
    print({name: one.experts.n_views() for name, one in learners.items()}, flush=True)
    table: dict[str, dict[str, dict[str, float]]] = {}
    for room in range(n_rooms):
        test = Part(whole, [i for i in range(0, len(whole), EVERY) if rooms[i] == room])
        table[str(room)] = {name: score(one, test) for name, one in learners.items()}
        print(room, json.dumps(table[str(room)]), flush=True)
    kept = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    kept[arguments.home.name] = table
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
