"""Time four trees of our forest beside scikit-learn's and scikit-learn-intelex's, on the same rows.

    python benchmarks/forest_peers.py RECORDING [--intelex PYTHON] [--rounds 5]

RECORDING: with depth, such as 7-Scenes' redkitchen; it fills the buffer with 100 000 samples.
PYTHON: of an environment with scikit-learn-intelex; it changes scikit-learn as a whole, so it is
better kept in one of its own. Two forests: as version 0.1 had it (70 % of the samples, nodes of
200), and `default`, where the peers are given the samples of as many rows as our trees draw. All
use one thread, 12 features a split, no bootstrap and classes that weigh the same. Keeps
benchmarks/results/forest_peers.json: median milliseconds of processor time.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import curiosight as cs
from curiosight.experiments.timing import Timing, processor
from curiosight.learner.forest import Forest

RESULTS = Path(__file__).parent / "results" / "forest_peers.json"
N_TREES = 4
# What a peer runs on the rows of a file: without our own package, which may not be there.
PEER = """
import sys, time
import numpy as np
path, is_intelex, min_split, n_trees = sys.argv[1], *map(int, sys.argv[2:])
if is_intelex:
    from sklearnex import patch_sklearn
    patch_sklearn(verbose=False)
from sklearn.ensemble import RandomForestClassifier
arrays = np.load(path)
rows, labels = arrays["rows"].astype(np.float32), arrays["is_salient"]
weights = np.where(labels, 0.5 / labels.mean(), 0.5 / (1 - labels.mean()))
forest = RandomForestClassifier(
    n_trees, max_depth=24, min_samples_split=min_split, max_features=12, bootstrap=False,
    random_state=0, n_jobs=1,
)
spent = []
for _ in range(4):
    start = time.process_time()
    forest.fit(rows, labels, sample_weight=weights)
    spent.append(1000 * (time.process_time() - start))
print(np.median(spent[1:]))
"""


def timed(work: Callable[[], Any], n_rounds: int) -> float:
    """Return the median processor time in milliseconds, after one warm-up."""
    work()
    spent = []
    for _ in range(n_rounds):
        start = time.process_time()
        work()
        spent.append(1000 * (time.process_time() - start))
    return float(np.median(spent))


def time_peer(python: str, forest: Forest, chosen: Any, *, is_intelex: bool) -> float:
    """Let another Python grow the trees on the chosen samples of a forest's buffer."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.npz"
        np.savez(path, rows=forest.rows[chosen], is_salient=forest.is_salient[chosen])
        arguments = [str(path), str(int(is_intelex)), str(forest.min_split), str(N_TREES)]
        environment = {"OMP_NUM_THREADS": "1", "PATH": ""}
        done = subprocess.run(
            [python, "-c", PEER, *arguments],
            env=environment,
            check=True,
            capture_output=True,
            text=True,
        )
    return float(done.stdout)


def drawn_samples(forest: Forest, rng: np.random.Generator) -> Any:
    """Return samples as one tree draws them: a share of all, or of the rows with all of theirs."""
    if forest.max_rows is None:
        return rng.choice(forest.n_samples, round(forest.share * forest.n_samples), replace=False)
    _, row_of_sample = np.unique(forest.rows, axis=0, return_inverse=True)
    n_rows = row_of_sample.max() + 1
    is_drawn = rng.random(n_rows) < min(forest.share, forest.max_rows / n_rows)
    return np.flatnonzero(is_drawn[row_of_sample])


def main() -> None:
    """Fill a buffer, time all on it, print a table and keep it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--intelex", metavar="PYTHON")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    config = cs.load_config("default")
    timing = Timing(config, cs.open_dataset(arguments.recording), n_frames=1, stages=("learn",))
    for _ in timing:
        pass
    default = timing.learner.forest
    usual = {**default.settings(), "share": 0.7, "n_regrown": N_TREES, "min_split": 200}
    first = Forest(**{key: usual[key] for key in usual if key not in ("max_rows", "n_levels")})
    first.fit(default.rows, default.is_salient)
    figures: dict[str, Any] = {"processor": processor(), "threads": 1, "trees": N_TREES}
    for name, forest in (("as version 0.1", first), ("default", default)):
        chosen = drawn_samples(forest, np.random.default_rng(0))
        cell = {"samples": len(chosen), "ours": 0.0, "scikit-learn": 0.0}
        cell["ours"] = timed(lambda forest=forest: forest.regrow(range(N_TREES)), arguments.rounds)
        cell["scikit-learn"] = time_peer(sys.executable, forest, chosen, is_intelex=False)
        if arguments.intelex:
            cell["intelex"] = time_peer(arguments.intelex, forest, chosen, is_intelex=True)
        figures[name] = cell
        print(name, {key: round(value, 1) for key, value in cell.items()}, flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
