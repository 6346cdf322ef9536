"""curiosight evaluate --baselines: other methods beside the learned map, in one report."""

from __future__ import annotations

import html
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from command import files, refusal, succeed
from curiosight.cli.evaluate_report import failures, method_results
from curiosight.evaluation.baselines import Saliency
from curiosight.experiments.comparing import Comparison, Judged
from curiosight.frame import Frame, Rgb
from recordings import write_folder
from small_networks import write_network

Capsys = pytest.CaptureFixture[str]
NAMES = "mb,spectral-residual,depth"
METHODS = ["ours (default)", "mb", "spectral-residual", "depth"]


@pytest.fixture(scope="module")
def compared(
    model: Path, room: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path]:
    """Two evaluations of the same."""
    from curiosight.cli.app import run

    folders = [tmp_path_factory.mktemp("compared") / name for name in ("one", "two")]
    for folder in folders:
        options = ["--baselines", NAMES, "--quiet", "--out", str(folder)]
        assert run(["evaluate", str(model), str(room), *options]) == 0
    return folders[0], folders[1]


def test_everything_a_reviewer_wants_is_written(compared: tuple[Path, Path]) -> None:
    figures = {
        f"figures/{name}.{ending}"
        for name in ("roc", "precision_recall", "maps")
        for ending in ("png", "svg")
    }
    texts = {"metrics.json", "times.json", "table.md", "table.tex", "report.html", "config.toml"}
    assert files(compared[0]) == figures | texts | {"roc.png", "reliability.png"}


def test_metrics_of_every_method(compared: tuple[Path, Path]) -> None:
    metrics = json.loads((compared[0] / "metrics.json").read_text())
    assert list(metrics["methods"]) == METHODS
    ours, depth = metrics["methods"]["ours (default)"], metrics["methods"]["depth"]
    assert ours["pooled"] == metrics["pooled"]
    assert ours["n_frames"] == depth["n_frames"] == metrics["n_frames"]
    low, high = ours["intervals"]["roc_auc"]
    assert low <= ours["pooled"]["all"]["roc_auc"] <= high
    assert depth["pooled"]["all"]["roc_auc"] > 0.9
    assert 0 < depth["objects"]["s_measure"] <= 1
    times = json.loads((compared[0] / "times.json").read_text())
    assert set(times) == set(METHODS) - {"depth"}


def test_tables_and_report_name_every_method(compared: tuple[Path, Path]) -> None:
    folder = compared[0]
    page, table = (folder / "report.html").read_text(), (folder / "table.md").read_text()
    for name in METHODS:
        assert name in page
        assert name in table
    assert "--baselines" in page
    assert "never learned" not in page
    assert "8 of 8 test frames were learned from: the scores are too good." in page


def test_same_seed_gives_the_same_bytes_but_for_times(compared: tuple[Path, Path]) -> None:
    one, two = compared
    for name in files(one) - {"times.json", "report.html"}:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name
    pages = [
        re.sub(r'<td[^>]*class="measured".*?</td>', "", path.read_text())
        for path in (one / "report.html", two / "report.html")
    ]
    assert pages[0] == pages[1]


def test_report_tells_the_command_in_its_own_folder(
    compared: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: Capsys
) -> None:
    page = html.unescape((compared[0] / "report.html").read_text())
    found = re.search(r"curiosight evaluate [^<]*--baselines [a-z,-]+", page)
    assert found is not None
    monkeypatch.chdir(compared[0])
    succeed(capsys, *shlex.split(found[0])[1:], "--out", tmp_path / "again")
    metrics = (compared[0] / "metrics.json").read_bytes()
    assert (tmp_path / "again/metrics.json").read_bytes() == metrics


def test_depth_is_not_compared_with_itself(model: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 3, with_ground_truth=False)
    options = ("--baselines", "mb,depth", "--out", tmp_path / "out")
    shown = succeed(capsys, "evaluate", model, tmp_path / "room", *options).out
    assert "ROC AUC of mb" in shown
    assert "ROC AUC of depth" not in shown
    assert "against what depth says" in (tmp_path / "out/report.html").read_text()


def test_methods_that_fail_on_some_frames_say_on_how_many() -> None:
    comparison = Comparison("ours", {"picky": picky}, max_range=4.0, threshold=0.5, seed=0)
    for id, grey in (("a", 10), ("b", 200)):
        rgb = np.full((48, 64, 3), grey, np.uint8)
        truth = np.zeros((48, 64), np.uint8)
        truth[:20] = 255
        comparison.add(
            Judged(Frame(id, rgb), truth, None, None), lambda rgb: np.eye(48, 64, dtype=np.float32)
        )
    names = [one.name for one in method_results(comparison, comparison.metrics(), {})]
    assert names == ["ours", "picky (1 of 2 frames)"]
    assert list(failures(comparison)) == ["picky: no map of 1 frame: rgb: too dark"]


def picky(rgb: Rgb) -> Saliency:
    """Map bright images alone."""
    if rgb.mean() < 100:
        raise ValueError("rgb: too dark")
    return np.zeros(rgb.shape[:2], np.float32)


def test_network_of_ones_own_is_compared_by_its_name(
    model: Path, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    pytest.importorskip("onnxruntime")
    write_network(tmp_path / "mine.onnx")
    monkeypatch.chdir(tmp_path)
    succeed(capsys, "evaluate", model, room, "--baselines", "mb, mine.onnx,", "--out", "out")
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert list(metrics["methods"]) == ["ours (default)", "mb", "mine.onnx"]
    again = f"--baselines mb,{tmp_path / 'mine.onnx'}"
    assert again in html.unescape((tmp_path / "out/report.html").read_text())


def test_folds_compare_too(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    options = ("--folds", 2, "--baselines", "mb", "--out", tmp_path / "out")
    shown = succeed(capsys, "evaluate", room, *options).out
    assert "ROC AUC of mb" in shown
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert metrics["methods"]["mb"]["n_frames"] == 8


def test_what_is_too_small_for_a_method_is_told(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ("--baselines", "gbvs", "--out", tmp_path / "out")
    outcome = succeed(capsys, "evaluate", model, room, *options)
    assert "gbvs: no map of 8 frames" in outcome.err


@pytest.mark.parametrize("names", ["bsm", "all,bsm", "missing.onnx", ","])
def test_unknown_methods_are_refused_before_anything_is_learned(
    names: str, model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ("--baselines", names, "--out", tmp_path / "out")
    line = refusal(capsys, "evaluate", model, room, *options)
    assert "baselines: expected" in line or "missing.onnx" in line
    assert not (tmp_path / "out").exists()
