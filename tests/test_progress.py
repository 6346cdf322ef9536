"""Learning progress and the chances it gives (eq. 1-3)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from curiosight.explorer.progress import ProgressMeter, choice_probabilities, learning_progress

errors_lists = st.lists(st.floats(0, 1), min_size=2, max_size=60)
progress_lists = st.lists(st.none() | st.floats(-1, 1), min_size=1, max_size=20)


@given(errors_lists, st.integers(2, 20))
def test_progress_is_minus_the_slope_of_a_fitted_line(errors: list[float], theta: int) -> None:
    window = errors[-theta:]
    slope = np.polyfit(np.arange(len(window)), window, 1)[0]
    assert learning_progress(errors, theta=theta) == pytest.approx(-slope, abs=1e-9)


@given(errors_lists, st.integers(2, 20), st.integers(1, 30))
def test_smoothing_takes_the_mean_of_the_last_errors(
    errors: list[float], theta: int, smoothing: int
) -> None:
    smooth = [np.mean(errors[max(0, end - smoothing) : end]) for end in range(1, len(errors) + 1)]
    expected = learning_progress(smooth, theta=theta)
    found = learning_progress(errors, theta=theta, smoothing=smoothing)
    assert found == pytest.approx(expected, abs=1e-9)


@given(st.lists(st.floats(0, 1), max_size=30), st.lists(st.floats(0, 1), min_size=15, max_size=15))
def test_progress_does_not_depend_on_when_it_is_measured(
    earlier: list[float], last: list[float]
) -> None:
    assert learning_progress(earlier + last) == pytest.approx(learning_progress(last), abs=1e-12)


def test_falling_errors_are_progress_although_the_print_fits_no_intercept() -> None:
    assert learning_progress([0.9, 0.8, 0.7]) == pytest.approx(0.1)
    assert learning_progress([0.7, 0.8, 0.9]) == pytest.approx(-0.1)


def test_window_of_the_printed_sum_is_one_longer() -> None:
    errors = [1.0] + [0.0] * 15
    assert learning_progress(errors, theta=15) == 0
    assert learning_progress(errors, theta=16) == pytest.approx(
        -np.polyfit(range(16), errors, 1)[0]
    )


def test_progress_is_unknown_before_enough_errors() -> None:
    assert learning_progress([]) is None
    assert learning_progress([0.5]) is None
    assert learning_progress([0.5, 0.4], min_errors=3) is None
    assert learning_progress([0.5, 0.4, 0.3], min_errors=3) == pytest.approx(0.1)


@given(progress_lists, st.floats(0, 1), st.sampled_from(["clip", "abs", "shift"]))
def test_chances_sum_to_one_and_never_fall_below_the_random_share(
    progress: list[float | None], random_share: float, negative: str
) -> None:
    chances = choice_probabilities(progress, random_share=random_share, negative=negative)
    assert chances.sum() == pytest.approx(1)
    assert chances.min() >= random_share / len(progress) - 1e-12


@given(progress_lists, st.randoms(use_true_random=False))
def test_permuting_regions_permutes_their_chances(progress: list[float | None], random) -> None:
    order = random.sample(range(len(progress)), len(progress))
    permuted = choice_probabilities([progress[index] for index in order])
    np.testing.assert_allclose(permuted, choice_probabilities(progress)[order], atol=1e-12)


def test_chances_are_three_quarters_by_progress() -> None:
    np.testing.assert_allclose(
        choice_probabilities([0.03, 0.01, 0.0, 0.0]), np.array([9, 3, 0, 0]) / 16 + 1 / 16
    )


@pytest.mark.parametrize(
    ("negative", "weights"), [("clip", (2, 0, 0)), ("abs", (2, 1, 3)), ("shift", (5, 2, 0))]
)
def test_growing_errors_by_option(negative: str, weights: tuple[int, ...]) -> None:
    chances = choice_probabilities([0.2, -0.1, -0.3], random_share=0, negative=negative)
    np.testing.assert_allclose(chances, np.array(weights) / sum(weights))


def test_exponent_sharpens_the_choice() -> None:
    chances = choice_probabilities([0.2, 0.1], random_share=0, exponent=3)
    np.testing.assert_allclose(chances, [8 / 9, 1 / 9])


def test_unknown_progress_counts_as_the_best() -> None:
    np.testing.assert_allclose(
        choice_probabilities([None, 0.1, 0.2], random_share=0), [0.4, 0.2, 0.4]
    )


@pytest.mark.parametrize("progress", [[None, None], [0.0, 0.0], [-0.1, -0.2], [1e-17, 0.0]])
def test_nothing_of_interest_means_equal_chances(progress: list[float | None]) -> None:
    np.testing.assert_array_equal(choice_probabilities(progress), [0.5, 0.5])


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"random_share": 1.5}, "random_share"),
        ({"exponent": -1}, "exponent"),
        ({"negative": "drop"}, "negative"),
    ],
)
def test_bad_chances_are_named(options: dict, name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        choice_probabilities([0.1], **options)


def test_no_regions_have_no_chances() -> None:
    with pytest.raises(ValueError, match="progress: expected"):
        choice_probabilities([])


def test_meter_keeps_regions_apart() -> None:
    meter = ProgressMeter()
    for step in range(4):
        meter.add(3, 1 - 0.1 * step)
        meter.add(5, 0.5)
    assert meter.progress(3) == pytest.approx(0.1)
    assert meter.progress(5) == pytest.approx(0, abs=1e-12)
    assert meter.progress(4) is None
    assert (meter.n_visits(3), meter.n_visits(4)) == (4, 0)


def test_undefined_error_counts_the_visit_only_by_option() -> None:
    meter = ProgressMeter(undefined="skip")
    for error in (0.9, None, 0.7, None):
        meter.add(0, error)
    assert meter.n_visits(0) == 4
    assert meter.progress(0) == pytest.approx(0.2)


def test_undefined_error_repeats_the_last() -> None:
    meter = ProgressMeter()
    for error in (None, 0.9, 0.7, None):
        meter.add(0, error)
    assert meter.progress(0) == learning_progress([0.9, 0.7, 0.7])


def test_region_that_never_shows_an_error_stops_being_promising() -> None:
    meter = ProgressMeter(theta=5)
    for _ in range(4):
        meter.add(0, None)
    assert meter.progress(0) is None
    meter.add(0, None)
    assert meter.progress(0) == 0


@pytest.mark.parametrize(
    "options", [{"theta": 1}, {"smoothing": 0}, {"min_errors": 1}, {"undefined": "zero"}]
)
def test_bad_meter_options_are_named(options: dict) -> None:
    with pytest.raises(ValueError, match=f"^{next(iter(options))}: expected"):
        ProgressMeter(**options)
