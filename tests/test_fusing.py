"""What is remembered and what depth says now, as one map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.frame import Camera, Frame, Label
from curiosight.learner.fusing import LOG_ODDS, OF_PIECE, fuse
from curiosight.learner.learner import SaliencyLearner
from curiosight.metrics import f1_error
from curiosight.teacher import REASONS, Cluster, Segmentation, Verdict
from pictures import RedThings, make_learner, picture, taught

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)


def said(labels, pieces=None, clusters=()) -> Segmentation:
    """Return what a teacher says of labels and pieces."""
    labels = np.array(labels, np.uint8)
    numbers = np.zeros(labels.shape, np.uint16) if pieces is None else np.array(pieces, np.uint16)
    return Segmentation(labels, numbers, clusters)


def cluster(verdict: Verdict) -> Cluster:
    return Cluster(verdict, (0, 0, 1, 1), 1, (0.1, 0.1, 0.1), 1.0, 0.0)


def odds(probability):
    return np.log(probability / (1 - probability))


def test_every_weight_is_of_a_reason_of_the_teachers() -> None:
    assert LOG_ODDS.keys() <= set(REASONS.values())


def test_odds_are_multiplied_and_what_depth_does_not_show_stays_to_the_bit() -> None:
    remembered = np.array([[0.3, 0.3, 0.3, 0.999999]], np.float32)
    codes = [[Label.SALIENT, Label.NOT_SALIENT, Label.UNAVAILABLE, Label.UNAVAILABLE]]
    fused = fuse(remembered, said(codes))
    expected = odds(0.3) + np.array([LOG_ODDS["object"], LOG_ODDS["known"]])
    assert np.allclose(odds(fused[0, :2].astype(float)), expected, atol=1e-4)
    assert np.array_equal(fused[0, 2:], remembered[0, 2:])


def test_memory_is_asked_about_a_piece_as_a_whole() -> None:
    remembered = np.array([[0.9, 0.5, 0.4, 0.1]], np.float32)
    unknown = np.full((1, 4), Label.UNKNOWN)
    fused = fuse(remembered, said(unknown, [[1, 1, 1, 0]], (cluster(Verdict.CUT),)))
    mean = np.mean(odds(np.array([0.9, 0.5, 0.4])))
    drawn = (1 - OF_PIECE) * odds(np.array([0.9, 0.5, 0.4])) + OF_PIECE * mean
    expected = drawn + LOG_ODDS["touches the image border"]
    assert np.allclose(odds(fused[0, :3].astype(float)), expected, atol=1e-4)
    assert odds(float(fused[0, 3])) == pytest.approx(
        odds(0.1) + LOG_ODDS["in no cluster"], abs=1e-4
    )


def test_certain_memory_can_be_overruled() -> None:
    fused = fuse(np.array([[1.0, 0.0]], np.float32), said([[0, 255]]))
    assert 0.5 < fused[0, 0] < 0.99  # an object seen before, where depth says floor or wall
    assert 0.5 < fused[0, 1] < 0.99  # one that was brought in


def test_a_map_and_labels_of_two_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match="segmentation: expected"):
        fuse(np.zeros((2, 2), np.float32), said([[0, 255]]))


def with_depth(frame: Frame, camera: Camera = CAMERA) -> Frame:
    return replace(frame, depth=np.ones(frame.rgb.shape[:2], np.float32), camera=camera)


def test_with_the_depth_at_hand_a_map_is_better_where_it_is_seen() -> None:
    learner = taught(1)
    frame = picture(9)
    rgb = frame.rgb.copy()
    rgb[150:200, 20:60] = (30, 60, 200)  # a blue thing: nothing like it was seen
    labels = RedThings().segment(frame).labels
    labels[150:200, 20:60] = Label.SALIENT
    learner.teacher = SaysWhereDepthIs(labels)
    depth = np.full(labels.shape, 1.0, np.float32)
    fused = learner.maps(rgb, None, depth, CAMERA)
    assert f1_error(labels, fused.saliency) < f1_error(labels, learner.saliency(rgb)) - 0.05
    assert np.array_equal(fused.is_seen, (labels == 0) | (labels == 255))
    assert np.array_equal(learner.saliency(rgb, None, depth, CAMERA), fused.saliency)


class SaysWhereDepthIs:
    def __init__(self, labels) -> None:
        self.labels = labels

    def segment(self, frame: Frame) -> Segmentation:
        labels = np.where(np.isnan(frame.depth), Label.UNAVAILABLE, self.labels)
        return Segmentation.of_labels(labels.astype(np.uint8), frame.problem)


def test_where_depth_has_nothing_the_map_is_what_is_remembered() -> None:
    learner = taught()
    rgb = picture(7).rgb
    learner.teacher = SaysWhereDepthIs(np.full(rgb.shape[:2], 255, np.uint8))
    maps = learner.maps(rgb, None, np.full(rgb.shape[:2], np.nan, np.float32), CAMERA)
    assert np.array_equal(maps.probability, learner.maps(rgb).probability)
    assert not maps.is_seen.any()


def test_a_view_that_tells_nothing_leaves_what_is_remembered() -> None:
    learner = taught()
    remembered = learner.maps(picture(7).rgb)
    labels = np.full((240, 320), Label.UNKNOWN, np.uint8)
    assert learner.fused(remembered, Segmentation.of_labels(labels, "no support")) is remembered


def test_an_untrained_learner_says_what_depth_says() -> None:
    learner = make_learner()
    frame = picture(3)
    saliency = learner.saliency(frame.rgb, None, np.ones((240, 320), np.float32), CAMERA)
    assert np.array_equal(saliency > 0.5, RedThings().segment(frame).labels == Label.SALIENT)


def test_the_model_remembers_the_camera_of_what_it_learned_from(tmp_path) -> None:
    learner = make_learner()
    window = Camera(320, 240, 300.0, 301.0, 159.5, 119.5, (10, 10, 300, 200))
    for seed in range(2):
        learner.observe(with_depth(picture(seed), window))
    frame = picture(4)
    depth = np.ones((240, 320), np.float32)
    expected = learner.saliency(frame.rgb, None, depth)
    learner.save(tmp_path / "model.npz")
    teacher = Remembers()
    kept = SaliencyLearner.load(tmp_path / "model.npz", teacher)
    assert np.array_equal(kept.saliency(frame.rgb, None, depth), expected)
    assert teacher.camera == window
    with pytest.raises(ValueError, match="camera: expected one for 160x120"):
        kept.saliency(picture(size=(160, 120)).rgb, None, np.ones((120, 160), np.float32))
    with pytest.raises(ValueError, match="depth: expected"):
        kept.saliency(frame.rgb, None, depth[:100])
    with pytest.raises(ValueError, match="depth: expected a learner with a teacher"):
        SaliencyLearner.load(tmp_path / "model.npz").saliency(frame.rgb, None, depth)


class Remembers(RedThings):
    def segment(self, frame: Frame) -> Segmentation:
        self.camera = frame.camera
        return super().segment(frame)
