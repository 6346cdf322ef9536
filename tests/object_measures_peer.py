"""What PySODMetrics says of maps, stored in `golden/pysodmetrics.json`.

Its pins (NumPy < 2.3.5, another OpenCV than ours) forbid installing it beside this project's
dependencies. `python tests/object_measures_peer.py` writes the file where it is importable.
"""

from __future__ import annotations

import importlib
import json
import warnings
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from golden_maps import FREE, GOLDEN, golden_map

STORED = GOLDEN / "pysodmetrics.json"
METHODS = ("bms2013_sod", "gbvs", "vocus2_coffee")
N_RANDOM = 12

Levels = npt.NDArray[np.uint8]


def drawn_truth(shape: tuple[int, int]) -> Levels:
    """Return a disc and a thin bar in an image of any size, not in its last line or column."""
    height, width = shape
    v, u = np.mgrid[:height, :width]
    radius = 0.25 * min(shape)
    is_disc = (v - 0.55 * height) ** 2 + (u - 0.4 * width) ** 2 < radius**2
    is_bar = (abs(v - 0.2 * height) < 1.5) & (abs(u - 0.6 * width) < 0.2 * width)
    return np.where(is_disc | is_bar, 255, 0).astype(np.uint8)


def random_case(seed: int) -> tuple[Levels, Levels]:
    """Return a small map and a ragged truth; every third map has few levels."""
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(5, 60, 2))
    truth = np.where(rng.random(shape) < rng.uniform(0.1, 0.9), 255, 0).astype(np.uint8)
    if seed % 2:
        truth = cv2.medianBlur(truth, 5)
    truth[1:3, 1:3] = 255
    truth[-1, :] = truth[:, -1] = 0
    high = 4 if seed % 3 == 0 else 200
    return (20 + rng.integers(0, high, shape) * (200 // high)).astype(np.uint8), truth


def cases() -> dict[str, tuple[Levels, Levels]]:
    """Return 8-bit maps with their truth, by name."""
    made: dict[str, tuple[Levels, Levels]] = {}
    for image in FREE:
        for method in METHODS:
            saliency = golden_map(method, image)
            made[f"{method} {image}"] = saliency, drawn_truth(saliency.shape)
    return made | {f"random {seed}": random_case(seed) for seed in range(N_RANDOM)}


def peer_score(saliency: Levels, truth: Levels, *, is_stretched: bool = True) -> dict[str, Any]:
    """Return PySODMetrics' results under our names; curves begin at level 0."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = importlib.import_module("py_sod_metrics")
        names = ("MAE", "Smeasure", "WeightedFmeasure", "Fmeasure", "Emeasure")
        measures = [getattr(peer, name)() for name in names]
    pair = (saliency, truth) if is_stretched else (saliency / 255, truth == 255)
    results: dict[str, Any] = {}
    for measure in measures:
        measure.step(*pair, normalize=is_stretched)
        results |= measure.get_results()
    return {
        "mae": results["mae"],
        "s_measure": results["sm"],
        "weighted_f": results["wfm"],
        "f_curve": results["fm"]["curve"][::-1],
        "f_adaptive": results["fm"]["adp"],
        "e_curve": results["em"]["curve"][::-1],
        "e_adaptive": results["em"]["adp"],
    }


def summary(score: dict[str, Any]) -> dict[str, float]:
    """Return a score with each curve as its highest point and its mean."""
    numbers = {}
    for name, value in score.items():
        if name.endswith("_curve"):
            numbers[name.replace("curve", "max")] = float(np.max(value))
            numbers[name.replace("curve", "mean")] = float(np.mean(value))
        else:
            numbers[name] = float(value)
    return numbers


def _write() -> None:
    stored = {
        mode: {
            name: summary(peer_score(*case, is_stretched=mode == "stretched"))
            for name, case in cases().items()
        }
        for mode in ("stretched", "as_is")
    }
    STORED.write_text(json.dumps({"program": "pysodmetrics 1.6.2"} | stored, indent=1) + "\n")


if __name__ == "__main__":
    _write()
