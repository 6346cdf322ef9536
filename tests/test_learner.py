"""The learner on small pictures that a detector of the test's own labels."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from curiosight.frame import Frame, Label
from curiosight.learner.description import Description, fit_labels
from curiosight.learner.experts import COMMON
from curiosight.learner.features import N_FEATURES, RowsPer
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.places import Places
from curiosight.metrics import f1_error
from curiosight.teacher import Segmentation, Teacher
from pictures import RedThings, make_learner, picture, taught

ROWS_PER = pytest.mark.parametrize("rows_per", get_args(RowsPer))


class Says:
    """Gives the same labels whatever it is shown."""

    def __init__(self, labels: npt.NDArray[np.generic]) -> None:
        self.labels = labels

    def segment(self, frame: Frame) -> Segmentation:
        return Segmentation(self.labels, np.zeros(self.labels.shape, np.uint16))


@ROWS_PER
def test_an_untrained_learner_sees_nothing_salient(rows_per: RowsPer) -> None:
    learner = make_learner(rows_per=rows_per)
    assert not learner.saliency(picture().rgb).any()
    observation = learner.observe(picture())
    assert not observation.saliency.any()
    assert observation.error == 1
    assert observation.change.trees == {COMMON: tuple(range(30))}


@ROWS_PER
def test_what_it_learns_it_finds_again(rows_per: RowsPer) -> None:
    learner = taught(rows_per=rows_per)
    frame = picture(9)
    labels = RedThings().segment(frame).labels
    assert f1_error(labels, learner.saliency(frame.rgb)) < 0.1


class Brighter:
    """Takes for salient what is much lighter than most of the image."""

    def segment(self, frame: Frame) -> Segmentation:
        red = frame.rgb[..., 0].astype(int)
        is_lighter = red > np.median(red) + 25
        return Segmentation.of_labels(np.where(is_lighter, 255, 0).astype(np.uint8))


def grey_picture(ground: int, seed: int) -> Frame:
    """Paint lighter rectangles on a grey, slightly noisy ground."""
    rng = np.random.default_rng(seed)
    rgb = np.full((240, 320, 3), ground, np.uint8)
    for v, u in rng.integers(0, [200, 270], (3, 2)):
        rgb[v : v + 40, u : u + 50] = ground + 50
    return Frame(str(seed), rgb + rng.integers(0, 12, rgb.shape).astype(np.uint8))


@ROWS_PER
@pytest.mark.parametrize("contrast", [False, True])
def test_contrast_is_found_again_at_a_brightness_never_seen(
    rows_per: RowsPer, contrast: bool
) -> None:
    learner = make_learner(rows_per=rows_per, contrast=contrast)
    learner.teacher = Brighter()
    for seed, ground in enumerate((20, 60, 100, 120, 150, 190)):
        learner.observe(grey_picture(ground, seed))
    frame = grey_picture(80, 80)
    error = f1_error(Brighter().segment(frame).labels, learner.saliency(frame.rgb))
    assert error < 0.1 if contrast else error > 0.5


@ROWS_PER
def test_scores_and_error_are_from_before_learning(rows_per: RowsPer) -> None:
    learner, twin = taught(2, rows_per=rows_per), taught(2, rows_per=rows_per)
    frame = picture(7)
    before = twin.predict(twin.describe(frame.rgb))
    observation = learner.observe(frame)
    after = learner.predict(observation.description)
    assert np.array_equal(observation.scores, before)
    assert not np.array_equal(observation.scores, after)
    labels = fit_labels(observation.segmentation.labels, observation.description)
    assert observation.error == f1_error(labels, observation.saliency)


def test_a_frame_without_any_object_has_no_error_and_still_teaches() -> None:
    learner = make_learner()
    bare = learner.observe(picture(0, n_things=0))
    assert (bare.error, bare.change.n_regrown) == (None, 0)
    assert learner.forest.n_samples == 700
    assert not learner.forest.is_salient.any()
    assert not learner.saliency(picture(1).rgb).any()
    learner.observe(picture(1))
    bare = learner.observe(picture(2, n_things=0))
    assert bare.error is None
    assert bare.change.n_regrown == 4
    assert learner.forest.n_samples == 2100


@pytest.mark.parametrize("teacher", [RedThings(), Teacher()])
def test_a_frame_with_a_problem_teaches_nothing(teacher: RedThings | Teacher) -> None:
    learner = taught()
    learner.teacher = teacher
    n_samples, before = learner.forest.n_samples, learner.saliency(picture(5).rgb)
    damaged = Frame("damaged", np.zeros((240, 320, 3), np.uint8), problem="truncated")
    observation = learner.observe(damaged)
    assert (observation.error, observation.change.n_regrown) == (None, 0)
    assert observation.segmentation.problem == "truncated"
    assert learner.forest.n_samples == n_samples
    assert np.array_equal(learner.saliency(picture(5).rgb), before)


def test_exactly_the_four_trees_it_names_change() -> None:
    learner = taught()
    rows = learner.describe(picture(8).rgb).rows
    before = learner.forest.votes(rows)
    regrown = list(learner.observe(picture(3)).change.trees[COMMON])
    has_changed = (learner.forest.votes(rows) != before).any(axis=0)
    assert len(set(regrown)) == 4
    assert has_changed[regrown].any()
    assert not np.delete(has_changed, regrown).any()


@pytest.mark.parametrize(("n_labelled", "n_learned"), [(0, 0), (1, 1), (40, 40), (3000, 700)])
def test_at_most_n_pixels_of_a_frame_are_learned(n_labelled: int, n_learned: int) -> None:
    labels = np.full(240 * 320, Label.UNKNOWN, np.uint8)
    labels[:n_labelled] = Label.NOT_SALIENT
    learner = make_learner()
    learner.teacher = Says(labels.reshape(240, 320))
    learner.observe(picture())
    assert learner.forest.n_samples == n_learned


def test_samples_carry_their_spot() -> None:
    learner = make_learner(n_pixels=50)
    for seed, spot in ((8, 7), (0, 2), (8, 7)):
        frame = picture(seed)
        description = learner.describe(frame.rgb)
        labels = fit_labels(RedThings().segment(frame).labels, description)
        learner.learn(description, labels, spot)
    assert learner.forest.groups.tolist() == 50 * [7] + 50 * [2] + 50 * [7]


LABEL_VALUES = st.sampled_from([*Label, 3])


@given(
    labels=arrays.arrays(np.uint8, (6, 9), elements=LABEL_VALUES),
    row_of_pixel=arrays.arrays(np.int32, (6, 9), elements=st.integers(0, 10)),
    seed=st.integers(0, 9),
)
@settings(max_examples=60, deadline=None)
def test_only_labelled_pixels_are_drawn_each_once(labels, row_of_pixel, seed) -> None:
    rows = np.repeat(np.arange(11, dtype=np.uint8)[:, None], N_FEATURES, axis=1)
    description = Description(rows, row_of_pixel)
    drawn, is_salient = make_learner(seed, n_pixels=20).sample(description, labels)
    salient, other = description.count(labels)
    assert len(drawn) == len(is_salient) == min(20, salient.sum() + other.sum())
    for of_class, available in ((is_salient, salient), (~is_salient, other)):
        n_drawn = np.bincount(drawn[of_class, 0], minlength=11)
        assert (n_drawn <= available).all()


@pytest.mark.parametrize("size", [(640, 480), (320, 240), (160, 120), (333, 500)])
def test_fitted_labels_are_never_blended(size: tuple[int, int]) -> None:
    """Between 255 and 0 lie the codes of what is unknown."""
    width, height = size
    labels = np.random.default_rng(0).choice([*Label], (height, width)).astype(np.uint8)
    fitted = fit_labels(labels, make_learner().describe(picture(size=size).rgb))
    v = np.arange(fitted.shape[0]) * height // fitted.shape[0]
    u = np.arange(fitted.shape[1]) * width // fitted.shape[1]
    assert np.array_equal(fitted, labels[np.ix_(v, u)])


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"rows_per": "line"}, "rows_per: expected 'pixel' or 'superpixel', got 'line'"),
        ({"colour_space": "hsv"}, "colour_space: expected 'rgb' or 'lab', got 'hsv'"),
        ({"n_pixels": 0}, "n_pixels: expected 1 or more, got 0"),
        ({"n_superpixels": 0}, "n_superpixels: expected 1 or more, got 0"),
        ({"forest": Forest(n_features=3)}, "forest: expected 39 features, got 3"),
        (
            {"forest": Forest(n_features=39), "contrast": True},
            "forest: expected 54 features, got 39",
        ),
    ],
)
def test_bad_settings_are_named(options, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        SaliencyLearner(**options)


@pytest.mark.parametrize("labels", [np.zeros((120, 160), np.uint8), np.zeros((240, 320), np.int64)])
def test_labels_of_another_shape_or_kind_are_refused(labels) -> None:
    learner = make_learner()
    learner.teacher = Says(labels)
    with pytest.raises(ValueError, match=r"labels: expected \(240, 320\) uint8, got"):
        learner.observe(picture())


@pytest.mark.parametrize("share", [0.0, 0.1])
def test_where_depth_is_blind_a_share_is_taken_for_not_salient(share: float) -> None:
    learner = SaliencyLearner(rows_per="pixel", n_pixels=100, blind_share=share)
    description = learner.describe(np.random.default_rng(0).integers(0, 255, (240, 320, 3), "u1"))
    labels = np.full(description.row_of_pixel.shape, Label.UNAVAILABLE, np.uint8)
    labels[:100] = Label.SALIENT
    rows, is_salient = learner.sample(description, labels)
    assert len(rows) == 100
    assert np.count_nonzero(~is_salient) == 100 * share
    labels[:100] = Label.UNKNOWN
    assert len(learner.sample(description, labels)[0]) == 0  # nothing is known of this frame


@pytest.mark.parametrize("is_shared", [True, False])
def test_another_learner_that_is_taught_the_same_is_the_same(
    is_shared: bool, tmp_path: Path
) -> None:
    """By what was drawn of frames alone, without seeing them: to the byte, and so is chance."""
    learners = []
    for _ in range(2):
        forest = None
        if not is_shared:
            forest = Forest(n_features=N_FEATURES, n_trees=8, max_samples=2500, seed=5)
        learners.append(
            make_learner(seed=1, forest=forest, places=Places(), is_calibrated=True, n_pixels=500)
        )
    seeing, told = learners
    for number in range(12):
        observation = seeing.observe(picture(number))
        assert told.learn_again(observation.taught) == observation.change
    for name, learner in zip("ab", learners, strict=True):
        learner.save(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert np.array_equal(seeing.saliency(picture(20).rgb), told.saliency(picture(20).rgb))
    assert seeing.rng.random() == told.rng.random()
    assert seeing.forest.rng.random() == told.forest.rng.random()
