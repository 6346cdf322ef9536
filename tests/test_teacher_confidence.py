"""How sure labels are: never of what is unknown, less near a threshold, less often right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation, Teacher
from scenes import ON_FLOOR, ON_TABLE, TABLE_TOP, WALL, kinect_noise, see

SCENE = (WALL, TABLE_TOP, ON_TABLE, ON_FLOOR)


Seen = tuple[Frame, Segmentation, npt.NDArray[np.float32]]


@pytest.fixture(scope="module")
def seen() -> Seen:
    """Return a noisy frame, what the teacher says of it, and how sure it is."""
    frame, _ = see(SCENE)
    assert frame.depth is not None
    frame = replace(frame, depth=kinect_noise(frame.depth, np.random.default_rng(2)))
    segmentation = Teacher().segment(frame)
    return frame, segmentation, Teacher().confidence(frame, segmentation)


def test_confidence_is_a_share_and_none_where_nothing_is_known(seen: Seen) -> None:
    _, segmentation, confidence = seen
    assert confidence.dtype == np.float32
    assert confidence.shape == segmentation.labels.shape
    assert confidence.min() >= 0
    assert confidence.max() <= 1
    is_known = np.isin(segmentation.labels, (Label.SALIENT, Label.NOT_SALIENT))
    assert (confidence[~is_known] == 0).all()
    assert np.median(confidence[is_known]) > 0.8


def test_foot_of_an_object_is_less_sure_than_its_top(seen: Seen) -> None:
    _, segmentation, confidence = seen
    assert segmentation.objects
    for number in range(1, len(segmentation.objects) + 1):
        is_object = segmentation.instances() == number
        rows = np.flatnonzero(is_object.any(axis=1))
        upper, lower = is_object.copy(), is_object.copy()
        upper[rows.mean().astype(int) :] = False
        lower[: rows[-1] - 4] = False
        assert confidence[lower].mean() < confidence[upper].mean()


def test_small_objects_are_less_sure(seen: Seen) -> None:
    frame, segmentation, confidence = seen
    small = tuple(replace(cluster, n_pixels=50) for cluster in segmentation.clusters)
    doubted = Teacher().confidence(frame, replace(segmentation, clusters=small))
    is_salient = segmentation.labels == Label.SALIENT
    assert (doubted[is_salient] < 0.3 * confidence[is_salient] + 1e-6).all()


def test_frame_that_tells_nothing_has_no_confidence() -> None:
    frame, _ = see(())
    blind = replace(frame, depth=np.full((480, 640), np.nan, np.float32))
    assert not Teacher().confidence(blind, Teacher().segment(blind)).any()
