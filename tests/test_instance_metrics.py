"""Overlap, Boundary and F@0.75 of instances: hand-worked cases, and a slow plain reference."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from curiosight.evaluation import instance_table, score_instances
from curiosight.evaluation.instances import outline

Numbers = npt.NDArray[np.int32]


def image(*boxes: tuple[int, int, int, int], size: tuple[int, int] = (40, 60)) -> Numbers:
    """Return objects numbered from 1; boxes: v, u, height, width."""
    numbers = np.zeros(size, np.int32)
    for number, (v, u, height, width) in enumerate(boxes, start=1):
        numbers[v : v + height, u : u + width] = number
    return numbers


def test_overlap_counts_pixels_of_matches_over_pixels_of_all() -> None:
    truth = image((0, 0, 10, 10), (20, 0, 10, 10))
    predicted = image((0, 0, 10, 8), (20, 0, 10, 20), (35, 50, 2, 10))
    score = score_instances(predicted, truth)
    # 80 + 100 pixels shared; 80 + 200 + 20 predicted; 100 + 100 true.
    assert score.overlap.precision == 180 / 300
    assert score.overlap.recall == 180 / 200
    assert score.overlap.f == pytest.approx(2 * 180 / (300 + 200))
    # F is 160 / 180 for the first, 200 / 300 for the second.
    assert (score.n_true, score.n_predicted, score.n_detected) == (2, 3, 1)
    assert score.detected == 0.5


def test_one_prediction_over_two_objects_finds_the_larger() -> None:
    truth = image((0, 0, 10, 10), (0, 10, 10, 30))
    merged = image((0, 0, 10, 40))
    score = score_instances(merged, truth)
    assert score.overlap.precision == score.overlap.recall == 300 / 400
    assert score.n_detected == 1  # F = 600 / 700


def test_of_an_object_in_pieces_one_piece_counts() -> None:
    pieces = image((0, 0, 10, 30), (0, 30, 10, 10))
    score = score_instances(pieces, image((0, 0, 10, 40)))
    assert score.overlap.precision == score.overlap.recall == 300 / 400


def test_matches_maximise_the_sum_and_not_each_f() -> None:
    truth = image((0, 0, 1, 20), (0, 20, 1, 24))
    predicted = image((0, 6, 1, 26), (0, 0, 1, 6))
    # The first has the best F with the first, 28 / 46, but nothing is left for the other then.
    score = score_instances(predicted, truth)
    assert score.overlap.precision == (12 + 6) / 32


def test_f_of_exactly_three_quarters_is_detected() -> None:
    truth = image((0, 0, 1, 8))
    assert score_instances(image((0, 2, 1, 8)), truth).n_detected == 1  # F = 12 / 16
    assert score_instances(image((0, 3, 1, 8)), truth).n_detected == 0


def test_outline_is_the_outermost_pixels_without_holes() -> None:
    ring = np.zeros((7, 8), np.bool_)
    ring[1:6, 1:6] = True
    ring[3, 3] = False
    expected = ring.copy()
    expected[2:5, 2:5] = False
    np.testing.assert_array_equal(outline(ring), expected)


def test_outline_runs_along_the_edge_of_the_image() -> None:
    expected = np.ones((4, 5), np.bool_)
    expected[1:3, 1:4] = False
    np.testing.assert_array_equal(outline(np.ones((4, 5), np.bool_)), expected)


def test_boundaries_match_within_the_tolerance() -> None:
    # 0.003 of the diagonal of 800 is 2.4: 3 pixels.
    truth = image((100, 100, 60, 60), size=(480, 640))
    near = score_instances(image((103, 100, 60, 60), size=(480, 640)), truth)
    assert near.boundary.precision == near.boundary.recall == 1
    far = score_instances(image((104, 100, 60, 60), size=(480, 640)), truth)
    # Of 4 · 60 - 4 pixels: the sides but for one end each, and 3 at both ends of one more line.
    assert far.boundary.precision == far.boundary.recall == (2 * 59 + 6) / 236


def test_boundary_counts_outlines_without_a_match() -> None:
    truth = image((5, 5, 10, 10), (25, 5, 10, 10))
    score = score_instances(image((5, 5, 10, 10)), truth)
    assert score.boundary.precision == 1
    assert score.boundary.recall == 0.5


@pytest.mark.parametrize(
    ("predicted", "truth", "precision", "recall", "f", "detected"),
    [
        (image(), image((0, 0, 5, 5)), 1, 0, 0, 0),
        (image((0, 0, 5, 5)), image(), 0, 1, 0, 0),
        (image(), image(), 1, 1, 1, 1),
    ],
    ids=["nothing predicted", "nothing there", "nothing at all"],
)
def test_empty_images(
    predicted: Numbers, truth: Numbers, precision: int, recall: int, f: int, detected: int
) -> None:
    score = score_instances(predicted, truth)
    for agreement in (score.overlap, score.boundary):
        assert (agreement.precision, agreement.recall, agreement.f) == (precision, recall, f)
    assert score.detected == detected


def test_ignored_pixels_do_not_count() -> None:
    truth = image((0, 0, 10, 10))
    truth[:, 10:30] = -1
    score = score_instances(image((0, 0, 10, 20), (30, 12, 5, 5)), truth)
    assert score.overlap.f == 1
    assert (score.n_true, score.n_predicted) == (1, 1)


def test_numbers_need_not_be_consecutive() -> None:
    truth = image((0, 0, 10, 10), (20, 0, 10, 10))
    score = score_instances(np.where(truth > 0, 900 - truth * 7, 0), truth)
    assert score.overlap.f == score.boundary.f == score.detected == 1


def test_table_means_over_images() -> None:
    truth = image((0, 0, 10, 10))
    scores = [score_instances(truth, truth), score_instances(image(), truth)]
    table = instance_table(scores)
    assert table is not None
    assert table["overlap_f"] == table["boundary_recall"] == table["detected"] == 0.5
    assert table["overlap_precision"] == 1
    assert (table["n_true"], table["n_predicted"], table["n_detected"]) == (2, 1, 1)
    assert instance_table([]) is None


def test_images_of_two_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"predicted: expected \(40, 60\) like the truth"):
        score_instances(image(size=(4, 6)), image())


def reference(predicted: Numbers, truth: Numbers, radius: float) -> dict[str, Any]:
    """Score as the definition reads: all assignments tried, all distances measured."""

    def objects(numbers: Numbers) -> list[npt.NDArray[np.bool_]]:
        return [numbers == number for number in sorted({*numbers.ravel().tolist()} - {0})]

    def line(mask: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
        padded = np.pad(mask, 1)
        background, _ = ndimage.label(~padded)  # 4-connected
        beyond = ndimage.binary_dilation(background == background[0, 0])
        return [(int(v), int(u)) for v, u in np.argwhere(padded & beyond)]

    def near(ours: list[tuple[int, int]], other: list[tuple[int, int]]) -> int:
        return sum(any(np.hypot(v - y, u - x) <= radius for y, x in other) for v, u in ours)

    def f(p: npt.NDArray[np.bool_], t: npt.NDArray[np.bool_]) -> float:
        return float(2 * (p & t).sum() / (p.sum() + t.sum()))

    ps, ts = objects(predicted), objects(truth)
    few, many = sorted((ps, ts), key=len)
    best = max(
        (list(zip(few, chosen, strict=True)) for chosen in permutations(many, len(few))),
        key=lambda pairs: sum(f(a, b) for a, b in pairs),
    )
    pairs = [pair for pair in best if (pair[0] & pair[1]).any()]
    pairs = pairs if few is ps else [(p, t) for t, p in pairs]
    return {
        "shared": sum(int((p & t).sum()) for p, t in pairs),
        "boundary": (
            sum(near(line(p), line(t)) for p, t in pairs) / sum(map(len, map(line, ps))),
            sum(near(line(t), line(p)) for p, t in pairs) / sum(map(len, map(line, ts))),
        ),
        "n_detected": sum(f(p, t) >= 0.75 for p, t in pairs),
        "is_tied": _is_tied(few, many, f),
    }


def _is_tied(few: list[Any], many: list[Any], f: Any) -> bool:
    """Tell whether different assignments are as good: which is taken is left open."""
    sums = sorted(
        (
            sum(f(a, b) for a, b in zip(few, chosen, strict=True))
            for chosen in permutations(many, len(few))
        ),
        reverse=True,
    )
    return len(sums) > 1 and bool(np.isclose(sums[0], sums[1]))


NUMBERS = arrays(np.int32, (9, 12), elements=st.integers(0, 3))


@settings(max_examples=60, deadline=None)
@given(predicted=NUMBERS, truth=NUMBERS, tolerance=st.sampled_from([0.01, 0.1]))
def test_score_is_that_of_the_definition(
    predicted: Numbers, truth: Numbers, tolerance: float
) -> None:
    if not predicted.any() or not truth.any():
        return
    expected = reference(predicted, truth, np.ceil(tolerance * np.hypot(9, 12)))
    if expected["is_tied"]:
        return
    score = score_instances(predicted, truth, tolerance=tolerance)
    assert score.overlap.precision == pytest.approx(expected["shared"] / (predicted > 0).sum())
    assert score.overlap.recall == pytest.approx(expected["shared"] / (truth > 0).sum())
    assert (score.boundary.precision, score.boundary.recall) == pytest.approx(expected["boundary"])
    assert score.n_detected == expected["n_detected"]
