"""How unsure a learner is: its trees contradict each other, or it has seen nothing like it."""

from __future__ import annotations

import numpy as np

from curiosight.learner.experts import Experts
from curiosight.learner.forest import Forest
from curiosight.learner.novelty import SeenRows, nearest_distances
from curiosight.learner.places import Places
from curiosight.learner.sight import Sight
from pictures import make_learner, picture, taught


def test_distances_are_to_the_nearest_row() -> None:
    rng = np.random.default_rng(0)
    rows, kept = rng.integers(0, 256, (30, 7), np.uint8), rng.integers(0, 256, (50, 7), np.uint8)
    weights = rng.random(7).astype(np.float32)
    apart = np.abs(rows[:, None].astype(float) - kept.astype(float)) * weights
    expected = apart.sum(axis=2).min(axis=1)
    assert np.allclose(nearest_distances(rows, kept, weights), expected, rtol=1e-5)
    assert (nearest_distances(kept, kept, weights) == 0).all()


def test_what_was_seen_is_not_new_and_what_was_not_is() -> None:
    rng = np.random.default_rng(1)
    seen = SeenRows(rng.integers(100, 120, (5000, 6), np.uint8))
    again = seen.novelty(rng.integers(100, 120, (500, 6), np.uint8))
    new = seen.novelty(rng.integers(180, 200, (500, 6), np.uint8))
    assert again.mean() < 0.2
    assert (new == 1).all()


def test_one_row_tells_nothing_and_two_equal_ones_are_no_failure() -> None:
    assert SeenRows.of([np.zeros((1, 3), np.uint8)]) is None
    seen = SeenRows.of([np.zeros((2, 3), np.uint8), np.zeros((0, 3), np.uint8)])
    assert seen is not None
    novelty = seen.novelty(np.array([[0, 0, 0], [200, 0, 0]], np.uint8))
    assert novelty.tolist() == [0, 1]


def test_disagreement_is_the_deviation_of_the_trees() -> None:
    rng = np.random.default_rng(2)
    rows = rng.integers(0, 256, (400, 5), np.uint8)
    forest = Forest(n_features=5, n_trees=10, max_depth=4, seed=0)
    experts = Experts(forest)
    assert not experts.disagreement(rows).any()  # untrained: all say no
    forest.fit(rows, rng.random(400) < 0.5)
    expected = forest.votes(rows).std(axis=1)
    assert np.allclose(experts.disagreement(rows), expected, atol=1e-4)
    assert experts.disagreement(rows).max() > 0.3


def test_experts_that_contradict_each_other_are_heard() -> None:
    rng = np.random.default_rng(3)
    rows = rng.integers(0, 256, (400, 5), np.uint8)
    bright = rows[:, 0] > 127
    common, of_place = Forest(n_features=5, seed=0), Forest(n_features=5, seed=1)
    common.fit(rows, bright)
    of_place.fit(rows, ~bright)
    experts = Experts(common, Places(2))
    experts.of_place = (of_place,)
    look = np.full(800, 9, np.uint8)
    experts.places.add(Sight(look))
    assert experts.chosen(Sight(look)) == {0: 1.0}
    alone = of_place.votes(rows).std(axis=1)
    assert np.median(experts.disagreement(rows, Sight(look))) > 0.4 > 0.2 > np.median(alone)


def test_a_new_thing_is_unlike_anything_seen_which_is_not_not_salient() -> None:
    learner = taught(4)
    rgb = picture(8).rgb
    rgb[160:210, 30:90] = (20, 220, 240)
    maps = learner.maps(rgb, with_uncertainty=True)
    is_new = np.zeros(rgb.shape[:2], np.bool_)
    is_new[165:205, 35:85] = True
    away = np.ones_like(is_new)
    away[140:230, 10:110] = False
    assert maps.uncertainty[is_new].min() > 0.9
    assert np.median(maps.uncertainty[away]) < 0.3
    assert 0 <= maps.uncertainty.min() <= maps.uncertainty.max() <= 1


def test_uncertainty_follows_what_is_learned_and_costs_nothing_unasked() -> None:
    learner = make_learner()
    rgb = picture(8).rgb
    assert (learner.maps(rgb, with_uncertainty=True).uncertainty == 1).all()
    learner.observe(picture(8))
    before = learner.maps(rgb, with_uncertainty=True).uncertainty
    assert before.mean() < 0.5
    blue = picture(8)
    blue.rgb[160:210, 30:90] = (20, 220, 240)
    unsure = learner.maps(blue.rgb, with_uncertainty=True).uncertainty[185, 60]
    learner.observe(blue)
    assert learner.maps(blue.rgb, with_uncertainty=True).uncertainty[185, 60] < unsure
    assert learner.maps(rgb).uncertainty is None
