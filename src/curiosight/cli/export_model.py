"""curiosight export RUN --layout onnx: what a run has learned, for other programs."""

from __future__ import annotations

import json
from pathlib import Path

from curiosight.cli.talk import Talk
from curiosight.errors import DataError
from curiosight.experiments.exploring import load_run_model
from curiosight.experiments.output import default_path
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.onnx_export import export_onnx

ONNX = "onnx"
ENDING = ".onnx"


def export_model(talk: Talk, run: Path, out: Path | None, *, overwrite: bool) -> None:
    """Write the forests of a run as an ONNX file, and say what is in it."""
    path = out or default_path("export", ENDING)
    if path.suffix.lower() != ENDING:
        raise ValueError(f"out: expected a name that ends in {ENDING}, got {path.name!r}")
    if path.is_dir():
        raise DataError(path, "is a folder", "choose another --out")
    if path.exists() and not overwrite:
        raise DataError(path, "exists", "choose another --out, or add --overwrite")
    model = load_run_model(run)
    learner = SaliencyLearner.load(model)
    if not learner.is_trained:
        raise DataError(model, "has learned nothing", "give another run")
    path.parent.mkdir(parents=True, exist_ok=True)
    facts = export_onnx(learner, path)
    features, forests = json.loads(facts["features"]), json.loads(facts["forests"])
    rows = {"features": len(features), "forests": ", ".join(forests), "written to": path}
    content = {"features": features, "forests": forests, "threshold": float(facts["threshold"])}
    talk.results("export", rows, {**content, "out": str(path)})
    talk.note(f"not included: {facts['not_included']}")
