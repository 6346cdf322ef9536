"""Ctrl-C keeps what was done, whenever it comes; a reader that leaves is no error."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

import curiosight_command
from command import Outcome, call, files, interrupt_at
from curiosight.cli.app import run
from curiosight.cli.interrupt import STOPPING, CtrlC
from curiosight.experiments.keeping import Keeping
from curiosight.learner.learner import SaliencyLearner

Capsys = pytest.CaptureFixture[str]
WRITTEN = {"command.json", "config.toml", "steps.csv", "decisions.csv", "timings.csv"}
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


@pytest.mark.parametrize("number", STOPPING)
def test_ignored_signal_stays_ignored(number: signal.Signals) -> None:
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with CtrlC() as ctrl_c:
            signal.raise_signal(number)
        assert not ctrl_c.is_pressed
        assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        signal.signal(number, before)


@pytest.mark.parametrize("second", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("first", [signal.SIGTERM, signal.SIGHUP])
def test_second_signal_ends_at_once(
    first: signal.Signals, second: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("curiosight.cli.interrupt.SAME_HANG_UP_S", 0)
    with CtrlC() as ctrl_c:
        signal.raise_signal(first)
        assert ctrl_c.status == 128 + first
        with pytest.raises(SystemExit) as caught:
            signal.raise_signal(second)
    assert caught.value.code == 128 + second
    assert signal.getsignal(first) is signal.SIG_DFL


def test_terminal_that_closes_is_told_of_twice_and_is_one_wish() -> None:
    with CtrlC() as ctrl_c:
        for _ in range(2):
            signal.raise_signal(signal.SIGHUP)
    assert ctrl_c.status == 129


def test_explore_interrupted_in_its_setup_writes_nothing(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, import_module("curiosight.experiments.exploring"), "make_teacher")
    outcome = call(capsys, "explore", room, "--out", tmp_path / "out")
    assert outcome == Outcome(130, "", "curiosight: interrupted\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("method", ["describe", "segment", "vote", "learn"])
def test_explore_interrupted_in_its_loop_keeps_run_and_model(
    method: str, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    # The eight test frames are described before the first step.
    turn = 8 + 3 if method == "describe" else 3
    interrupt_at(monkeypatch, SaliencyLearner, method, turn=turn)
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
    interrupt_at(monkeypatch, SaliencyLearner, "maps", turn=3)
    (tmp_path / "out").mkdir()
    (tmp_path / "out/metrics.json").write_text("of an earlier run")
    options = ("--folds", 2, "--out", tmp_path / "out", "--overwrite")
    outcome = call(capsys, "evaluate", room, *options)
    assert outcome.status == 130
    assert files(tmp_path / "out") == {"config.toml"}


def started(command: str, source: Path, out: Path, *options: str) -> subprocess.Popen[str]:
    """Start a command in a process of its own."""
    words = [sys.executable, "-c", PROGRAM, command, str(source), "--out", str(out), *options]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(process: subprocess.Popen[str], is_reached: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 60
    while not is_reached():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)


def n_steps_in(out: Path) -> int:
    steps = out / "steps.csv"
    return steps.read_text().count("\n") - 1 if steps.is_file() else 0


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (signal.SIGINT, "interrupted"),
        (signal.SIGTERM, "ended by SIGTERM"),
        (signal.SIGHUP, "ended by SIGHUP"),
    ],
)
def test_signal_to_a_real_process(
    number: signal.Signals, said: str, room: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    process = started("explore", room, out, "--steps", "100000")
    wait_for(process, lambda: n_steps_in(out) > 3)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert err.splitlines()[-1] == f"curiosight: {said}"
    assert "run and model are kept" in err
    assert "Traceback" not in err
    n_samples = SaliencyLearner.load(out / "model.npz").forest.n_samples
    assert n_samples == min(700 * n_steps_in(out), 100_000)
    assert {"summary.json", "report.html"} <= files(out)
    assert not [name for name in files(out) if name.endswith((".partial", ".part"))]


def test_killed_run_leaves_its_model_and_nothing_of_an_earlier_one(
    room: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert run(["explore", str(room), "--steps", "2", "--out", str(out), "--quiet"]) == 0
    (out / "mine.txt").write_text("kept")
    process = started("explore", room, out, "--steps", "100000", "--seed", "9", "--overwrite")
    wait_for(process, lambda: n_steps_in(out) > 60)
    process.kill()
    process.communicate(timeout=60)
    assert files(out) == {*WRITTEN, "state.npz", "model.npz", "mine.txt"}
    learner = SaliencyLearner.load(out / "model.npz")
    assert learner.forest.is_trained
    assert learner.forest.n_samples % (50 * 700) == 0
    assert learner.notes["frames"] == {str(room): [f"{index:06d}" for index in range(8)]}


def test_model_that_a_run_goes_on_with_is_there_until_there_is_a_newer_one(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    assert call(capsys, "explore", room, "--steps", 2, "--out", out).status == 0

    def die(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(SaliencyLearner, "vote", die)
    options = ("--from", out, "--overwrite", "--out", out)
    assert call(capsys, "explore", room, *options).status == 130
    assert SaliencyLearner.load(out / "model.npz").forest.n_samples == 2 * 700
    assert "summary.json" not in files(out)


def test_writing_the_model_meanwhile_changes_nothing(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    written = []
    save = SaliencyLearner.save

    def noted(self: SaliencyLearner, path: Path, *, is_packed: bool = True) -> None:
        save(self, path, is_packed=is_packed)
        # What is written meanwhile can be read, and would be what is left.
        written.append(SaliencyLearner.load(path).forest.n_samples)

    monkeypatch.setattr(SaliencyLearner, "save", noted)
    results = []
    for is_due in (True, False):
        monkeypatch.setattr(Keeping, "is_due", lambda _, is_due=is_due: is_due)
        out = tmp_path / str(is_due)
        assert call(capsys, "explore", room, "--steps", 5, "--out", out).status == 0
        assert call(capsys, "learn", room, "--out", out / "learned").status == 0
        names = ("steps.csv", "model.npz", "learned/model.npz")
        results.append([(out / name).read_bytes() for name in names])
    assert results[0] == results[1]
    # Posed frames are looked at twice; the second time all are known.
    explored, learned = [1, 2, 3, 4, 5, 5], [*range(1, 9), *8 * [8], 8]
    assert [n_samples // 700 for n_samples in written] == [*explored, *learned, 5, 8]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_learn_ended_by_a_signal_fits_what_there_is(
    number: signal.Signals,
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
) -> None:
    interrupt_at(monkeypatch, SaliencyLearner, "sample", turn=2, number=number)
    outcome = call(capsys, "learn", room, "--out", tmp_path / "out")
    assert outcome.status == 128 + number
    assert outcome.err.splitlines()[-1] == f"curiosight: ended by {number.name}"
    assert SaliencyLearner.load(tmp_path / "out/model.npz").forest.n_samples == 2 * 700
    assert "summary.json" in files(tmp_path / "out")


def test_run_survives_its_terminal(room: Path, tmp_path: Path) -> None:
    """Who closes the window, or loses the ssh, loses nothing that was learned."""
    pty = pytest.importorskip("pty")
    out = tmp_path / "out"
    child, terminal = pty.fork()
    if child == 0:
        words = [sys.executable, "-c", PROGRAM, "explore", str(room), "--steps", "100000"]
        os.execv(sys.executable, [*words, "--out", str(out)])
    deadline = time.monotonic() + 60
    while n_steps_in(out) < 4:
        assert time.monotonic() < deadline
        while select.select([terminal], [], [], 0.02)[0]:
            os.read(terminal, 1 << 16)
    os.close(terminal)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 129
    assert {"model.npz", "summary.json", "report.html"} <= files(out)


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
