"""Ctrl-C keeps what was done, whenever it comes; a reader that leaves is no error."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import pytest

import curiosight_command
from command import Outcome, call, files, interrupt_at
from curiosight.cli.interrupt import CtrlC
from curiosight.learner.learner import SaliencyLearner

Capsys = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("ctrl_c_as_usual")
# A test that runs in the background of a shell hands down an ignored Ctrl-C.
PROGRAM = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from curiosight.cli import main
main()
"""


def test_first_press_waits_and_the_second_does_not() -> None:
    seen = []
    with CtrlC() as ctrl_c:
        for number in ctrl_c.until_pressed(range(10)):
            if number == 3:
                signal.raise_signal(signal.SIGINT)
            seen.append(number)
        assert ctrl_c.is_pressed
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert seen == [0, 1, 2, 3]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ignored_ctrl_c_stays_ignored() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with CtrlC() as ctrl_c:
        signal.raise_signal(signal.SIGINT)
    assert not ctrl_c.is_pressed
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_explore_interrupted_in_its_setup_writes_nothing(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, import_module("curiosight.experiments.exploring"), "make_teacher")
    outcome = call(capsys, "explore", room, "--out", tmp_path / "out")
    assert outcome == Outcome(130, "", "curiosight: interrupted\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("method", ["describe", "segment", "predict", "learn"])
def test_explore_interrupted_in_its_loop_keeps_run_and_model(
    method: str, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, method, turn=3)
    outcome = call(capsys, "explore", room, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert outcome.err.splitlines()[-1] == "curiosight: interrupted"
    assert "stopped after 3 steps; run and model are kept" in outcome.err
    assert len((tmp_path / "out/steps.csv").read_text().splitlines()) == 1 + 3
    assert SaliencyLearner.load(tmp_path / "out/model.npz").forest.n_samples == 3 * 700
    assert {"summary.json", "figures/learning_curve.png"} <= files(tmp_path / "out")


def test_explore_interrupted_while_it_finishes_keeps_run_and_model(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, "save")
    outcome = call(capsys, "explore", room, "--steps", 2, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert SaliencyLearner.load(tmp_path / "out/model.npz").forest.n_samples == 2 * 700
    assert "summary.json" in files(tmp_path / "out")


def test_learn_interrupted_keeps_what_it_saw(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, "sample", turn=2)
    outcome = call(capsys, "learn", room, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert "stopped after 2 frames; the model of these is kept" in outcome.err
    assert SaliencyLearner.load(tmp_path / "out/model.npz").forest.n_samples == 2 * 700


def test_segment_interrupted_keeps_what_it_wrote(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, import_module("curiosight.cli.segment"), "overlay_labels", turn=2)
    outcome = call(capsys, "segment", room, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert "stopped after 2 frames; these are kept" in outcome.err
    folders = ("labels", "instances")
    assert files(tmp_path / "out") == {"config.toml", "objects.json"} | {
        *(f"{folder}/00000{index}.png" for folder in folders for index in (0, 1)),
        *(f"overlays/00000{index}.jpg" for index in (0, 1)),
    }


def test_map_interrupted_keeps_what_it_wrote(
    room: Path, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, "saliency", turn=3)
    outcome = call(capsys, "map", model, room, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert outcome.err.endswith("curiosight: interrupted\n")
    assert files(tmp_path / "out") == {"000000.png", "000001.png"}


def test_evaluate_interrupted_keeps_no_figures_of_a_part(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, "saliency", turn=3)
    outcome = call(capsys, "evaluate", room, "--folds", 2, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert files(tmp_path / "out") == {"config.toml"}


def test_ctrl_c_in_a_real_process(room: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-c", PROGRAM, "explore", str(room), "--steps", "100000"]
    process = subprocess.Popen(
        [*command, "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    steps = out / "steps.csv"
    deadline = time.monotonic() + 60
    while not (steps.is_file() and steps.read_text().count("\n") > 3):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "run and model are kept" in err
    assert "Traceback" not in err
    n_steps = steps.read_text().count("\n") - 1
    n_samples = SaliencyLearner.load(out / "model.npz").forest.n_samples
    assert n_samples == min(700 * n_steps, 100_000)
    assert not [name for name in files(out) if name.endswith((".partial", ".part"))]


@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_reader_that_leaves_is_no_error(flags: list[str], room: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-c", PROGRAM, "info", str(room), *flags]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert done.stderr == ""
    assert done.returncode == 1


def test_ctrl_c_during_the_imports(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("curiosight.cli.main", interrupted)
    with pytest.raises(SystemExit) as caught:
        curiosight_command.main()
    assert caught.value.code == 130
    assert capsys.readouterr().err == "curiosight: interrupted\n"
