"""Time every stage on one thread, beside scikit-learn's forest in the same run.

    python benchmarks/stages.py RECORDING [--frames 40]

RECORDING: with depth, such as 7-Scenes' redkitchen. Prints a table, keeps
benchmarks/results/stages.json: median and 90th percentile, milliseconds.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from sklearn.ensemble import RandomForestClassifier

import curiosight as cs
from curiosight.experiments.timing import Timing, processor

RESULTS = Path(__file__).parent / "results" / "stages.json"


def timed(work: Callable[[Any], Any], inputs: list[Any]) -> dict[str, float]:
    """Return median and 90th percentile of the work on each input, after one warm-up."""
    work(inputs[0])
    spent = []
    for item in inputs:
        start = time.perf_counter()
        work(item)
        spent.append(1000 * (time.perf_counter() - start))
    return {"median_ms": float(np.median(spent)), "p90_ms": float(np.percentile(spent, 90))}


def time_preset(
    preset: str, dataset: cs.datasets.Dataset, frames: list[cs.Frame]
) -> dict[str, dict[str, float]]:
    """Time the learner of a preset with a full buffer."""
    config = cs.load_config(preset, overrides={"run.n_threads": 1})
    alone = ("segment", "describe", "predict", "learn")
    timing = Timing(config, dataset, n_frames=len(frames), stages=alone)
    for _ in timing:
        pass
    stages = timing.figures()["stages"]
    learner = timing.learner
    learner.teacher = timing.teacher
    stages["RGB to map"] = timed(lambda frame: learner.saliency(frame.rgb), frames)
    stages["whole step"] = timed(learner.observe, frames)
    described = [learner.describe(frame.rgb) for frame in frames[:5]]
    return stages | time_scikit_learn(config.forest, learner.forest.rows, learner, described)


def time_scikit_learn(
    settings: Any, rows: Any, learner: cs.SaliencyLearner, described: list[Any]
) -> dict[str, dict[str, float]]:
    """Time the same prediction, and four trees on as many samples, with scikit-learn's trees."""
    rng = np.random.default_rng(0)
    share = settings.share
    if settings.max_rows:
        share = min(share, settings.max_rows / len(np.unique(rows, axis=0)))
    drawn = rng.choice(len(rows), int(share * len(rows)), replace=False)
    options: dict[str, Any] = {
        "max_depth": settings.max_depth,
        "min_samples_split": settings.min_split,
        "max_features": settings.n_split_features or None,
        "class_weight": "balanced",
        "bootstrap": False,
        "random_state": 0,
    }
    chosen, labels = rows[drawn], learner.forest.is_salient[drawn]
    forest = RandomForestClassifier(settings.n_trees, **options).fit(chosen, labels)
    four = RandomForestClassifier(4, **options)
    return {
        "4 trees": timed(lambda _: learner.forest.regrow(range(4)), [0, 1, 2]),
        "scikit-learn: predict": timed(lambda d: forest.predict_proba(d.rows), described),
        "scikit-learn: 4 trees": timed(lambda _: four.fit(chosen, labels), [0, 1, 2]),
    }


def main() -> None:
    """Time both presets and keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--frames", type=int, default=40)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    dataset = cs.open_dataset(arguments.recording)
    indices = np.linspace(0, len(dataset) - 1, arguments.frames).astype(int)
    frames = [dataset[int(index)] for index in indices]
    figures: dict[str, Any] = {
        "recording": dataset.name,
        "frames": len(frames),
        "threads": 1,
        "image": list(frames[0].rgb.shape),
        "processor": processor(),
        "python": platform.python_version(),
        "decode": timed(lambda index: dataset[int(index)], list(indices)),
    }
    for preset in ("default", "paper"):
        figures[preset] = time_preset(preset, dataset, frames)
        print(preset)
        for stage, spent in figures[preset].items():
            print(f"  {stage:24s} {spent['median_ms']:8.1f} ms, p90 {spent['p90_ms']:.1f}")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
