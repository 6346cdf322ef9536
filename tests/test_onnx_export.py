"""The exported forest answers as ours does, and says what it wants to be asked."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import onnxruntime
import pytest

from command import refusal, succeed
from curiosight.learner.experts import Experts
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.onnx_export import NOT_INCLUDED, export_onnx
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
RNG = np.random.default_rng(0)


def taught(vote: str = "soft", n_places: int = 0) -> SaliencyLearner:
    """Return a learner whose forests have learned something that is no single split."""
    forest = Forest(n_features=43, n_trees=7, vote=vote, seed=1, max_depth=9)
    learner = SaliencyLearner(forest=forest, features="colours+texture", is_calibrated=True)
    forests = [forest] + [forest.another(max_samples=2000, n_regrown=2) for _ in range(n_places)]
    for one in forests:
        rows = RNG.integers(0, 256, (1500, 43), np.uint8)
        one.update(rows, rows[:, 3].astype(int) + rows[:, 7] > rows[:, 11].astype(int) + 90)
    learner.experts.of_place = tuple(forests[1:])
    return learner


def run(path: Path, **inputs: np.ndarray) -> list[np.ndarray]:
    session = onnxruntime.InferenceSession(str(path))
    return [output[:, 0] for output in session.run(["votes", "saliency"], inputs)]


@pytest.mark.parametrize("vote", ["hard", "soft"])
def test_scores_of_rows_are_the_same(vote: str, tmp_path: Path) -> None:
    learner = taught(vote)
    for _ in range(30):
        learner.calibration.add(
            RNG.random(50, np.float32), RNG.integers(0, 9, 50), RNG.integers(0, 40, 50)
        )
    assert learner.calibration.threshold != 0.5
    export_onnx(learner, tmp_path / "model.onnx")
    rows = RNG.integers(0, 256, (900, learner.describer.n_features), np.uint8)
    votes, saliency = run(tmp_path / "model.onnx", rows=rows.astype(np.float32))
    expected = learner.experts.vote(rows)
    assert np.ptp(expected) > 0.5
    np.testing.assert_allclose(votes, expected, atol=1e-6)
    np.testing.assert_allclose(saliency, learner.scale(expected), atol=1e-6)


def test_places_count_as_much_as_is_said(tmp_path: Path) -> None:
    learner = taught(n_places=2)
    facts = export_onnx(learner, tmp_path / "model.onnx")
    assert json.loads(facts["forests"]) == ["everywhere", "place 0", "place 1"]
    rows = RNG.integers(0, 256, (200, learner.describer.n_features), np.uint8)
    weights = np.array([0.2, 0.0, 0.8], np.float32)
    votes, _ = run(tmp_path / "model.onnx", rows=rows.astype(np.float32), weights=weights)
    forests = learner.experts.forests().values()
    expected = sum(
        weight * forest.predict(rows) for weight, forest in zip(weights, forests, strict=True)
    )
    np.testing.assert_allclose(votes, expected, atol=1e-6)


def test_file_describes_its_features(tmp_path: Path) -> None:
    learner = taught()
    facts = export_onnx(learner, tmp_path / "model.onnx")
    session = onnxruntime.InferenceSession(str(tmp_path / "model.onnx"))
    told = session.get_modelmeta().custom_metadata_map
    assert told == facts
    assert told["not_included"] == NOT_INCLUDED
    features = json.loads(told["features"])
    assert [one["index"] for one in features] == list(range(43))
    names = [name for one in learner.describer.sets for name in one.columns]
    assert [one["name"] for one in features] == names
    assert features[-1]["set"] == "texture"
    assert "deviation times 2" in features[-1]["unit"]
    assert session.get_inputs()[0].shape == ["n", 43]


def test_nothing_learned_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="learner: expected one that has learned something"):
        export_onnx(SaliencyLearner(), tmp_path / "model.onnx")
    assert not (tmp_path / "model.onnx").exists()


def test_command(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 6)
    succeed(capsys, "learn", tmp_path / "room", "--out", tmp_path / "run")
    out = tmp_path / "model.onnx"
    options = ("--layout", "onnx", "--out", out)
    said = json.loads(succeed(capsys, "export", tmp_path / "run", *options, "--json").out)
    learner = SaliencyLearner.load(tmp_path / "run")
    assert len(said["features"]) == learner.describer.n_features
    rows = RNG.integers(0, 256, (50, learner.describer.n_features), np.uint8)
    session = onnxruntime.InferenceSession(str(out))
    inputs = {"rows": rows.astype(np.float32)}
    if len(said["forests"]) > 1:
        inputs["weights"] = np.eye(len(said["forests"]), dtype=np.float32)[0]
    (votes,) = session.run(["votes"], inputs)
    np.testing.assert_allclose(votes[:, 0], learner.forest.predict(rows), atol=1e-6)
    assert "exists; choose another --out" in refusal(capsys, "export", tmp_path / "run", *options)
    succeed(capsys, "export", tmp_path / "run", *options, "--overwrite")
    for wrong, line in (
        (("--every", 2, *options), "layout: onnx exports a run"),
        (("--layout", "onnx", "--out", tmp_path / "a.bin"), "out: expected a name that ends in"),
    ):
        assert line in refusal(capsys, "export", tmp_path / "run", *wrong)


def test_experts_without_places_have_one_forest() -> None:
    assert list(Experts(Forest(n_features=3)).forests()) == [-1]
