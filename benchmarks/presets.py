"""Why the preset `default` is what it is: each of its choices, added one by one to `paper`.

    python benchmarks/presets.py OSD_LEARN REDKITCHEN [--seeds 3] [--only VARIANT …]
    python benchmarks/presets.py OSD_LEARN REDKITCHEN --seeds 1 --only paper default …

Scores the teachers of both presets on both recordings and in drawn rooms. Then learns off-line
from their labels, and tests on ground truth that was never learned from: osd_learn in 5 random
folds of frames; redkitchen in 5 blocks, with the first half of the recording (where choices were
made) and the second (where they are only reported) apart. Keeps benchmarks/results/presets.json,
and writes the table `paper` against `default` of docs/method.md anew.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from presets_table import score_teachers, write_table

import curiosight as cs
from curiosight.config import Config, TeacherConfig
from curiosight.evaluation import MapScores, SplitKind
from curiosight.experiments.components import make_teacher
from curiosight.experiments.evaluating import CrossValidation
from curiosight.learner.observation import Teaches
from curiosight.teacher import Segmentation, Teacher, TemporalTeacher

RESULTS = Path(__file__).parent / "results" / "presets.json"


def variants() -> dict[str, Config]:
    """Return the settings to compare, from `paper` to `default` and around it."""
    paper, default = Config.of_preset("paper"), Config.of_preset("default")
    no_memory = replace(default.teacher, temporal=False)
    taught = replace(paper, teacher=no_memory, segmentation=default.segmentation)
    superpixels = replace(taught, learner=replace(paper.learner, rows_per="superpixel"))
    soft = replace(superpixels, forest=replace(paper.forest, vote="soft"))
    bare = replace(default.learner, follow_edges=False, blind_share=0.0)
    plain = replace(bare, features="colours", superpixels="seeds", n_superpixels=600)
    lab = replace(soft, learner=plain)
    alone = replace(default, teacher=no_memory)
    deep = replace(alone, learner=plain)
    contrast = replace(alone, learner=replace(plain, contrast=True))
    cells = replace(alone, learner=bare)
    edges = replace(alone, learner=replace(default.learner, blind_share=0.0))
    steps = {
        "paper": paper,
        "+ teacher of default": taught,
        "+ one row per superpixel": superpixels,
        "+ leaf frequencies": soft,
        "+ Lab": lab,
        "+ deep, varied trees": deep,
        "+ contrast": contrast,
        "+ cells, surroundings, texture, height": cells,
        "+ maps follow edges": edges,
        "+ blind share": alone,
        "default": default,
        "default, teacher of paper": replace(default, teacher=paper.teacher),
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
    """A teacher that segments each frame once: it is the same for many variants."""

    def __init__(self, teacher: Teaches) -> None:
        self._teacher = teacher
        self._remembered: dict[str, Segmentation] = {}

    def segment(self, frame: cs.Frame) -> Segmentation:
        """Return what the teacher says, from memory where it was asked before."""
        if frame.id not in self._remembered:
            self._remembered[frame.id] = without_things(self._teacher.segment(frame))
        return self._remembered[frame.id]


class RememberingViews(TemporalTeacher):
    """The same of one with a memory: each frame once as it looks, once more in hindsight."""

    def __init__(self, teacher: Teacher) -> None:
        super().__init__(teacher)
        self._remembered: dict[tuple[str, bool], Segmentation] = {}

    def segment(self, frame: cs.Frame) -> Segmentation:
        """Return what the teacher says; a frame that was seen before does not vote again."""
        key = frame.id, self.is_remembering
        if key not in self._remembered:
            self._remembered[key] = without_things(super().segment(frame))
        return self._remembered[key]


def without_things(full: Segmentation) -> Segmentation:
    """Return what learning needs of a segmentation: labels, and which way is up."""
    nothing = np.broadcast_to(np.uint16(0), full.labels.shape)
    flat = np.empty((0, 0), np.float32)
    lowest = tuple(
        replace(support, heights=flat, extent=None, core=None, skirt=None)
        for support in full.supports[:1]
    )
    return Segmentation(
        full.labels, nothing, supports=lowest, problem=full.problem, n_turns=full.n_turns
    )


class Recording:
    """A recording, how it is split, and what each teacher says of it."""

    def __init__(self, path: Path, split: SplitKind) -> None:
        self.name, self.split, self.dataset = path.name, split, cs.open_dataset(path)
        self._teachers: dict[TeacherConfig, Teaches] = {}

    def teacher(self, config: Config) -> Teaches:
        """Return the teacher that settings ask for; with memory it begins without any."""
        if config.teacher not in self._teachers:
            teacher = make_teacher(config, self.dataset)
            if config.teacher.temporal and isinstance(teacher, Teacher):
                self._teachers[config.teacher] = RememberingViews(teacher)
            else:
                self._teachers[config.teacher] = Remembering(teacher)
        return self._teachers[config.teacher]


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


def run(config: Config, recording: Recording, seed: int) -> dict[str, Any]:
    """Cross-validate once."""
    config = replace(config, run=replace(config.run, seed=seed))
    evaluation = CrossValidation(
        config,
        recording.dataset,
        n_folds=5,
        split=recording.split,
        teacher=recording.teacher(config),
    )
    halves = evaluation.scores = Halves(list(recording.dataset.ids))
    for _ in evaluation:
        pass
    if recording.split == "frames":
        return {"all": figures(halves)}
    tuned, reported = halves.halves
    return {"all": figures(halves), "tuned on": figures(tuned), "reported": figures(reported)}


def mean_of(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return mean and standard deviation of each figure of each part over some runs."""
    means: dict[str, Any] = {}
    for part in runs[0]:
        cells = {key: [float(one[part][key]) for one in runs] for key in runs[0][part]}
        means[part] = {
            key: {"mean": float(np.mean(values)), "std": float(np.std(values))}
            for key, values in cells.items()
        }
    return means


def main() -> None:
    """Compare and keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("osd_learn", type=Path)
    parser.add_argument("redkitchen", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", nargs="*", help="these variants; the others' results are kept")
    arguments = parser.parse_args()
    chosen, results = variants(), json.loads(RESULTS.read_text())
    if arguments.only is not None:
        chosen = {name: chosen[name] for name in arguments.only}
    results["teacher"] = score_teachers(arguments.osd_learn, arguments.redkitchen)
    recordings = (
        Recording(arguments.osd_learn, "frames"),
        Recording(arguments.redkitchen, "blocks"),
    )
    for name, config in chosen.items():
        results["map"][name] = {}
        for recording in recordings:
            runs = [run(config, recording, seed) for seed in range(arguments.seeds)]
            for part, cell in mean_of(runs).items():
                results["map"][name][f"{recording.name}, {part}"] = cell
                print(
                    f"{name:32s} {recording.name}, {part}: AUC {cell['roc_auc']['mean']:.3f} "
                    f"F1 {cell['f1']['mean']:.3f} err {cell['overall_error']['mean']:.3f}",
                    flush=True,
                )
    RESULTS.write_text(json.dumps(results, indent=1) + "\n")
    write_table(results)


if __name__ == "__main__":
    main()
