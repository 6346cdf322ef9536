"""What is left of each place at the end of a run: by hand, and in the report of a recording."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from command import call, interrupt_at, succeed, without_times
from curiosight.experiments import forgetting
from curiosight.experiments.forgetting import N_LOOKS, Forgetting, by_place
from curiosight.learner.learner import SaliencyLearner
from curiosight.rooms.home import views
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
PLACES = np.array([0, 0, 1, -1, 1, 2])


def test_quality_of_a_place_is_the_mean_of_its_frames() -> None:
    errors = np.array([0.2, 0.4, 0.5, 0.9, 0.7, 0.1])
    assert by_place(errors, PLACES) == pytest.approx({0: 0.7, 1: 0.4, 2: 0.9})


def test_a_place_is_learned_when_it_is_left_after_some_looks() -> None:
    forgetting = Forgetting()
    said = [forgetting.is_left(place) for place in [0] * (N_LOOKS - 1) + [1, 0, 0, 1, 1]]
    assert said == [False] * (N_LOOKS + 2) + [True, False]
    forgetting.add(0, np.full(6, 0.5), PLACES)
    assert not any(forgetting.is_left(place) for place in [0, 1])  # once


def test_sums_are_those_of_the_matrix() -> None:
    forgetting = Forgetting()
    for place in (1, 0, 2):
        for _ in range(N_LOOKS):
            forgetting.is_left(place)
        if place != 2:
            errors = {1: [0.9, 0.9, 0.2, 0, 0.2, 1], 0: [0.4, 0.4, 0.1, 0, 0.1, 0.9]}[place]
            forgetting.add(place, np.array(errors), PLACES)
    summary = forgetting.summary(np.array([0.3, 0.3, 0.4, 0, 0.4, 0.2]), PLACES)
    assert summary == {
        "after": [1, 0],
        "tested_on": [1, 0, 2],
        "qualities": [[0.8, 0.1, 0.0], [0.9, 0.6, 0.1], [0.6, 0.7, 0.8]],
        "average_quality": 0.7,
        "backward_transfer": pytest.approx((-0.2 + 0.1) / 2),
        "forgetting": pytest.approx((0.3 + 0.0) / 2),
    }


def test_one_place_has_no_matrix() -> None:
    forgetting = Forgetting()
    for _ in range(2 * N_LOOKS):
        forgetting.is_left(0)
    assert forgetting.summary(np.zeros(6), PLACES) is None


def test_the_report_of_a_recording_of_two_places_tells_it(tmp_path: Path, capsys: Capsys) -> None:
    source = tmp_path / "source"
    write_folder(source, 32)
    settings = tmp_path / "settings.toml"
    settings.write_text("[test]\nevery = 4\ngap = 0\n")
    ids = sorted(path.stem for path in (source / "rgb").iterdir())
    (source / "places.txt").write_text(
        "".join(f"{id} {int(number >= 16)}\n" for number, id in enumerate(ids))
    )
    told = ("explore", source, "--strategy", "chronological", "--steps", 24, "--config", settings)
    succeed(capsys, *told, "--out", tmp_path / "run")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    left = summary["forgetting"]
    report = (tmp_path / "run" / "report.html").read_text()
    if left is None:
        pytest.fail(f"no matrix: {summary['steps']} steps, {summary['test_frames']} tests")
    assert left["after"] == [0]
    assert left["tested_on"] == [0, 1]
    assert len(left["qualities"]) == 2
    assert left["average_quality"] == pytest.approx(np.mean(left["qualities"][-1]))
    assert "after place 0" in report
    assert "backward transfer" in report
    (source / "places.txt").unlink()
    succeed(capsys, *told, "--out", tmp_path / "other")
    assert json.loads((tmp_path / "other" / "summary.json").read_text())["forgetting"] is None
    assert "after place 0" not in (tmp_path / "other" / "report.html").read_text()


HOME = "home:7,rooms=2,views=4"


def test_learn_tells_it_of_a_home_also_when_it_went_on(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(forgetting, "N_LOOKS", 3)
    monkeypatch.setattr(views, "N_TEST_VIEWS", 3)
    succeed(capsys, "learn", HOME, "--out", tmp_path / "whole")
    summary = json.loads((tmp_path / "whole" / "summary.json").read_text())
    left = summary["forgetting"]
    assert (left["after"], left["tested_on"]) == ([0], [0, 1])
    first, last = np.array(left["qualities"])
    assert first[1] < last[1]  # before it had seen the second room, and after
    assert left["backward_transfer"] == pytest.approx(last[0] - first[0], abs=2e-6)
    with pytest.MonkeyPatch.context() as patch:
        interrupt_at(patch, SaliencyLearner, "visit", turn=6)
        call(capsys, "learn", HOME, "--out", tmp_path / "run")
    assert (tmp_path / "run" / "state.npz").is_file()
    succeed(capsys, "learn", "--resume", tmp_path / "run")
    assert without_times(tmp_path / "run") == without_times(tmp_path / "whole")


def test_learn_has_no_tests_of_a_recording_nor_of_one_room(tmp_path: Path, capsys: Capsys) -> None:
    source = tmp_path / "source"
    write_folder(source, 24)
    ids = sorted(path.stem for path in (source / "rgb").iterdir())
    lines = [f"{id} {int(number >= 12)}\n" for number, id in enumerate(ids)]
    (source / "places.txt").write_text("".join(lines))
    for number, given in enumerate((source, "room:7,views=3")):
        succeed(capsys, "learn", given, "--out", tmp_path / f"{number}")
        summary = json.loads((tmp_path / f"{number}" / "summary.json").read_text())
        assert summary["forgetting"] is None
