"""curiosight explore: what a run consists of, that it can be repeated, and gone on with."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from command import call, files, succeed
from curiosight import load_config
from curiosight.cli.app import run
from curiosight.config import Config, ForestConfig, LearnerConfig
from curiosight.errors import DataError
from curiosight.experiments.components import load_learner, make_learner
from curiosight.learner.learner import SaliencyLearner
from recordings import write_depth, write_folder, write_image, write_osd
from room import ROOM, kinect, poses_around, render

Capsys = pytest.CaptureFixture[str]
RUN_FILES = {
    "command.json",
    "config.toml",
    "state.npz",
    "steps.csv",
    "decisions.csv",
    "timings.csv",
    "model.npz",
    "report.html",
    "summary.json",
    "timings.json",
    "figures/learning_curve.png",
    "figures/time_per_region.png",
    "figures/regions.png",
    "figures/examples.png",
}


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain folder of twenty frames with poses and ground truth."""
    path = tmp_path_factory.mktemp("recordings") / "room"
    write_folder(path, 20)
    return path


@pytest.fixture(scope="module")
def explored(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of eight steps that was tested on every fifth frame."""
    path = tmp_path_factory.mktemp("runs") / "first"
    options = ["--steps", "8", "--test-every", "5", "--gap", "1", "--quiet"]
    assert run(["explore", str(room), *options, "--out", str(path)]) == 0
    return path


def steps_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "steps.csv").open() as file:
        return list(csv.DictReader(file))


def summary_of(folder: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads((folder / "summary.json").read_text())
    return content


def test_files_of_a_run(explored: Path) -> None:
    assert files(explored) == RUN_FILES


def test_steps_say_where_it_looked_and_what_it_learned(explored: Path) -> None:
    steps = steps_of(explored)
    assert [step["step"] for step in steps] == [str(number) for number in range(8)]
    assert list(steps[0]) == [
        "step",
        "id",
        "region",
        "error",
        "learning_progress",
        "samples",
        "metres",
        "degrees",
        "overall_error",
    ]
    near_tests = {
        f"{index:06d}" for test in range(0, 20, 5) for index in (test - 1, test, test + 1)
    }
    assert not near_tests & {step["id"] for step in steps}
    assert [int(step["samples"]) for step in steps] == [700 * number for number in range(1, 9)]
    assert float(steps[0]["error"]) == 1.0, "nothing is predicted before the first step"
    assert float(steps[-1]["overall_error"]) < 0.3
    metres = [float(step["metres"]) for step in steps]
    assert metres == sorted(metres)


def test_summary_agrees_with_the_steps(explored: Path, room: Path) -> None:
    summary, steps = summary_of(explored), steps_of(explored)
    assert summary["steps"] == len(steps)
    assert summary["distinct_frames"] == len({step["id"] for step in steps})
    assert summary["overall_error"] == pytest.approx(float(steps[-1]["overall_error"]), abs=1e-6)
    assert (summary["tested_on"], summary["test_frames"]) == ("ground truth", 4)
    assert summary["source"] == summary["test_source"] == str(room)
    times = json.loads((explored / "timings.json").read_text())
    assert times["seconds"] > 0
    assert set(times["stages"]) == {"capture", "describe", "segment", "predict", "learn", "test"}
    with (explored / "timings.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(steps)


def test_config_repeats_the_run_byte_for_byte(
    explored: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    again = ("--config", explored / "config.toml", "--threads", 1)
    succeed(capsys, "explore", room, *again, "--out", tmp_path / "again")
    first, second = explored / "steps.csv", tmp_path / "again/steps.csv"
    assert first.read_bytes() == second.read_bytes()
    assert (explored / "model.npz").read_bytes() == (tmp_path / "again/model.npz").read_bytes()


def test_another_seed_is_another_run(explored: Path, room: Path, tmp_path: Path) -> None:
    options = ["--steps", "8", "--test-every", "5", "--gap", "1", "--seed", "1", "--quiet"]
    assert run(["explore", str(room), *options, "--out", str(tmp_path / "other")]) == 0
    assert (explored / "steps.csv").read_bytes() != (tmp_path / "other/steps.csv").read_bytes()


@pytest.mark.parametrize("strategy", ["chronological", "random", "iac"])
def test_every_strategy_runs(strategy: str, room: Path, tmp_path: Path, capsys: Capsys) -> None:
    options = ("--strategy", strategy, "--steps", 4, "--regions", "pose:1x1x2")
    succeed(capsys, "explore", room, *options, "--out", tmp_path / "out")
    ids = [step["id"] for step in steps_of(tmp_path / "out")]
    assert (ids == [f"{index:06d}" for index in range(4)]) == (strategy == "chronological")
    assert summary_of(tmp_path / "out")["strategy"] == strategy


def test_regions_from_a_file(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "regions.csv").write_text("000003,left\n000004,left\n000011,right\n")
    options = ("--regions", tmp_path / "regions.csv", "--steps", 4)
    succeed(capsys, "explore", room, *options, "--out", tmp_path / "out")
    assert {step["id"] for step in steps_of(tmp_path / "out")} == {"000003", "000004", "000011"}


def test_goes_on_with_a_model(explored: Path, room: Path, tmp_path: Path, capsys: Capsys) -> None:
    options = ("--from", explored, "--steps", 2, "--seed", 3)
    succeed(capsys, "explore", room, *options, "--out", tmp_path / "next")
    steps = steps_of(tmp_path / "next")
    assert [int(step["samples"]) for step in steps] == [9 * 700, 10 * 700]
    assert float(steps[0]["error"]) < 0.3, "it knew the room before the first step"
    assert summary_of(tmp_path / "next")["continued"] == str(explored / "model.npz")


def test_model_that_goes_on_keeps_its_own_features_and_forest(
    explored: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ("--from", explored, "--steps", 1, "--preset", "paper")
    outcome = succeed(capsys, "explore", room, *options, "--out", tmp_path / "next")
    assert "goes on with its own features and forest" in outcome.err
    written = load_config(path=tmp_path / "next/config.toml")
    default = load_config("default")
    assert (written.learner, written.forest) == (default.learner, default.forest)
    model = SaliencyLearner.load(tmp_path / "next/model.npz")
    assert model.describer.rows_per == "superpixel"


def test_every_setting_of_a_model_is_brought_along(tmp_path: Path) -> None:
    learner_settings = LearnerConfig(
        "superpixel",
        "lab",
        contrast=True,
        features="surroundings",
        superpixels="cells",
        n_superpixels=500,
        n_pixels=600,
        blind_share=0.1,
        salient_share=0.3,
        follow_edges=True,
        edge_stride=3,
        max_places=5,
        is_calibrated=True,
        threshold=0.4,
    )
    forest_settings = ForestConfig(
        n_trees=20,
        n_regrown=3,
        share=0.6,
        max_samples=9000,
        max_depth=8,
        min_split=9,
        n_split_features=7,
        leaf_share=0.01,
        n_levels=64,
        max_rows=300,
        vote="soft",
    )
    config = Config(learner=learner_settings, forest=forest_settings)
    make_learner(config, None).save(tmp_path / "model.npz")
    learner, brought = load_learner(tmp_path / "model.npz", load_config("paper"), None)
    assert learner.describer.n_superpixels == 500
    assert brought == config


def test_run_can_go_on_in_its_own_folder(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = tmp_path / "run"
    for options in (("--steps", 2), ("--steps", 3, "--from", out, "--overwrite")):
        succeed(capsys, "explore", room, *options, "--out", out)
    assert [int(step["samples"]) for step in steps_of(out)] == [2100, 2800, 3500]


def test_tests_on_another_recording(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_osd(tmp_path / "scenes", 3)
    options = ("--test", tmp_path / "scenes", "--steps", 4)
    outcome = succeed(capsys, "explore", room, *options, "--out", tmp_path / "out")
    assert "tested on: ground truth" in outcome.err
    summary = summary_of(tmp_path / "out")
    assert summary["test_source"] == str(tmp_path / "scenes")
    assert summary["test_frames"] == 3
    assert summary["training_frames"] == 20


def test_without_ground_truth_the_teacher_tests(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 6, with_ground_truth=False)
    options = ("--test-every", 3, "--gap", 0, "--steps", 4)
    outcome = succeed(capsys, "explore", tmp_path / "room", *options, "--out", tmp_path / "out")
    assert "tested on: teacher" in outcome.err
    assert summary_of(tmp_path / "out")["tested_on"] == "teacher"
    assert float(steps_of(tmp_path / "out")[-1]["overall_error"]) < 0.5


def test_model_is_kept_when_figures_fail(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise DataError("figures/learning_curve.png", "cannot be written", "free some space")

    monkeypatch.setattr("curiosight.cli.explore_report.learning_curve", fail)
    outcome = call(capsys, "explore", room, "--steps", 3, "--out", tmp_path / "out")
    assert outcome.status == 2
    assert outcome.err.splitlines()[-1].startswith("curiosight: figures/learning_curve.png")
    assert len(steps_of(tmp_path / "out")) == summary_of(tmp_path / "out")["steps"] == 3
    assert SaliencyLearner.load(tmp_path / "out/model.npz").forest.n_samples == 2100


def test_report_says_that_its_errors_are_not_those_of_maps(
    explored: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    said = "Errors are of superpixels, before maps follow the edges of the image"
    assert said in (explored / "report.html").read_text()
    options = ("--preset", "paper", "--steps", 1, "--out", tmp_path / "paper")
    succeed(capsys, "explore", room, *options)
    assert said not in (tmp_path / "paper/report.html").read_text()


def test_model_predicts_what_the_run_learned(explored: Path) -> None:
    learner = SaliencyLearner.load(explored / "model.npz")
    black = np.zeros((120, 160, 3), np.uint8)
    assert learner.forest.is_trained
    assert learner.saliency(black).shape == (120, 160)


def test_ground_truth_beside_the_test_frames_is_not_passed_over_silently(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_folder(tmp_path / "room", 8)
    for index in (0, 4):
        (tmp_path / "room" / "ground_truth" / f"{index:06d}.png").unlink()
    outcome = call(
        capsys, "explore", tmp_path / "room", "--steps", 2, "--test-every", 4, "--gap", 1,
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert outcome.status == 0
    assert "tested on: teacher" in outcome.err
    assert "not of the frames that are kept for testing" in outcome.err


def test_being_tested_on_what_was_learned_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room, first, second = (tmp_path / name for name in ("room", "first", "second"))
    write_folder(room, 8)
    succeed(capsys, "explore", room, "--steps", 8, "--strategy", "chronological", "--out", first)
    outcome = succeed(capsys, "evaluate", first, room, "--out", second)
    assert "8 of 8 test frames were learned from" in outcome.err
    assert json.loads((second / "metrics.json").read_text())["test_frames_learned"] == 8
    options = ("--steps", 2, "--test-every", 4, "--gap", 0, "--out", tmp_path / "third")
    assert "test frames were learned" not in succeed(capsys, "explore", room, *options).err
    options = (*options[:-1], tmp_path / "fourth", "--from", first)
    outcome = succeed(capsys, "explore", room, *options)
    assert "2 of 2 test frames were learned from" in outcome.err


def test_frames_with_ground_truth_are_tested_on_unasked(tmp_path: Path, capsys: Capsys) -> None:
    """They and their neighbours are kept out of learning where enough others are left."""
    write_folder(tmp_path / "room", 24)
    for index in set(range(24)) - {5, 16}:
        (tmp_path / "room" / "ground_truth" / f"{index:06d}.png").unlink()
    outcome = succeed(
        capsys, "explore", tmp_path / "room", "--steps", 30, "--out", tmp_path / "out"
    )
    assert "tested on: ground truth, 2 frames" in outcome.err
    summary = summary_of(tmp_path / "out")
    # 7 frames around each of two: 10 are left, fewer than half, so all of them are learned from.
    assert summary["training_frames"] == 24
    assert "these frames are learned from too" in outcome.err
    (tmp_path / "room/ground_truth/000016.png").unlink()
    outcome = succeed(
        capsys, "explore", tmp_path / "room", "--steps", 30, "--out", tmp_path / "fair"
    )
    assert "learns from 17 of 24 frames" in outcome.err
    fair = summary_of(tmp_path / "fair")
    assert (fair["training_frames"], fair["test_frames_learned"]) == (17, 0)
    near = {f"{5 + offset:06d}" for offset in range(-3, 4)}
    assert not near & {step["id"] for step in steps_of(tmp_path / "fair")}
    assert all(step["overall_error"] for step in steps_of(tmp_path / "fair"))


def test_tests_nobody_asked_for_change_no_learning(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    """Where all frames have ground truth the run is the one without any."""
    outcome = succeed(capsys, "explore", room, "--steps", 4, "--out", tmp_path / "with")
    assert "20 frames, 4 of them learned from" in outcome.out
    assert summary_of(tmp_path / "with")["test_frames_learned"] == 4
    write_folder(tmp_path / "bare", 20, with_ground_truth=False)
    succeed(capsys, "explore", tmp_path / "bare", "--steps", 4, "--out", tmp_path / "without")
    runs = [steps_of(tmp_path / name) for name in ("with", "without")]
    assert {step.pop("overall_error") == "" for step in runs[0]} == {False}
    assert {step.pop("overall_error") == "" for step in runs[1]} == {True}
    assert runs[0] == runs[1]
    models = [SaliencyLearner.load(tmp_path / name / "model.npz") for name in ("with", "without")]
    black = np.zeros((120, 160, 3), np.uint8)
    np.testing.assert_array_equal(models[0].saliency(black), models[1].saliency(black))


def test_damaged_ground_truth_stops_no_run_that_did_not_ask(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 4)
    for path in (tmp_path / "room/ground_truth").iterdir():
        path.write_bytes(b"no picture")
    options = (tmp_path / "room", "--steps", 2, "--out")
    outcome = succeed(capsys, "explore", *options, tmp_path / "out")
    assert "warning: the ground truth cannot be tested against" in outcome.err
    assert summary_of(tmp_path / "out")["tested_on"] == "nothing"
    asked = call(capsys, "explore", *options, tmp_path / "asked", "--test-every", 2, "--gap", 0)
    assert asked.status == 2


def test_mean_error_says_how_many_frames_count(tmp_path: Path, capsys: Capsys) -> None:
    """A frame whose truth shows nothing salient has no F1; what is marked in it counts pooled."""
    views = write_folder(tmp_path / "room", 6)
    for index in (0, 2, 4):
        write_image(
            tmp_path / f"room/ground_truth/{index:06d}.png", np.zeros_like(views[0].ground_truth)
        )
    out = tmp_path / "out"
    outcome = succeed(capsys, "explore", tmp_path / "room", "--steps", 12, "--out", out)
    summary = summary_of(out)
    assert (summary["frames_scored"], summary["frames_tested"]) == (3, 6)
    assert f"{summary['overall_error']:.3f}, mean of 3 of 6 frames" in outcome.out
    # Half of what is marked is wrong now: precision about 1/2, F1 about 2/3.
    assert summary["overall_error"] < 0.1
    assert summary["pooled_error"] == pytest.approx(1 / 3, abs=0.05)
    page = (out / "report.html").read_text()
    assert "3 of 6 test frames with objects" in page
    evaluated = succeed(capsys, "evaluate", out, tmp_path / "room", "--out", tmp_path / "evaluated")
    metrics = json.loads((tmp_path / "evaluated/metrics.json").read_text())
    assert (metrics["frames_scored"], metrics["n_frames"]) == (3, 6)
    assert f"{metrics['overall_error']:.3f}, mean of 3 of 6 frames" in evaluated.out
    assert metrics["pooled_error"] == pytest.approx(1 - metrics["pooled"]["all"]["f1"])
    assert metrics["pooled_error"] == pytest.approx(summary["pooled_error"], abs=0.05)


def test_hardly_any_look_with_an_object_is_told_with_what_to_try(
    tmp_path: Path, capsys: Capsys
) -> None:
    """One frame of five shows objects; the others a bare room, or nothing that depth sees."""
    write_folder(tmp_path / "room", 5)
    for index, pose in enumerate(poses_around(5)):
        if index in (1, 2):
            view = render(kinect(), pose, ROOM[3:])
            write_image(tmp_path / f"room/rgb/{index:06d}.png", view.rgb)
            write_depth(tmp_path / f"room/depth/{index:06d}.png", view.depth)
        elif index in (3, 4):
            depth = np.full((120, 160), 30.0, np.float32)
            write_depth(tmp_path / f"room/depth/{index:06d}.png", depth)
    options = ("--strategy", "chronological", "--steps", 10, "--regions", "time:1")
    outcome = succeed(capsys, "explore", tmp_path / "room", *options, "--out", tmp_path / "out")
    said = "8 of 10 looks taught nothing about objects: no object (4), no support plane is in view"
    assert f"warning: {said}" in outcome.err
    assert "warning: no object: see `curiosight segment SOURCE --reasons`" in outcome.err
    taught = summary_of(tmp_path / "out")["taught_nothing"]
    assert taught == {
        "looks": 8, "reasons": {"no object": 4, "no support plane is in view": 4}
    }  # fmt: skip
    assert said in (tmp_path / "out/report.html").read_text()
