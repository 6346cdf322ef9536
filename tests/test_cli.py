"""Every command from end to end on tiny recordings: what it writes, prints and returns."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import curiosight
from command import call, files, refusal, succeed
from curiosight.cli.lessons import tell_samples
from curiosight.evaluation import PARTS
from curiosight.learner.learner import SaliencyLearner
from recordings import write_folder, write_image, write_osd, write_seven_scenes, write_tum

COMMANDS = ("info", "explore", "learn", "map", "evaluate", "segment")
Capsys = pytest.CaptureFixture[str]


def test_info_tells_what_a_recording_is(tmp_path: Path, capsys: Capsys) -> None:
    write_seven_scenes(tmp_path, 6)
    facts = json.loads(succeed(capsys, "info", tmp_path, "--json").out)
    assert facts["layout"] == "7-Scenes"
    assert (facts["frames"], facts["width"], facts["height"]) == (6, 160, 120)
    assert (facts["poses"], facts["ground_truth"], facts["confidence"]) == (6, 3, 0)
    assert facts["depth"]["usable"] == facts["depth"]["opened"] == 6
    assert facts["depth"]["unit_m"] == 0.001
    assert 0.5 < facts["depth"]["min_m"] < facts["depth"]["max_m"] < 10
    assert facts["warnings"] == []
    assert facts["reasons"] == [
        "frame-*.color.* with frame-*.depth.png, in the folder or in seq-*/"
    ]
    assert sum(facts["regions"]["frames"]) == 6
    assert facts["camera"]["depth_window"] is not None
    shown = succeed(capsys, "info", tmp_path).out
    assert "ground truth  3" in shown
    assert "depth         6 of 6 usable, " in shown


def test_info_shows_the_regions_that_are_asked_for(room: Path, capsys: Capsys) -> None:
    facts = json.loads(succeed(capsys, "info", room, "--regions", "time:4", "--json").out)
    assert facts["regions"]["frames"] == [2, 2, 2, 2]


def test_segment_says_what_it_found_and_why_pixels_are_unknown(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    succeed(capsys, "segment", room, "--temporal", "--reasons", "--out", out)
    legend = {
        int(grey): why for grey, why in json.loads((out / "reasons.json").read_text()).items()
    }
    of_what = ("known", "floor", "table", "seat, bed or shelf", "wall", "object")
    found = [grey for grey, why in legend.items() if why in of_what]
    for path in sorted((out / "labels").glob("*.png")):
        labels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        reasons = cv2.imread(str(out / "reasons" / path.name), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(np.isin(reasons, found), (labels == 0) | (labels == 255))
        assert set(np.unique(reasons)) <= set(legend)


def test_segment_says_how_sure_it_is(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = tmp_path / "out"
    succeed(capsys, "segment", room, "--confidence", "--every", "4", "--out", out)
    for path in sorted((out / "labels").glob("*.png")):
        labels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        confidence = cv2.imread(str(out / "confidence" / path.name), cv2.IMREAD_UNCHANGED)
        is_known = (labels == 0) | (labels == 255)
        assert confidence[is_known].mean() > 150
        assert not confidence[~is_known].any()
    with_paper = ("--confidence", "--preset", "paper", "--out", tmp_path / "paper")
    assert "confidence" in refusal(capsys, "segment", room, *with_paper)


@pytest.mark.parametrize("write", [write_folder, write_seven_scenes, write_osd, write_tum])
def test_segment_writes_labels_instances_and_objects(
    write: object, tmp_path: Path, capsys: Capsys
) -> None:
    assert callable(write)
    write(tmp_path / "room", 3)
    out = tmp_path / "out"
    succeed(capsys, "segment", tmp_path / "room", "--out", out, "--every", 2)
    objects = json.loads((out / "objects.json").read_text())
    ids = list(objects)
    assert len(ids) == 2
    assert files(out) == {"config.toml", "objects.json"} | {
        f"{kind}/{id}.{ending}"
        for kind, ending in (("labels", "png"), ("instances", "png"), ("overlays", "jpg"))
        for id in ids
    }
    labels = cv2.imread(str(out / f"labels/{ids[0]}.png"), cv2.IMREAD_UNCHANGED)
    instances = cv2.imread(str(out / f"instances/{ids[0]}.png"), cv2.IMREAD_UNCHANGED)
    assert labels.shape == instances.shape == (120, 160)
    assert labels.dtype == np.uint8
    assert instances.dtype == np.uint16
    assert set(np.unique(labels)) <= {0, 75, 125, 255}
    assert set(np.unique(instances)) == {0, *(entry["instance"] for entry in objects[ids[0]])}
    assert (labels[instances > 0] == 255).all()


def test_objects_are_described_in_pixels_and_metres(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "segment", room, "--out", tmp_path / "out")
    objects = json.loads((tmp_path / "out/objects.json").read_text())["000004"]
    instances = cv2.imread(str(tmp_path / "out/instances/000004.png"), cv2.IMREAD_UNCHANGED)
    assert objects
    for entry in objects:
        assert entry["area_px"] == (instances == entry["instance"]).sum()
        assert all(0.1 < length < 1.0 for length in entry["size_m"] if length)
        assert 1.0 < entry["distance_m"] < 3.0


def test_learn_writes_a_model_and_says_what_it_took(model: Path) -> None:
    assert files(model) == {"command.json", "config.toml", "model.npz", "summary.json"}
    summary = json.loads((model / "summary.json").read_text())
    assert summary["frames"] == 8
    assert summary["samples_drawn"] == summary["samples_kept"] == 8 * 700


def test_learn_says_how_samples_are_capped(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "few.toml").write_text("[forest]\nmax_samples = 1000")
    config = ("--config", tmp_path / "few.toml")
    shown = succeed(capsys, "learn", room, *config, "--out", tmp_path / "out").out
    assert "1000 of 4000, chosen at random" in shown
    # The recording was sampled sparingly; what the model learns on-line from a frame stays.
    assert SaliencyLearner.load(tmp_path / "out/model.npz").n_pixels == 700


@pytest.mark.parametrize(
    ("kept", "views", "drawn", "said"),
    [
        (700, [], None, "700"),
        (5600, [8], 5600, "5600"),
        (1000, [8], 5600, "1000 of 5600, chosen at random"),
        (50, [3, 2], 30, "30 drawn; 50 in 3 forests, some in two of them"),
        (50, [3, 2], None, "50 in 3 forests, some in two of them"),
    ],
)
def test_samples_kept_twice_are_not_said_to_be_chosen_of_fewer(
    kept: int, views: list[int], drawn: int | None, said: str
) -> None:
    assert tell_samples(kept, views, drawn) == said


def test_map_finds_in_colour_what_depth_taught(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "map", model, room / "rgb", "--out", tmp_path / "out", "--overlay")
    assert "overlays/000004.jpg" in files(tmp_path / "out")
    saliency = cv2.imread(str(tmp_path / "out/000004.png"), cv2.IMREAD_UNCHANGED)
    truth = cv2.imread(str(room / "ground_truth/000004.png"), cv2.IMREAD_UNCHANGED)
    assert saliency.shape == truth.shape
    assert saliency[truth == 255].mean() > saliency[truth == 0].mean() + 100


def test_map_takes_pictures_of_any_size_and_kind(
    model: Path, tmp_path: Path, capsys: Capsys
) -> None:
    rng = np.random.default_rng(0)
    shapes = {"grey": (90, 120), "tiny": (10, 10, 3), "wide": (60, 200, 3), "large": (300, 250, 3)}
    for name, shape in shapes.items():
        write_image(tmp_path / f"photos/{name}.png", rng.integers(0, 255, shape, np.uint8))
    rgba = rng.integers(0, 255, (50, 60, 4), np.uint8)
    assert cv2.imwrite(str(tmp_path / "photos/rgba.png"), rgba)
    succeed(capsys, "map", model, tmp_path / "photos", "--out", tmp_path / "out")
    for name, shape in {**shapes, "rgba": (50, 60)}.items():
        found = cv2.imread(str(tmp_path / f"out/{name}.png"), cv2.IMREAD_UNCHANGED)
        assert found.shape == shape[:2]


def test_map_passes_over_pictures_it_cannot_cut(
    model: Path, tmp_path: Path, capsys: Capsys
) -> None:
    rng = np.random.default_rng(0)
    write_image(tmp_path / "photos/line.png", rng.integers(0, 255, (300, 2, 3), np.uint8))
    write_image(tmp_path / "photos/square.png", rng.integers(0, 255, (90, 90, 3), np.uint8))
    outcome = succeed(capsys, "map", model, tmp_path / "photos", "--out", tmp_path / "out")
    assert files(tmp_path / "out") == {"square.png"}
    assert "warning: 1 of 2 frames could not be mapped" in outcome.err
    assert "line" in outcome.err


def test_map_of_a_video(model: Path, tmp_path: Path, capsys: Capsys) -> None:
    clip = tmp_path / "clip.avi"
    writer = cv2.VideoWriter(str(clip), cv2.VideoWriter.fourcc(*"MJPG"), 10, (160, 120))
    for grey in (50, 100, 150):
        writer.write(np.full((120, 160, 3), grey, np.uint8))
    writer.release()
    succeed(capsys, "map", model, clip, "--out", tmp_path / "out")
    assert files(tmp_path / "out") == {"000000.png", "000001.png", "000002.png"}


def test_evaluate_against_ground_truth(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    printed = succeed(capsys, "evaluate", model, room, "--out", tmp_path / "out", "--json").out
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert json.loads(printed) == {**metrics, "out": str(tmp_path / "out")}
    assert metrics["truth"] == "ground truth"
    assert metrics["n_frames"] == 8
    assert metrics["pooled"]["all"]["roc_auc"] > 0.95
    assert (tmp_path / "out/config.toml").read_text() == (model / "config.toml").read_text()
    assert set(metrics["pooled"]) == set(PARTS)
    figures = {"roc.png", "reliability.png"}
    assert files(tmp_path / "out") == {"config.toml", "metrics.json", *figures}
    calibration = metrics["reliability"]
    assert calibration["learned"]["expected_calibration_error"] < 0.1
    assert calibration["fused"]["expected_calibration_error"] < 0.05
    fused, depth = (metrics["depth_at_hand"][name] for name in ("fused", "depth"))
    learned = metrics["pooled"]["all"]
    assert fused["roc_auc"] >= max(depth["roc_auc"], learned["roc_auc"]) - 0.001
    assert fused["best_f1"] - fused["f1"] < 0.03


def test_evaluate_against_the_teacher_says_so(model: Path, tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 2, with_ground_truth=False)
    out = tmp_path / "out"
    assert "teacher" in succeed(capsys, "evaluate", model, tmp_path / "room", "--out", out).out
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["truth"] == "teacher"
    assert "depth_at_hand" not in metrics  # it would be tested against itself
    assert metrics["reliability"].keys() == {"learned"}


def test_evaluate_takes_ground_truth_from_elsewhere(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    write_image(tmp_path / "mine/000003.png", np.eye(120, 160, dtype=np.uint8) * 255)
    options = ("--ground-truth", tmp_path / "mine", "--out", tmp_path / "out")
    succeed(capsys, "evaluate", model, room, *options)
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert [score["id"] for score in metrics["per_frame"]] == ["000003"]


@pytest.mark.parametrize("split", ["frames", "blocks"])
def test_evaluate_by_folds_tests_every_frame_once(
    split: str, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    (tmp_path / "gap.toml").write_text("[test]\ngap = 1")
    options = ("--folds", 4, "--split", split, "--config", tmp_path / "gap.toml")
    succeed(capsys, "evaluate", room, *options, "--out", tmp_path / "out")
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert sorted(score["id"] for score in metrics["per_frame"]) == [f"{i:06d}" for i in range(8)]
    assert metrics["split"] == split
    assert metrics["pooled"]["all"]["roc_auc"] > 0.9


def test_same_seed_gives_the_same_model(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    for name, threads in (("one", 1), ("two", 2)):
        succeed(capsys, "learn", room, "--threads", threads, "--out", tmp_path / name)
    one, two = (tmp_path / name / "model.npz" for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()


def test_new_folder_under_runs_where_no_out_is_given(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    succeed(capsys, "learn", room)
    (made,) = (tmp_path / "runs").iterdir()
    assert made.name.startswith("learn-")
    assert "model.npz" in files(made)


def test_quiet_says_nothing(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    outcome = succeed(capsys, "segment", room, "--quiet", "--out", tmp_path / "out")
    assert (outcome.out, outcome.err) == ("", "")


def test_json_stands_alone_on_standard_output(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    outcome = succeed(capsys, "segment", room, "--json", "--out", tmp_path / "out")
    assert json.loads(outcome.out)["frames"] == 8
    assert "plain folder, 8 frames, 8 with pose, 8 with ground truth" in outcome.err


def test_narrow_terminal_and_no_colour(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setenv("NO_COLOR", "1")
    out = tmp_path / ("long" * 20)
    outcome = succeed(capsys, "segment", room, "--out", out)
    assert str(out) in outcome.out, "a path that is broken cannot be copied"
    assert "\x1b" not in outcome.out + outcome.err


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_of_every_command(name: str, flag: str, capsys: Capsys) -> None:
    outcome = succeed(capsys, name, flag)
    assert f"curiosight {name}" in outcome.out
    for option in ("--config", "--quiet", "--json"):
        assert option in outcome.out
    assert ("--preset" in outcome.out) == (name != "map"), "a model keeps its preset"


def test_no_arguments_shows_the_commands(capsys: Capsys) -> None:
    outcome = call(capsys)
    assert all(name in outcome.out for name in COMMANDS)
    assert (outcome.status, outcome.err) == (2, "")


def test_version(capsys: Capsys) -> None:
    assert succeed(capsys, "--version").out == f"curiosight {curiosight.__version__}\n"


def test_preset_flag_wins_over_the_file_and_the_file_over_defaults(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('[run]\nseed = 5\nn_threads = 1\n[learner]\nrows_per = "pixel"')
    out = tmp_path / "out"
    succeed(capsys, "learn", room, "--config", file, "--seed", 7, "--out", out)
    written = curiosight.load_config(path=out / "config.toml")
    assert (written.run.seed, written.run.n_threads) == (7, 1)
    assert written.learner.rows_per == "pixel"
    assert written.learner.colour_space == "lab"


@pytest.mark.parametrize("names", [("foo",), ("explore",), ("map", "a"), ("explore", "--foo")])
def test_wrong_words_name_the_help(names: tuple[str, ...], capsys: Capsys) -> None:
    assert "--help" in refusal(capsys, *names)


def test_names_do_nothing_to_a_terminal(tmp_path: Path, capsys: Capsys) -> None:
    folder = tmp_path / "red\x1b[31m\nblue"
    folder.mkdir()
    (folder / "x\x1b[2J\u202e.png").write_bytes(b"no image")
    write_image(folder / "y\x07.png", np.zeros((9, 9, 3), np.uint8))
    for outcome in (
        call(capsys, "info", folder),
        call(capsys, "info", folder / "missing"),
        call(capsys, "saliency", "bms", folder, "--out", tmp_path / "out"),
        call(capsys, "info", "\x1b[31m\n", "\x07--odd"),
        call(capsys, "odd\x1b[31m\n"),
    ):
        said = outcome.out + outcome.err
        assert said
        assert all(line.isprintable() for line in said.split("\n"))
    assert (
        "red\\x1b[31m\\nblue: folder of images, 2 frames"
        in succeed(capsys, "saliency", "bms", folder, "--out", tmp_path / "again").err
    )


def test_seed_of_an_evaluation_without_chance_is_refused(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    said = refusal(capsys, "evaluate", model, room, "--seed", 3, "--out", tmp_path / "out")
    assert "seed: expected --folds or --baselines too" in said


def test_map_has_no_preset_but_the_models_own(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    out = ("--out", tmp_path / "out")
    assert "--preset" in refusal(capsys, "map", model, room, "--preset", "paper", *out)
    succeed(capsys, "map", model, room, "--config", model / "config.toml", *out)
