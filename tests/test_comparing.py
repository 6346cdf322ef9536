"""Other methods on the frames that the learned map is judged on."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation import MapScores, MethodScores, ObjectTruth, roc_auc, score_histogram
from curiosight.evaluation.baselines import METHODS
from curiosight.experiments import comparing
from curiosight.experiments.comparing import SHOWN_WIDTH, Comparison, Judged, choose_methods
from curiosight.frame import Camera, Frame, Label

HEIGHT, WIDTH = 48, 64
CAMERA = Camera(WIDTH, HEIGHT, 60.0, 60.0, 31.5, 23.5)


def left_half() -> npt.NDArray[np.float32]:
    """A map that finds the left half."""
    found = np.zeros((HEIGHT, WIDTH), np.float32)
    found[:, : WIDTH // 2] = 1
    return found


def judged(id: str, n_salient_columns: int = WIDTH // 2, *, has_labels: bool = True) -> Judged:
    """Return a frame whose left columns are salient; the teacher leaves the last one unknown."""
    rgb = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    rgb[:, :n_salient_columns] = 200
    truth = np.zeros((HEIGHT, WIDTH), np.uint8)
    truth[:, :n_salient_columns] = Label.SALIENT
    labels = truth.copy()
    labels[:, -1] = Label.UNKNOWN
    depth = np.full((HEIGHT, WIDTH), 2.0, np.float32)
    frame = Frame(id, rgb, depth, CAMERA)
    return Judged(frame, truth, labels if has_labels else None, None)


def compare(methods: dict[str, object], **options: object) -> Comparison:
    settings: dict[str, object] = {"max_range": 4.0, "threshold": 0.5, "seed": 3} | options
    return Comparison("ours", methods, **settings)  # type: ignore[arg-type]


def test_every_method_is_scored_on_the_same_frames() -> None:
    comparison = compare({"all black": lambda rgb: np.zeros(rgb.shape[:2], np.float32)})
    for id in ("a", "b", "c"):
        comparison.add(judged(id), lambda rgb: left_half())
    metrics = comparison.metrics()
    assert list(metrics) == ["ours", "all black"]
    assert metrics["ours"]["pooled"]["all"]["roc_auc"] == 1
    assert metrics["all black"]["pooled"]["all"]["roc_auc"] == 0.5
    assert metrics["ours"]["objects"]["mae"] == 0
    assert metrics["all black"]["objects"]["mae"] == 0.5
    assert [frame["id"] for frame in metrics["all black"]["per_frame"]] == ["a", "b", "c"]
    assert metrics["ours"]["intervals"]["roc_auc"] == (1, 1)
    assert set(comparison.times_ms()) == {"ours", "all black"}


def test_depth_is_noise_where_the_teacher_is_unsure() -> None:
    comparison, again = compare({"depth": None}), compare({"depth": None})
    for one in (comparison, again):
        one.add(judged("a"), lambda rgb: left_half())
        one.add(judged("b", 20), lambda rgb: left_half())
    table = comparison.metrics()["depth"]
    known_share = 1 - 1 / (WIDTH - (WIDTH // 2 + 20) / 2)
    assert table["pooled"]["all"]["roc_auc"] == pytest.approx(
        known_share + (1 - known_share) / 2, abs=0.02
    )
    assert table == again.metrics()["depth"]
    assert "depth" not in comparison.times_ms()


def test_what_cannot_be_mapped_is_told() -> None:
    comparison = compare({"gbvs": METHODS["gbvs"], "depth": None})
    comparison.add(judged("a", has_labels=False), lambda rgb: left_half())
    assert list(comparison.metrics()) == ["ours"]
    assert [(name, n_frames) for name, _, n_frames in comparison.failures] == [
        ("gbvs", 1),
        ("depth", 1),
    ]


def test_shown_are_the_frames_that_were_asked_for() -> None:
    comparison = compare({"depth": None}, show=["b"])
    for id in ("a", "b"):
        comparison.add(judged(id), lambda rgb: left_half())
    (shown,) = comparison.shown
    assert shown.id == "b"
    assert list(shown.maps) == ["ours", "depth"]
    assert shown.rgb.shape[1] <= SHOWN_WIDTH


def test_methods_are_chosen_by_name() -> None:
    assert list(choose_methods("bms, gbvs")) == ["bms", "gbvs"]
    assert choose_methods("depth") == {"depth": None}
    assert set(choose_methods("all")) >= {*METHODS, "depth"}
    assert list(choose_methods("bms,all"))[:2] == ["bms", "bms-fixation"]


@pytest.mark.parametrize("names", ["bsm", "all,bsm", " , "])
def test_unknown_methods_are_refused(names: str) -> None:
    with pytest.raises(ValueError, match="baselines: expected all or some of bms"):
        choose_methods(names)


def test_network_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparing, "find_u2netp", lambda: None)
    assert "u2netp" not in choose_methods("all")
    with pytest.raises(ValueError, match="u2netp is not installed; pip install"):
        choose_methods("u2netp")


def test_scores_of_a_method_are_those_of_its_maps() -> None:
    rng = np.random.default_rng(0)
    scores, maps = MethodScores(), MapScores()
    for index in range(4):
        truth = rng.choice(np.array([0, 125, 255], np.uint8), (HEIGHT, WIDTH))
        saliency = rng.random((HEIGHT, WIDTH), np.float32)
        scores.add(str(index), saliency, ObjectTruth(truth))
        maps.add(str(index), saliency, truth)
    table = scores.table()
    assert table["pooled"] == maps.table()["pooled"]
    low, high = scores.intervals(1)["roc_auc"] or (0, 0)
    assert low < table["pooled"]["all"]["roc_auc"] < high
    assert scores.intervals(1) == scores.intervals(1)
    recall, precision = scores.precision_recall().T
    assert recall[-1] == 1
    assert precision[-1] == pytest.approx(0.5, abs=0.02)


def test_one_frame_that_is_known_gives_no_interval() -> None:
    rng, scores = np.random.default_rng(0), MethodScores()
    for truth in (judged("a").truth, *[np.full((HEIGHT, WIDTH), 125, np.uint8)] * 3):
        scores.add("a", rng.random((HEIGHT, WIDTH), np.float32), ObjectTruth(truth))
    assert scores.intervals(0)["roc_auc"] is None
    assert scores.table()["pooled"]["all"]["roc_auc"] == pytest.approx(0.5, abs=0.05)


def test_without_frames_there_are_no_curves() -> None:
    assert MethodScores().precision_recall().shape == (0, 2)
    assert MethodScores().intervals(0)["average_precision"] is None


def test_histograms_of_a_method_tell_its_area() -> None:
    truth = judged("a").truth
    assert roc_auc(score_histogram(left_half(), truth)) == 1
