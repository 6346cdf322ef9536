"""What the paper says of its figures, decided by made-up numbers whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.evaluation import MethodScores, ObjectTruth
from curiosight.experiments.contest.table import Curve
from curiosight.experiments.paper_figures.claims import (
    Claim,
    claims_of_errors,
    claims_of_evolution,
    claims_of_time,
)
from curiosight.experiments.paper_figures.evolution import LateThing, Snapshot, Target
from curiosight.frame import Frame

N_LOOKS = 8


def curve(errors: np.ndarray) -> Curve:
    return Curve(errors, np.arange(1.0, 1 + len(errors)), np.zeros(len(errors)))


def falling(start: float, end: float, *, spread: float) -> list[Curve]:
    """Curves of three seeds, so far apart, that fall on straight lines."""
    line = np.linspace(start, end, N_LOOKS)
    return [curve(line + shift) for shift in (-spread, 0, spread)]


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(0.1, 0.3, True), (-0.3, -0.1, False), (-0.1, 0.3, None), (None, None, True)],
)
def test_a_claim_holds_where_its_whole_interval_does(
    low: float | None, high: float | None, expected: bool | None
) -> None:
    assert Claim(6, "", 0.2, low, high, "3 seeds").holds is expected


def test_errors_as_in_the_paper_give_yes_to_all() -> None:
    curves = {
        "chronological": falling(0.95, 0.215, spread=0.005),
        "random": falling(0.7, 0.22, spread=0.015),
        "iac": falling(0.6, 0.21, spread=0.005),
    }
    claims = claims_of_errors(curves, 0.2, 0.6, seed=0)
    assert [claim.holds for claim in claims] == [True] * 6
    faster, steadier = claims[-2:]
    assert faster.value == pytest.approx(0.055)
    assert faster.low == pytest.approx(0.055 - 0.01, abs=2e-3)
    assert steadier.value == pytest.approx(2 / 3)


def test_errors_the_other_way_round_give_no() -> None:
    curves = {
        "chronological": falling(0.5, 0.15, spread=0.001),
        "random": falling(0.7, 0.3, spread=0.001),
        "iac": falling(0.9, 0.5, spread=0.01),
    }
    claims = claims_of_errors(curves, 0.2, 0.3, seed=0)
    assert [claim.holds for claim in claims] == [False] * 6


def test_two_seeds_do_not_tell_how_much_seeds_differ() -> None:
    curves = {name: falling(0.9, 0.3, spread=0.1) for name in ("chronological", "random", "iac")}
    n_claims = [
        len(claims_of_errors({name: one[:n] for name, one in curves.items()}, 0.2, 0.6, seed=0))
        for n in (2, 3)
    ]
    assert n_claims == [5, 6]


def settling(fall_after: float, end: float) -> list[Curve]:
    """Curves of three seeds, 1200 looks long: flat, and lower by so much after look 1000."""
    errors = np.where(np.arange(1, 1201) <= 1000, end + fall_after, end)
    return [curve(errors + shift) for shift in (-1e-3, 0, 1e-3)]


def test_1000_looks_suffice_where_little_is_gained_after_them() -> None:
    curves = {
        "chronological": settling(0.0, 0.2),
        "random": settling(0.002, 0.22),
        "iac": settling(0.1, 0.2),
    }
    claims = claims_of_errors(curves, 0.2, None, seed=0)[-4:]
    assert [claim.claim.split(",")[0] for claim in claims] == ["random"] * 2 + ["iac"] * 2
    assert [claim.holds for claim in claims] == [True, True, False, False]
    reached, later = claims[:2]
    assert reached.value == pytest.approx(0.778 / 0.8 - 0.95)
    assert later.value == pytest.approx(0.01 - 0.002)


def test_time_that_moves_is_told_from_time_that_does_not() -> None:
    still, moving = np.full((2, 10), 0.5), np.repeat([[0.0], [1.0]], 10, axis=1)
    moving[:, 5:] = moving[::-1, 5:]
    (claim,) = claims_of_time({"random": [still] * 3, "iac": [moving] * 3}, seed=0)
    assert claim.value == pytest.approx(0.5)
    assert claim.holds is True
    (claim,) = claims_of_time({"random": [moving] * 3, "iac": [still] * 3}, seed=0)
    assert claim.holds is False


@pytest.mark.parametrize(("score", "expected"), [(0.75, True), (0.25, False)])
def test_thing_is_known_before_it_is_seen_where_its_score_is_high(
    score: float, expected: bool
) -> None:
    nothing = np.zeros((2, 2), np.uint8)
    frame = Frame("a", np.zeros((2, 2, 3), np.uint8), None, None, None)
    target = Target(frame, nothing, LateThing(nothing == 0, 3))
    saliency = np.zeros((2, 2), np.float32)
    shots = [
        Snapshot(looks, saliency, None, of_thing, 0.0)
        for looks, of_thing in ((1, 0.5), (2, score), (3, 0.5))
    ]
    (claim,) = claims_of_evolution(target, shots, 0.5)
    assert claim.holds is expected
    assert claim.value == pytest.approx(score - 0.5)


def test_gain_of_auc_is_the_difference_of_both_on_the_same_frames() -> None:
    truth = np.array([[0, 0, 255, 255]], np.uint8)
    right = np.array([[0.1, 0.2, 0.8, 0.9]], np.float32)
    half = np.array([[0.1, 0.8, 0.2, 0.9]], np.float32)  # 3 of 4 pairs in order
    first, second = MethodScores(), MethodScores()
    for id in ("a", "b", "c"):
        first.add(id, right, ObjectTruth(truth))
        second.add(id, half, ObjectTruth(truth))
    gain, interval = first.auc_gain(second, seed=0)
    assert gain == pytest.approx(0.25)
    assert interval == pytest.approx((0.25, 0.25))
