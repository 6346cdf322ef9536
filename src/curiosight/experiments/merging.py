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
from curiosight.learner.merging import check_mergeable, fingerprint, merge_all


def merge_runs(
    runs: Sequence[Path], out: OutputFolder, *, n_threads: int | None = None
) -> dict[str, Any]:
    """Write model.npz, config.toml and summary.json of two or more runs; return the summary.

    Which run comes first does not matter. Raises `DataError` for a run without a model, for one
    that learned nothing or is given twice, and for one whose model was made with other settings
    than the first.
    """
    learners = _load_each(runs)
    config = min((load_config(None, run_settings(run)) for run in runs), key=to_toml)
    for run, learner in zip(runs[1:], learners[1:], strict=True):
        try:
            check_mergeable(learners[0], learner)
        except ValueError as error:
            remedy = "merge runs of the same settings"
            raise DataError(run, f"cannot be merged ({error})", remedy) from error
    merged = merge_all(learners, n_threads=n_threads or config.run.n_threads)
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


def _load_each(runs: Sequence[Path]) -> list[SaliencyLearner]:
    """Return the model of each run; what a model knows may count once only."""
    learners, run_of = [], dict[str, Path]()
    for run in runs:
        learner = SaliencyLearner.load(find_model(run))
        if not learner.is_trained:
            raise DataError(run, "has learned nothing", "leave it out")
        if (same := run_of.get(known := fingerprint(learner))) is not None:
            raise DataError(run, f"holds the same model as {same}", "give each once")
        run_of[known] = run
        learners.append(learner)
    return learners
