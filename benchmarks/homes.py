"""What places, features and the choice between forests are worth in a home.

    python benchmarks/homes.py home:31,views=60 home:31,views=12,split=test
    python benchmarks/homes.py TRAIN TEST --only places

Every row learns off-line from TRAIN, whose labels are the same for all, and is scored on all of
TEST; figures are kept by a name, or that of TRAIN, in results/homes.json. A row changes one choice
of the preset `default`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from presets import RememberingViews, figures

from curiosight.config import load_config
from curiosight.datasets import Dataset
from curiosight.evaluation import MapScores
from curiosight.experiments.components import make_teacher
from curiosight.experiments.learning import OffLine
from curiosight.frame import Frame
from curiosight.learner.description import Saliency
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches
from curiosight.teacher import Teacher
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "homes.json"
Maps = Callable[[SaliencyLearner, Frame], Saliency]


def by_pose(learner: SaliencyLearner, frame: Frame) -> Saliency:
    return learner.saliency(frame.rgb, frame.T_world_camera)


def by_look(learner: SaliencyLearner, frame: Frame) -> Saliency:
    return learner.saliency(frame.rgb)


def by_all(learner: SaliencyLearner, frame: Frame) -> Saliency:
    """Let the common forest answer, whatever the place."""
    whole, learner.experts.places = learner.experts.places, None
    try:
        return learner.saliency(frame.rgb)
    finally:
        learner.experts.places = whole


# Of each row: what it changes, and how maps are made.
SETTINGS: dict[str, Mapping[str, Any]] = {
    "default": {},
    "one forest for everywhere": {"learner.max_places": 0},
    "at most 4 places": {"learner.max_places": 4},
    "without texture": {"learner.features": "surroundings+height"},
    "without height in the image": {"learner.features": "surroundings+texture"},
    "colours and contrast": {"learner.features": "colours+contrast"},
    "the paper's 39 colours": {"learner.features": "colours"},
    "SEEDS": {"learner.superpixels": "seeds", "learner.n_superpixels": 600},
    "samples as they come": {"learner.salient_share": 0.0},
    "leaves of 200": {"forest.min_split": 200},
}
GATING: dict[str, Maps] = {
    "the place by its look alone": by_look,
    "the common forest of the experts": by_all,
}


def score(learner: SaliencyLearner, test: Dataset, maps: Maps, max_range: float) -> dict[str, Any]:
    """Return figures of the maps of all frames with truth."""
    scores = MapScores(max_range=max_range, threshold=learner.threshold)
    for index in range(len(test)):
        truth = test.ground_truth(index) if test.has_ground_truth(index) else None
        if truth is not None:
            frame = test[index]
            scores.add(frame.id, maps(learner, frame), truth, depth=frame.depth)
    return figures(scores) | {"places": len(learner.experts.of_place)}


def learn(
    training: Dataset, teacher: Teaches, changes: Mapping[str, Any]
) -> tuple[SaliencyLearner, float]:
    """Return the off-line model with some settings, and how far depth teaches."""
    config = load_config(overrides=changes)
    off_line = OffLine(config, training, teacher=teacher)
    for _ in off_line:
        pass
    return off_line.fit(), config.max_range


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("train", help="a home, or a recording of one")
    parser.add_argument("test", help="other views of it, with truth")
    parser.add_argument("--only", help="rows whose name holds this")
    parser.add_argument("--name", help="what the figures are kept by; that of TRAIN unless given")
    arguments = parser.parse_args()
    training, test = open_source(arguments.train), open_source(arguments.test)
    kept = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    rows = kept.setdefault(arguments.name or Path(arguments.train).name, {})
    teacher = make_teacher(load_config(), training)
    assert isinstance(teacher, Teacher)
    said = RememberingViews(teacher)
    for name, changes in SETTINGS.items():
        if arguments.only and arguments.only not in name:
            continue
        learner, max_range = learn(training, said, changes)
        maps = {name: by_pose} | (GATING if not changes else {})
        for row, of_row in maps.items():
            rows[row] = score(learner, test, of_row, max_range)
            print(row, {key: round(value, 4) for key, value in rows[row].items()}, flush=True)
        RESULTS.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
