"""Ask the exported forest and ours the same: largest difference, and milliseconds of each.

A superpixel is one row, so 520 rows are an image of few superpixels; 76 800 are a whole image of
320x240 of which each pixel has a row of its own, as the preset `paper` has it. Rows are drawn from
the run's samples, one thread each, in turns; processor time.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnxruntime

from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.onnx_export import export_onnx

SIZES = {"520 rows": 520, "76 800 rows": 320 * 240}


def milliseconds(ask: Callable[[], object]) -> float:
    start = time.process_time()
    ask()
    return 1000 * (time.process_time() - start)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, help="folder of a run, or its model.npz")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--out", type=Path, help="JSON to write")
    given = parser.parse_args()
    learner = SaliencyLearner.load(given.run)
    forest, rng = learner.forest, np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        facts = export_onnx(learner, Path(folder) / "model.onnx")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        session = onnxruntime.InferenceSession(str(Path(folder) / "model.onnx"), options)
    n_forests = len(json.loads(facts["forests"]))
    first = {"weights": np.eye(n_forests, dtype=np.float32)[0]} if n_forests > 1 else {}
    found: dict[str, dict[str, float]] = {}
    for name, size in SIZES.items():
        rows = forest.rows[rng.integers(forest.n_samples, size=size)]
        inputs = {"rows": rows.astype(np.float32), **first}
        theirs, ours = session.run(["votes"], inputs)[0][:, 0], forest.predict(rows)
        times = np.array(
            [
                (
                    milliseconds(lambda rows=rows: forest.predict(rows)),
                    milliseconds(lambda inputs=inputs: session.run(["votes"], inputs)),
                )
                for _ in range(given.rounds)
            ]
        )
        medians = np.median(times, axis=0)
        found[name] = {
            "ours_ms": round(float(medians[0]), 2),
            "onnxruntime_ms": round(float(medians[1]), 2),
            "largest_difference": float(np.abs(theirs - ours).max()),
        }
        print(name, found[name])
    if given.out is not None:
        facts_of_run = {"onnxruntime": onnxruntime.__version__, "trees": forest.n_trees, **found}
        given.out.write_text(json.dumps(facts_of_run, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
