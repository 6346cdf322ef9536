"""The teachers of the presets `paper` and `default` against each other, and the table of it.

    python benchmarks/presets_table.py

writes the table of docs/method.md anew from benchmarks/results/presets.json, which `presets.py`
keeps. Rooms are drawn with a Kinect's sensor; there, nothing beyond 3.5 m counts.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from curiosight.config import Config
from curiosight.datasets import Dataset, KnowsDistances, KnowsInstances
from curiosight.evaluation import TeacherScores, score_frame
from curiosight.experiments.components import make_teacher
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "presets.json"
DOCUMENT = Path(__file__).parents[1] / "docs" / "method.md"
BEGIN, END = "<!-- presets: begin -->", "<!-- presets: end -->"
SEEDS = range(21, 26)
ROOMS = f"rooms {SEEDS[0]}–{SEEDS[-1]}"
KINECT_RANGE = 3.5
# Preset, and whether the teacher remembers.
TEACHERS = {
    "`paper`": ("paper", False),
    "`default`": ("default", False),
    "`default`, `--temporal`": ("default", True),
}
PIXELS = ("precision", "recall", "coverage")
INSTANCES = ("overlap_f", "boundary_f")
MAPS = {
    "paper": "`paper`",
    "+ teacher of default": "`paper`, with the teacher of `default`",
    "default, teacher of paper": "`default`, with the teacher of `paper`",
    "default": "`default`",
}


def score_teachers(osd_learn: Path, redkitchen: Path) -> dict[str, Any]:
    """Return the figures of each teacher on each recording, and in all rooms together."""
    sources: dict[str, list[str]] = {
        osd_learn.name: [str(osd_learn)],
        redkitchen.name: [str(redkitchen)],
        ROOMS: [f"room:{seed},sensor=kinect,views=20" for seed in SEEDS],
    }
    results: dict[str, Any] = {}
    for name, paths in sources.items():
        datasets = [open_source(path) for path in paths]
        for teacher, (preset, temporal) in TEACHERS.items():
            if temporal and datasets[0].poses[0] is None:
                continue
            table = _score(Config.of_preset(preset), datasets, temporal).table()
            cell = {figure: table["pixels"][figure] for figure in PIXELS}
            cell |= {figure: (table["instances"] or {}).get(figure) for figure in INSTANCES}
            results.setdefault(name, {})[teacher] = cell
            print(f"{name:14s} {teacher:24s} {cell}", flush=True)
    return results


def _score(config: Config, datasets: Iterable[Dataset], temporal: bool) -> TeacherScores:
    """Score a teacher on the frames with ground truth; one that remembers looks at all."""
    scores = TeacherScores(n_worst=0)
    for dataset in datasets:
        teacher = make_teacher(config, dataset, temporal=temporal)
        for index in range(len(dataset)):
            truth = dataset.ground_truth(index) if dataset.has_ground_truth(index) else None
            if truth is None and not temporal:
                continue
            frame = dataset[index]
            segmentation = teacher.segment(frame)
            if truth is None:
                continue
            instances, near = None, None
            if isinstance(dataset, KnowsInstances):
                instances = dataset.instance_truth(index)
            if isinstance(dataset, KnowsDistances):
                near = dataset.true_depth(index) <= KINECT_RANGE
            scores.add(score_frame(frame, segmentation, truth, instances, counted=near))
    return scores


def table_of(results: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    lines = [
        "| teacher | | precision | recall | coverage | Overlap F | Boundary F |",
        "|---|---|---|---|---|---|---|",
    ]
    for source, by_teacher in results["teacher"].items():
        for teacher, cell in by_teacher.items():
            figures = [_short(cell[name]) for name in (*PIXELS, *INSTANCES)]
            lines.append(f"| {teacher} | {source} | {' | '.join(figures)} |")
    lines += [
        "",
        "| map learned from its labels: ROC AUC / F1 | `osd_learn` | `redkitchen` |",
        "|---|---|---|",
    ]
    for variant, name in MAPS.items():
        parts = results["map"].get(variant, {})
        cells = [_area_and_f1(parts.get(part)) for part in ("osd_learn, all", "redkitchen, all")]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _short(value: float | None) -> str:
    return "–" if value is None else f"{value:.3f}".removeprefix("0")


def _area_and_f1(cell: dict[str, dict[str, float]] | None) -> str:
    if cell is None:
        return "–"
    return f"{_short(cell['roc_auc']['mean'])} / {_short(cell['f1']['mean'])}"


def write_table(results: dict[str, Any], document: Path = DOCUMENT) -> None:
    """Put the table between the two marks of a document."""
    text = document.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    table = f"{BEGIN}\n{table_of(results)}\n{END}"
    document.write_text(f"{before}{table}{after}", encoding="utf-8")


if __name__ == "__main__":
    write_table(json.loads(RESULTS.read_text(encoding="utf-8")))
