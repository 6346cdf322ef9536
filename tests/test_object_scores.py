"""The measures of salient-object detection over frames: means, curves, intervals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from curiosight.evaluation.object_metrics import ObjectScore, score_objects
from curiosight.evaluation.object_scores import MEASURES, ObjectScores
from curiosight.evaluation.object_truth import ObjectTruth
from object_measures_peer import random_case


def scored(seed: int) -> ObjectScore:
    levels, truth = random_case(seed)
    return score_objects(levels / 255, ObjectTruth(truth))


@pytest.fixture(scope="module")
def frames() -> list[ObjectScore]:
    return [scored(seed) for seed in range(6)]


def collected(frames: list[ObjectScore]) -> ObjectScores:
    scores = ObjectScores()
    for index, score in enumerate(frames):
        scores.add(f"frame-{index}", score)
    return scores


def test_table_has_means_and_frames(frames) -> None:
    table = collected(frames).table()
    assert table["n_frames"] == 6
    assert [row["id"] for row in table["per_frame"]] == [f"frame-{i}" for i in range(6)]
    for name in set(MEASURES) - {"f_max", "e_max"}:
        column = [row[name] for row in table["per_frame"]]
        assert table["mean"][name] == pytest.approx(np.mean(column)), name
    assert json.loads(json.dumps(table)) == table


def test_highest_point_is_that_of_the_mean_curve(frames) -> None:
    table = collected(frames).table()
    curve = np.mean([score.f_curve for score in frames], axis=0)
    assert table["mean"]["f_max"] == pytest.approx(curve.max())
    assert table["mean"]["f_max"] < np.mean([row["f_max"] for row in table["per_frame"]])
    assert table["per_frame"][0]["f_max"] == frames[0].f_curve.max()


def test_order_of_frames_makes_no_difference(frames) -> None:
    forward, backward = collected(frames).table(), collected(frames[::-1]).table()
    assert forward["mean"] == pytest.approx(backward["mean"], abs=1e-12)


def test_frames_without_a_figure_are_left_out(frames) -> None:
    shape = (9, 9)
    empty = score_objects(np.full(shape, 0.5), ObjectTruth(np.zeros(shape, np.uint8)))
    ignored = score_objects(np.full(shape, 0.5), ObjectTruth(np.full(shape, 125, np.uint8)))
    without, table = collected(frames).table(), collected([*frames, empty, ignored]).table()
    assert table["n_frames"] == 8
    assert table["mean"]["weighted_f"] == without["mean"]["weighted_f"]
    assert table["mean"]["f_max"] == without["mean"]["f_max"]
    mae = [*(score.mae for score in frames), empty.mae]
    assert table["mean"]["mae"] == pytest.approx(np.mean(mae))
    assert table["per_frame"][-1] == {"id": "frame-7"} | dict.fromkeys(MEASURES)


def test_no_frame_has_no_figure() -> None:
    assert ObjectScores().table() == {
        "n_frames": 0,
        "mean": dict.fromkeys(MEASURES),
        "per_frame": [],
    }
    assert ObjectScores().intervals(np.random.default_rng(0)) == dict.fromkeys(MEASURES)


def test_intervals_hold_the_figures_and_repeat(frames) -> None:
    scores = collected(frames)
    means, intervals = scores.table()["mean"], scores.intervals(np.random.default_rng(0))
    assert intervals.keys() == MEASURES.keys()
    for name, (low, high) in intervals.items():
        assert low < means[name] < high, name
    assert scores.intervals(np.random.default_rng(0)) == intervals
    narrow = scores.intervals(np.random.default_rng(0), confidence=0.5)
    assert narrow["mae"].high - narrow["mae"].low < intervals["mae"].high - intervals["mae"].low
