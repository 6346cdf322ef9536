"""curiosight bench: what it times, prints and refuses."""

from __future__ import annotations

import json
import time
from pathlib import Path

import cv2
import pytest

from command import call, interrupt_at, refusal, succeed
from curiosight.experiments.timing import STAGES, StageTimes, Timing, one_thread
from recordings import truncate, write_folder

Capsys = pytest.CaptureFixture[str]
FIGURES = {"median_ms", "p90_ms", "processor_median_ms", "processor_p90_ms"}


def test_all_stages_are_timed(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bench.json"
    shown = succeed(capsys, "bench", room, "--frames", 3, "--json", file).out
    figures = json.loads(file.read_text())
    assert tuple(figures["stages"]) == STAGES
    assert (figures["frames"], figures["image"], figures["threads"]) == (3, "160x120", 1)
    assert figures["preset"] == "default"
    for stage, spent in figures["stages"].items():
        assert set(spent) == FIGURES
        assert 0 < spent["median_ms"] <= spent["p90_ms"]
        assert f"{stage} (ms)" in shown


@pytest.mark.parametrize("stage", STAGES)
def test_one_stage_is_timed(stage: str, room: Path, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "bench.json"
    succeed(capsys, "bench", room, "--frames", 2, "--stage", stage, "--json", file, "--quiet")
    assert list(json.loads(file.read_text())["stages"]) == [stage]


def test_the_preset_is_that_of_the_settings(room: Path, capsys: Capsys) -> None:
    arguments = ("--frames", 1, "--stage", "segment", "--preset", "paper")
    shown = succeed(capsys, "bench", room, *arguments).out
    assert "preset        paper" in shown


def test_the_result_takes_the_place_of_an_older_one(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    file = tmp_path / "bench.json"
    file.write_text("old")
    succeed(capsys, "bench", room, "--frames", 1, "--stage", "segment", "--json", file)
    assert json.loads(file.read_text())["frames"] == 1


def test_bad_frames_are_not_timed(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 4)
    truncate(tmp_path / "room/depth/000000.png")
    file = tmp_path / "bench.json"
    succeed(capsys, "bench", tmp_path / "room", "--json", file)
    assert json.loads(file.read_text())["frames"] == 3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--stage think", "stage: expected segment, describe, predict, learn, got 'think'"),
        ("--json nowhere/bench.json", "nowhere: is not a folder"),
        ("--frames 0", "frames: expected 1 or more, got 0"),
        ("--preset best", "default or paper, got 'best'"),
    ],
)
def test_unusable_options(options: str, words: str, room: Path, capsys: Capsys) -> None:
    assert words in refusal(capsys, "bench", room, *options.split())


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_it_shows_what_is_timed(
    room: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Timing, "_run", turn=3)  # the first turn is the warm-up
    outcome = call(capsys, "bench", room, "--stage", "segment")
    assert outcome.status == 130
    assert "stopped after 2 frames" in outcome.err
    assert "segment (ms)" in outcome.out


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_before_anything_is_timed(
    room: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Timing, "_labels")
    outcome = call(capsys, "bench", room, "--stage", "learn")
    assert outcome.status == 130
    assert outcome.out == ""


def test_times_of_a_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "perf_counter", iter([1.0, 1.5, 2.0, 2.1]).__next__)
    monkeypatch.setattr(time, "process_time", iter([0.0, 0.2, 5.0, 5.1]).__next__)
    times = StageTimes()
    assert times.run(lambda: "result") == "result"
    times.run(lambda: None)
    monkeypatch.undo()
    assert times.summary() == {
        "median_ms": 300,
        "p90_ms": 460,
        "processor_median_ms": 150,
        "processor_p90_ms": 190,
    }


def test_opencv_is_left_with_the_threads_it_had() -> None:
    n_threads = cv2.getNumThreads()
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == n_threads
