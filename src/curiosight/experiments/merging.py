"""Make one model of those of several robots, and write it as a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from curiosight.config import load_config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.exploring import CONFIG, SUMMARY, run_settings
from curiosight.experiments.output import OutputFolder
from curiosight.learner.archive import MODEL, find_model
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.merging import merge_all


def merge_runs(
    runs: Sequence[Path], out: OutputFolder, *, n_threads: int | None = None
) -> dict[str, Any]:
    """Write model.npz, config.toml and summary.json of two or more runs; return the summary.

    Which run comes first does not matter. Raises `DataError` for a run without a model, and for
    one whose model was made with other settings than the first.
    """
    paths = [find_model(run) for run in runs]
    learners = [SaliencyLearner.load(path) for path in paths]
    config = min((load_config(None, run_settings(run)) for run in runs), key=to_toml)
    try:
        merged = merge_all(learners, n_threads=n_threads or config.run.n_threads)
    except ValueError as error:
        remedy = "merge runs of the same settings"
        raise DataError(runs[-1], f"cannot be merged ({error})", remedy) from error
    out.write_text(CONFIG, to_toml(config))
    merged.save(out.file(MODEL))
    summary = {
        "runs": sorted(str(run) for run in runs),
        "samples": merged.n_samples,
        "samples_of_runs": sorted(learner.n_samples for learner in learners),
        "places": merged.experts.n_views(),
    }
    out.write_json(SUMMARY, summary)
    return summary
