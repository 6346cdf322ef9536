"""Why the preset `default` is what it is: each of its choices, added one by one to `paper`.

    python benchmarks/presets.py OSD_LEARN REDKITCHEN [--seeds 3] [--only VARIANT …]

Trains off-line on the teacher's labels, tests on ground truth that was never learned from:
osd_learn in 5 random folds of frames; redkitchen in 5 blocks, with the first half of the
recording (where choices were made) and the second (where they are only reported) apart.
Keeps benchmarks/results/presets.json.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import curiosight as cs
from curiosight.config import Config
from curiosight.evaluation import MapScores
from curiosight.experiments.evaluating import CrossValidation
from curiosight.segmentation import Segmentation, TemporalTeacher

RESULTS = Path(__file__).parent / "results" / "presets.json"


def variants() -> dict[str, Config]:
    """Return the settings to compare, from `paper` to `default` and around it."""
    paper, default = Config.of_preset("paper"), Config.of_preset("default")
    superpixels = replace(paper, learner=replace(paper.learner, rows_per="superpixel"))
    soft = replace(superpixels, forest=replace(paper.forest, vote="soft"))
    plain = replace(default.learner, contrast=False, follow_edges=False, blind_share=0.0)
    lab = replace(soft, learner=plain)
    alone = replace(default, teacher=paper.teacher)
    deep = replace(alone, learner=plain)
    contrast = replace(alone, learner=replace(plain, contrast=True))
    edges = replace(alone, learner=replace(default.learner, blind_share=0.0))
    steps = {
        "paper": paper,
        "+ one row per superpixel": superpixels,
        "+ leaf frequencies": soft,
        "+ Lab": lab,
        "+ deep, varied trees": deep,
        "+ contrast": contrast,
        "+ maps follow edges": edges,
        "+ blind share": alone,
        "+ memory of views = default": default,
    }
    for name, changes in {
        "default, nodes of 20 split": {"min_split": 20},
        "default, nodes of 100 split": {"min_split": 100},
        "default, nodes of 400 split": {"min_split": 400},
        "default, 6 features a split": {"n_split_features": 6},
        "default, 20 features a split": {"n_split_features": 20},
        "default, all features a split": {"n_split_features": 0},
    }.items():
        steps[name] = replace(default, forest=replace(default.forest, **changes))
    steps["default, exactly per pixel"] = replace(
        default, learner=replace(default.learner, rows_per="pixel")
    )
    steps["default, RGB"] = replace(default, learner=replace(default.learner, colour_space="rgb"))
    return steps


class Halves(MapScores):
    """Score the first and the second half of a recording apart."""

    def __init__(self, ids: list[str]) -> None:
        super().__init__()
        self._first = set(ids[: len(ids) // 2])
        self.halves = (MapScores(), MapScores())

    def add(self, id: str, *maps: Any) -> None:
        """Add a frame to its half."""
        super().add(id, *maps)
        self.halves[id not in self._first].add(id, *maps)


class Remembering:
    """A teacher that segments each frame once: it is the same for all variants."""

    def __init__(self, teacher: cs.Teacher | TemporalTeacher) -> None:
        self.survey = teacher.survey
        self._teacher = teacher
        self._remembered: dict[str, Segmentation] = {}

    def segment(self, frame: cs.Frame) -> Segmentation:
        """Return what the teacher says, from memory where it was asked before."""
        if frame.id not in self._remembered:
            full = self._teacher.segment(frame)
            nothing = np.broadcast_to(np.uint16(0), full.labels.shape)
            self._remembered[frame.id] = Segmentation(full.labels, nothing, problem=full.problem)
        return self._remembered[frame.id]


def figures(scores: MapScores) -> dict[str, float | None]:
    """Return the figures of a table's cell."""
    table = scores.table()
    pooled = table["pooled"]["all"]
    return {
        "roc_auc": pooled["roc_auc"],
        "best_f1": pooled["best_f1"],
        "f1": pooled["f1"],
        "overall_error": table["overall_error"],
    }


def run(
    config: Config, dataset: cs.datasets.Dataset, teacher: Any, split: Any, seed: int
) -> dict[str, Any]:
    """Cross-validate once."""
    config = replace(config, run=replace(config.run, seed=seed))
    evaluation = CrossValidation(config, dataset, n_folds=5, split=split, teacher=teacher)
    if split == "frames":
        for _ in evaluation:
            pass
        return {"all": figures(evaluation.scores)}
    scores = evaluation.scores = Halves(list(dataset.ids))
    for _ in evaluation:
        pass
    tuned, reported = scores.halves
    return {"tuned on": figures(tuned), "reported": figures(reported)}


def main() -> None:
    """Compare and keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("osd_learn", type=Path)
    parser.add_argument("redkitchen", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", nargs="+", help="these variants; the others' results are kept")
    arguments = parser.parse_args()
    default = Config.of_preset("default")
    recordings = []
    for path, split in ((arguments.osd_learn, "frames"), (arguments.redkitchen, "blocks")):
        dataset = cs.open_dataset(path)
        teacher = cs.make_teacher(default, dataset)
        teachers = {False: Remembering(teacher), True: Remembering(TemporalTeacher(teacher))}
        recordings.append((path.name, dataset, teachers, split))
    chosen = variants()
    results: dict[str, Any] = {}
    if arguments.only:
        chosen = {name: chosen[name] for name in arguments.only}
        results = json.loads(RESULTS.read_text())
    for name, config in chosen.items():
        results[name] = {}
        for recording, dataset, teachers, split in recordings:
            teacher = teachers[config.teacher.temporal]
            runs = [run(config, dataset, teacher, split, seed) for seed in range(arguments.seeds)]
            for part in runs[0]:
                cells = {key: [float(one[part][key]) for one in runs] for key in runs[0][part]}
                results[name][f"{recording}, {part}"] = {
                    key: {"mean": float(np.mean(v)), "std": float(np.std(v))}
                    for key, v in cells.items()
                }
        line = "  ".join(
            f"{part}: AUC {cell['roc_auc']['mean']:.3f} F1 {cell['f1']['mean']:.3f} "
            f"err {cell['overall_error']['mean']:.3f}"
            for part, cell in results[name].items()
        )
        print(f"{name:32s} {line}", flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
