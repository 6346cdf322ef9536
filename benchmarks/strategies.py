"""Compare the strategies: overall error and travel over steps, mean and spread over seeds.

    python benchmarks/strategies.py RECORDING [--strategies chronological,random,iac]
        [--seeds 10] [--steps 200] [--preset default]

Tests on every tenth frame, three neighbours on each side left out of learning. Keeps
benchmarks/results/strategies-PRESET.json. `chronological` depends on the seed too: which pixels
of a frame are learned and which trees regrow are drawn.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import curiosight as cs
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.output import OutputFolder

RESULTS = Path(__file__).parent / "results"
SHOWN = (10, 20, 50, 100, 200)


def run(task: tuple[Path, str, str, int, int]) -> dict[str, list[float]]:
    """Explore once; return overall error and metres after every step."""
    recording, preset, strategy, seed, n_steps = task
    overrides = {
        "explorer.strategy": strategy,
        "explorer.n_steps": n_steps,
        "test.every": 10,
        "run.seed": seed,
        "run.n_threads": 1,
    }
    config = cs.load_config(preset, overrides=overrides)
    with tempfile.TemporaryDirectory() as folder:
        exploration = Exploration(
            config, cs.open_dataset(recording), OutputFolder(Path(folder), "explore", recording)
        )
        rows = [row for _, row in exploration]
        exploration.finish()
    return {
        "overall_error": [float(row.overall_error or np.nan) for row in rows],
        "metres": [row.metres for row in rows],
    }


def main() -> None:
    """Run all, print a table, keep every curve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--strategies", default="chronological,random,iac")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--preset", default="default")
    arguments = parser.parse_args()
    curves: dict[str, Any] = {}
    with ProcessPoolExecutor(2) as pool:
        for strategy in arguments.strategies.split(","):
            tasks = [
                (arguments.recording, arguments.preset, strategy, seed, arguments.steps)
                for seed in range(arguments.seeds)
            ]
            curves[strategy] = list(pool.map(run, tasks))
            errors = np.array([curve["overall_error"] for curve in curves[strategy]])
            cells = [
                f"{step}: {errors[:, step - 1].mean():.3f} ± {errors[:, step - 1].std():.3f}"
                for step in SHOWN
                if step <= arguments.steps
            ]
            metres = np.mean([curve["metres"][-1] for curve in curves[strategy]])
            print(f"{strategy:14s} {'  '.join(cells)}  travel {metres:.0f} m", flush=True)
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"strategies-{arguments.preset}.json"
    path.write_text(json.dumps({"frames": arguments.steps, "curves": curves}) + "\n")


if __name__ == "__main__":
    main()
