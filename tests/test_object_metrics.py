"""The measures of salient-object detection: equal to PySODMetrics, and right by hand."""

from __future__ import annotations

import importlib.util
import json
import os
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.evaluation.object_metrics import ObjectScore, score_objects
from curiosight.evaluation.object_truth import ObjectTruth
from object_measures_peer import STORED, cases, drawn_truth, peer_score, random_case, summary

SIZE = (40, 60)
has_peer = importlib.util.find_spec("py_sod_metrics") is not None


def score(
    saliency: npt.NDArray[np.floating], truth: npt.NDArray[np.uint8], *, is_stretched: bool = True
) -> ObjectScore:
    return score_objects(saliency, ObjectTruth(truth), is_stretched=is_stretched)


def from_levels(levels: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    return levels.astype(np.float32) / np.float32(255)


def assert_same(mine: ObjectScore, other: ObjectScore, tolerance: float = 1e-12) -> None:
    for name, value in asdict(other).items():
        found = getattr(mine, name)
        assert (found is None) == (value is None), name
        if value is not None:
            np.testing.assert_allclose(found, value, rtol=0, atol=tolerance, err_msg=name)


@pytest.fixture
def truth() -> npt.NDArray[np.uint8]:
    return drawn_truth(SIZE)


@pytest.fixture
def saliency() -> npt.NDArray[np.float32]:
    noise = np.random.default_rng(3).random(SIZE).astype(np.float32)
    return 0.5 * noise + 0.4 * (drawn_truth(SIZE) == 255).astype(np.float32)


@pytest.mark.parametrize("mode", ["stretched", "as_is"])
def test_equal_to_what_pysodmetrics_gave(mode: str) -> None:
    stored = json.loads(STORED.read_text())[mode]
    assert stored.keys() == cases().keys()
    for name, (levels, truth) in cases().items():
        mine = score(from_levels(levels), truth, is_stretched=mode == "stretched")
        assert summary(asdict(mine)) == pytest.approx(stored[name], rel=0, abs=1e-6), name


@pytest.mark.skipif(not has_peer, reason="pysodmetrics is not installed")
@pytest.mark.parametrize("is_stretched", [True, False])
@pytest.mark.parametrize("seed", range(1000, 1040))
def test_whole_curves_equal_to_pysodmetrics(seed: int, is_stretched: bool) -> None:
    levels, truth = random_case(seed)
    theirs = ObjectScore(**peer_score(levels, truth, is_stretched=is_stretched))
    assert_same(score(from_levels(levels), truth, is_stretched=is_stretched), theirs, 1e-6)


@pytest.mark.skipif(not has_peer, reason="pysodmetrics is not installed")
@pytest.mark.skipif(
    "CURIOSIGHT_TEST_DATA" not in os.environ, reason="CURIOSIGHT_TEST_DATA is not set"
)
def test_equal_to_pysodmetrics_on_recordings() -> None:
    folder = Path(os.environ["CURIOSIGHT_TEST_DATA"]) / "data/osd_learn"
    paths = sorted((folder / "ground_truth").glob("*.png"))[::9]
    assert len(paths) == 5
    for path in paths:
        # The peer knows no ignored pixels: they are not salient here.
        is_salient = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) == 255
        truth = np.where(is_salient, 255, 0).astype(np.uint8)
        levels = cv2.imread(str(folder / "image_color" / path.name), cv2.IMREAD_GRAYSCALE)
        assert_same(
            score(from_levels(levels), truth), ObjectScore(**peer_score(levels, truth)), 1e-6
        )


def test_perfect_map_scores_one(truth) -> None:
    perfect = score((truth == 255).astype(np.float32), truth)
    assert perfect.mae == 0
    # The E-measure divides by one pixel less than there are.
    above_one = truth.size / (truth.size - 1)
    assert perfect.e_curve.max() == pytest.approx(above_one)
    assert perfect.e_adaptive == pytest.approx(above_one)
    for figure in (perfect.s_measure, perfect.weighted_f, perfect.f_adaptive):
        assert figure == pytest.approx(1)
    assert perfect.f_curve.max() == pytest.approx(1)


def test_inverted_map_scores_nothing(truth) -> None:
    inverted = score((truth == 0).astype(np.float32), truth)
    assert inverted.mae == 1
    assert inverted.s_measure == pytest.approx(0, abs=1e-12)
    assert inverted.weighted_f == pytest.approx(0, abs=1e-12)
    assert inverted.f_adaptive == 0
    assert inverted.e_adaptive == pytest.approx(0, abs=1e-12)
    # Only where every pixel is salient are there hits.
    assert inverted.f_curve.argmax() == 0
    assert np.all(inverted.f_curve[1:] == 0)


def test_values_counted_by_hand() -> None:
    truth = np.array([[255, 255, 0, 0]], np.uint8)
    found = score(from_levels(np.array([[255, 51, 102, 0]], np.uint8)), truth)
    assert found.mae == pytest.approx((0 + 0.8 + 0.4 + 0) / 4)
    # At 102 and more: 1 hit, 1 false alarm. Precision and recall 0.5 each.
    assert found.f_curve[102] == pytest.approx(0.5)
    # Above: precision 1, recall 0.5. Twice the mean of 0.4 is there too.
    assert found.f_curve[103] == pytest.approx(1.3 * 0.5 / (0.3 + 0.5))
    assert found.f_adaptive == pytest.approx(1.3 * 0.5 / (0.3 + 0.5))
    # Deviations at 102 from a mean of 0.5 each: two pixels agree (1), two oppose (0).
    assert found.e_curve[102] == pytest.approx(2 / 3)


def test_loop_over_thresholds_gives_the_same_curves(truth, saliency) -> None:
    curve = score(saliency, truth, is_stretched=False).f_curve
    levels, is_salient = np.rint(saliency * 255), truth == 255
    for level in (0, 31, 128, 200):
        # The programs cut off value * 255, where rounding may fall short of a whole number.
        is_above = np.floor(levels / 255 * 255) >= level
        precision = is_salient[is_above].mean()
        recall = is_above[is_salient].mean()
        expected = 1.3 * precision * recall / (0.3 * precision + recall)
        assert curve[level] == pytest.approx(expected)


@given(seed=st.integers(0, 10_000), is_stretched=st.booleans())
@settings(max_examples=30, deadline=None)
def test_ignored_pixels_count_nowhere(seed: int, is_stretched: bool) -> None:
    rng = np.random.default_rng(seed)
    truth = drawn_truth(SIZE)
    truth[rng.random(SIZE) < rng.uniform(0, 0.9)] = 125
    saliency = rng.uniform(0.2, 0.8, SIZE).astype(np.float32)
    changed = np.where(truth == 125, rng.random(SIZE), saliency).astype(np.float32)
    assert_same(
        score(changed, truth, is_stretched=is_stretched),
        score(saliency, truth, is_stretched=is_stretched),
    )


def test_ignored_frame_is_as_if_cut_off(truth, saliency) -> None:
    rng = np.random.default_rng(0)
    wide = rng.random((SIZE[0] + 30, SIZE[1] + 20)).astype(np.float32)
    ignored = np.full(wide.shape, 125, np.uint8)
    inside = (slice(10, 10 + SIZE[0]), slice(5, 5 + SIZE[1]))
    wide[inside], ignored[inside] = saliency, truth
    assert_same(score(wide, ignored), score(saliency, truth))


def test_any_other_label_is_ignored(truth, saliency) -> None:
    truth[5:9] = 125
    other = np.where(truth == 125, 75, truth).astype(np.uint8)
    assert_same(score(saliency, other), score(saliency, truth))


def test_ignored_outline_neither_helps_nor_hurts_an_even_object() -> None:
    truth = np.zeros(SIZE, np.uint8)
    truth[10:30, 10:40] = 255
    saliency = np.where(truth == 255, 0.6, 0).astype(np.float32)
    whole = score(saliency, truth, is_stretched=False)
    outlined = truth.copy()
    outlined[8:32, 8:42] = 125
    outlined[10:30, 10:40] = 255
    found = score(saliency, outlined, is_stretched=False)
    assert found.weighted_f == pytest.approx(whole.weighted_f, abs=1e-12)


def test_empty_truth(saliency) -> None:
    empty = score(saliency, np.zeros(SIZE, np.uint8), is_stretched=False)
    assert empty.weighted_f is empty.f_curve is empty.f_adaptive is None
    mean = (np.rint(saliency * 255) / 255).mean()
    assert empty.mae == pytest.approx(mean)
    assert empty.s_measure == pytest.approx(1 - mean)
    assert empty.e_curve[0] == 0
    assert 0 < empty.e_adaptive <= 1.001


def test_truth_that_is_all_salient(saliency) -> None:
    full = score(saliency, np.full(SIZE, 255, np.uint8), is_stretched=False)
    mean = (np.rint(saliency * 255) / 255).mean()
    assert full.mae == pytest.approx(1 - mean)
    assert full.s_measure == pytest.approx(mean)
    assert full.e_curve[0] == pytest.approx(saliency.size / (saliency.size - 1))
    assert full.f_curve[0] == pytest.approx(1)
    assert 0 < full.weighted_f < 1


@pytest.mark.parametrize("label", [75, 125])
def test_all_ignored_truth_says_nothing(saliency, label: int) -> None:
    nothing = score(saliency, np.full(SIZE, label, np.uint8))
    assert set(asdict(nothing).values()) == {None}


@pytest.mark.parametrize("label", [0, 255])
def test_one_known_pixel(label: int) -> None:
    found = score(np.full((1, 1), 0.25), np.full((1, 1), label, np.uint8))
    assert found.e_curve is found.e_adaptive is None
    assert found.mae == pytest.approx(abs(label / 255 - 64 / 255))
    assert found.s_measure == pytest.approx(1 - found.mae)


@pytest.mark.parametrize("value", [0.0, 0.3, 1.0])
def test_constant_map_is_not_stretched(truth, value: float) -> None:
    constant = score(np.full(SIZE, value), truth)
    share, exact = (truth == 255).mean(), np.rint(value * 255) / 255
    assert constant.mae == pytest.approx(share * (1 - exact) + (1 - share) * exact)
    # Twice the mean is above a constant, unless that is 0 or 1: then every pixel is salient.
    f_of_all = 1.3 * share / (0.3 * share + 1)
    assert constant.f_adaptive == pytest.approx(f_of_all if value in (0.0, 1.0) else 0)
    curves = np.concatenate([constant.f_curve, constant.e_curve])
    rest = [constant.s_measure, constant.weighted_f, constant.e_adaptive]
    assert np.isfinite([*curves, *rest]).all()


def test_even_quadrants_without_an_object_are_right() -> None:
    # Their similarity is 0 / 0, and rounding must not decide it.
    truth = np.zeros((9, 9), np.uint8)
    truth[4:, 4:] = 255
    truth[4, 4] = 0
    found = []
    for value in np.arange(1, 255) / 255:
        saliency = np.full((9, 9), value)
        saliency[6:, 6:] = 0
        found.append(score(saliency, truth, is_stretched=False).s_measure)
    # A quadrant that goes from 1 to 0 and back would show as jumps of more than 0.1.
    assert np.abs(np.diff(found)).max() < 0.02


def test_centroid_in_the_last_column_gives_a_number() -> None:
    truth = np.zeros(SIZE, np.uint8)
    truth[:, -1] = 255
    found = score((truth == 255).astype(np.float32), truth)
    assert found.s_measure == pytest.approx(1)


def test_a_map_of_another_size_is_refused(truth) -> None:
    with pytest.raises(ValueError, match=r"saliency: expected \(40, 60\) .* got \(20, 30\)"):
        score(np.zeros((20, 30)), truth)


@pytest.mark.parametrize(
    "levels", [np.zeros(SIZE, np.uint8), np.full(SIZE, 1.2), np.full(SIZE, -0.1)]
)
def test_maps_that_are_none_are_refused(truth, levels) -> None:
    with pytest.raises(ValueError, match=r"saliency: expected"):
        score(levels, truth)


def test_maps_with_a_hole_are_refused(truth, saliency) -> None:
    saliency[3, 4] = np.nan
    with pytest.raises(ValueError, match=r"saliency: expected numbers .* nan"):
        score(saliency, truth)


@pytest.mark.parametrize(
    "labels",
    [np.zeros((3, 3, 3), np.uint8), np.zeros((3, 3), bool), np.zeros((0, 4), np.uint8)],
)
def test_truths_that_are_none_are_refused(labels) -> None:
    with pytest.raises(ValueError, match=r"labels: expected \(H, W\) uint8"):
        ObjectTruth(labels)


def test_one_truth_serves_many_maps_and_nothing_is_changed(truth, saliency) -> None:
    shared, kept, labels = ObjectTruth(truth), saliency.copy(), truth.copy()
    first = score_objects(saliency, shared)
    score_objects(1 - saliency, shared)
    assert_same(score_objects(saliency, shared), first, 0)
    np.testing.assert_array_equal(saliency, kept)
    np.testing.assert_array_equal(truth, labels)
