"""Scores of saliency maps, against direct metrics on the concatenated pixels."""

from __future__ import annotations

import json

import numpy as np
import pytest
from sklearn.metrics import average_precision_score, f1_score, roc_auc_score

from curiosight.evaluation import PARTS, MapScores
from curiosight.evaluation.map_scores import LEVELS
from curiosight.frame import Label
from curiosight.metrics import f1_error

SIZE = (12, 16)
TRUTH_VALUES = [Label.SALIENT, Label.NOT_SALIENT, 125]


class Made:
    """A frame of random numbers: map, truth, the teacher's labels, depth with holes."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.truth = rng.choice(TRUTH_VALUES, SIZE).astype(np.uint8)
        noise = rng.integers(0, 7, SIZE) / 10
        exact = noise + 0.3 * (self.truth == Label.SALIENT)
        # In the steps that scores are kept in.
        self.saliency = np.rint(exact * LEVELS).astype(np.float32) / np.float32(LEVELS)
        self.labels = rng.choice([*Label], SIZE).astype(np.uint8)
        self.true_depth = rng.uniform(0.5, 8, SIZE).astype(np.float32)
        self.depth = np.where(rng.random(SIZE) < 0.3, np.nan, self.true_depth)

    @property
    def parts(self) -> dict[str, np.ndarray]:
        known = self.truth != 125
        return {
            "all": known,
            "unknown": known & (self.labels == 125),
            "unavailable": known & (self.labels == 75),
            "near": known & (np.nan_to_num(self.depth, nan=9.0) <= 4.0),
            "beyond_range": known & (self.true_depth > 4.0),
            "missing": known & np.isnan(self.depth) & (self.true_depth <= 4.0),
        }


@pytest.fixture
def frames() -> list[Made]:
    return [Made(seed) for seed in range(4)]


def scores_of(frames: list[Made]) -> MapScores:
    scores = MapScores()
    for number, made in enumerate(frames):
        scores.add(
            f"frame-{number}",
            made.saliency,
            made.truth,
            made.labels,
            made.depth,
            made.true_depth,
        )
    return scores


@pytest.mark.parametrize("part", PARTS)
def test_pooled_figures_are_those_of_all_pixels_together(frames, part: str) -> None:
    pooled = scores_of(frames).table()["pooled"][part]
    is_salient = np.concatenate([made.truth[made.parts[part]] == 255 for made in frames])
    saliency = np.concatenate([made.saliency[made.parts[part]] for made in frames])
    assert pooled["roc_auc"] == pytest.approx(roc_auc_score(is_salient, saliency))
    assert pooled["average_precision"] == pytest.approx(
        average_precision_score(is_salient, saliency)
    )
    assert pooled["f1"] == pytest.approx(f1_score(is_salient, saliency > 0.5))
    f1s = {t: f1_score(is_salient, saliency > t) for t in [-1, *np.unique(saliency)[:-1]]}
    assert pooled["best_f1"] == pytest.approx(max(f1s.values()))
    at_best = f1_score(is_salient, saliency > pooled["best_threshold"])
    assert at_best == pytest.approx(pooled["best_f1"])
    assert pooled["n_salient_px"] == is_salient.sum()
    assert pooled["n_not_salient_px"] == (~is_salient).sum()


@pytest.mark.parametrize("part", PARTS)
def test_per_frame_figures_are_those_of_each_frame(frames, part: str) -> None:
    table = scores_of(frames).table()
    for number, (made, found) in enumerate(zip(frames, table["per_frame"], strict=True)):
        chosen = made.parts[part]
        is_salient, saliency = made.truth[chosen] == 255, made.saliency[chosen]
        assert found["id"] == f"frame-{number}"
        assert found[part]["roc_auc"] == pytest.approx(roc_auc_score(is_salient, saliency))
        assert found[part]["f1"] == pytest.approx(f1_score(is_salient, saliency > 0.5))
        truth = np.where(chosen, made.truth, 125).astype(np.uint8)
        assert found[part]["error"] == pytest.approx(f1_error(truth, made.saliency))
    means = table["mean_per_frame"][part]
    for name in ("roc_auc", "average_precision", "best_f1", "f1"):
        mean = np.mean([found[part][name] for found in table["per_frame"]])
        assert means[name] == pytest.approx(mean)
    errors = [found[part]["error"] for found in table["per_frame"]]
    assert means["overall_error"] == pytest.approx(np.mean(errors))
    assert table["overall_error"] == table["mean_per_frame"]["all"]["overall_error"]
    assert table["n_frames"] == 4


def test_without_teacher_and_depth_only_the_whole_is_scored(frames) -> None:
    scores = MapScores()
    scores.add("0", frames[0].saliency, frames[0].truth)
    assert scores.ranking().roc_auc is not None
    for part in PARTS[1:]:
        pooled = scores.table()["pooled"][part]
        assert (pooled["n_salient_px"], pooled["n_not_salient_px"]) == (0, 0)
        assert pooled["roc_auc"] is pooled["best_f1"] is pooled["f1"] is None


def test_without_true_distances_the_sensor_tells_what_is_beyond(frames) -> None:
    made, scores = frames[0], MapScores()
    scores.add("0", made.saliency, made.truth, depth=made.depth)
    pooled = scores.table()["pooled"]
    beyond = made.truth[np.nan_to_num(made.depth) > 4.0]
    assert pooled["beyond_range"]["n_salient_px"] == (beyond == 255).sum()
    assert pooled["missing"]["n_salient_px"] == 0


def test_what_has_no_meaning_is_none_and_left_out_of_means(frames) -> None:
    scores = scores_of(frames[:1])
    alone = scores.table()
    bare = np.where(frames[1].truth == 255, 0, frames[1].truth).astype(np.uint8)
    scores.add("bare", frames[1].saliency, bare)
    found = scores.table()["per_frame"][1]["all"]
    assert found["roc_auc"] is found["average_precision"] is found["best_f1"] is None
    assert found["f1"] is found["error"] is None
    assert scores.table()["overall_error"] == alone["overall_error"]
    assert scores.table()["mean_per_frame"] == alone["mean_per_frame"]
    scores.add("all salient", frames[1].saliency, np.full(SIZE, 255, np.uint8))
    found = scores.table()["per_frame"][2]["all"]
    assert found["roc_auc"] is None
    assert found["average_precision"] == 1


def test_frames_of_several_sizes_can_be_pooled() -> None:
    scores = MapScores()
    for height in (4, 8):
        truth = np.zeros((height, 6), np.uint8)
        truth[:2] = 255
        scores.add(str(height), (truth / 255).astype(np.float32), truth)
    ranking = scores.ranking()
    assert (ranking.roc_auc, ranking.f1) == (1, 1)
    assert (ranking.n_positive, ranking.n_negative) == (24, 48)


@pytest.mark.parametrize("n_frames", [0, 2])
def test_the_table_is_json(frames, n_frames: int) -> None:
    table = scores_of(frames[:n_frames]).table()
    assert json.loads(json.dumps(table, allow_nan=False)) == table
    assert (table["overall_error"] is None) == (n_frames == 0)
