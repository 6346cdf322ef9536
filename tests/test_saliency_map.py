"""From an image to its rows of features, and from their scores to the map."""

from __future__ import annotations

from typing import get_args

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.learner.edges import EdgeFilter
from curiosight.learner.features import RowsPer
from curiosight.learner.learner import SaliencyLearner
from pictures import RED, make_learner, picture, taught

ROWS_PER = pytest.mark.parametrize("rows_per", get_args(RowsPer))


def enlarged(small: npt.NDArray[np.float32], width: int, height: int) -> npt.NDArray[np.float64]:
    """Interpolate linearly between the middles of pixels, one line of code an axis."""
    v = (np.arange(height) + 0.5) * small.shape[0] / height - 0.5
    u = (np.arange(width) + 0.5) * small.shape[1] / width - 0.5
    rows = np.array([np.interp(v, np.arange(small.shape[0]), column) for column in small.T]).T
    return np.array([np.interp(u, np.arange(small.shape[1]), row) for row in rows])


@ROWS_PER
@pytest.mark.parametrize("size", [(320, 240), (640, 480), (160, 120), (333, 500), (300, 40)])
def test_a_map_is_the_rows_scores_painted_and_enlarged(rows_per: RowsPer, size) -> None:
    learner = taught(rows_per=rows_per)
    rgb = picture(4, size=size).rgb
    before = rgb.copy()
    saliency = learner.saliency(rgb)
    description = learner.describe(rgb)
    small = learner.predict(description)[description.row_of_pixel]
    assert saliency.shape == rgb.shape[:2]
    assert saliency.dtype == np.float32
    assert np.allclose(saliency, enlarged(small, *size), atol=1e-5)
    assert np.array_equal(rgb, before)


@ROWS_PER
@pytest.mark.parametrize("colour_space", ["rgb", "lab"])
def test_features_are_colours_of_the_space_that_was_asked_for(rows_per, colour_space) -> None:
    rgb = np.full((240, 320, 3), RED, np.uint8)
    lab = cv2.cvtColor(rgb[:1, :1], cv2.COLOR_RGB2LAB)[0, 0]
    learner = SaliencyLearner(rows_per=rows_per, colour_space=colour_space)
    rows = learner.describe(rgb).rows
    assert (rows == np.tile(RED if colour_space == "rgb" else lab, 13)).all()


def test_superpixels_have_far_fewer_rows_than_pixels() -> None:
    rgb = picture().rgb
    n_rows = {
        rows_per: len(make_learner(rows_per=rows_per).describe(rgb).rows)
        for rows_per in get_args(RowsPer)
    }
    assert n_rows["superpixel"] < 1000 < 10 * n_rows["superpixel"] < n_rows["pixel"]


def test_describing_leaves_no_trace() -> None:
    learner = make_learner()
    first = learner.describe(picture(0).rgb)
    rows, row_of_pixel = first.rows.copy(), first.row_of_pixel.copy()
    learner.describe(picture(1).rgb)
    learner.describe(picture(2, size=(200, 200)).rgb)
    again = learner.describe(picture(0).rgb)
    for description in (first, again):
        assert np.array_equal(description.rows, rows)
        assert np.array_equal(description.row_of_pixel, row_of_pixel)


def test_a_mirror_image_has_nearly_the_mirrored_map() -> None:
    """Nearly: SEEDS starts at the upper left."""
    learner = taught(6)
    rgb = picture(8).rgb
    mirrored = learner.saliency(np.ascontiguousarray(rgb[:, ::-1]))[:, ::-1]
    assert np.abs(mirrored - learner.saliency(rgb)).mean() < 0.05


@pytest.mark.parametrize(
    "rgb",
    [
        np.zeros((240, 320), np.uint8),
        np.zeros((240, 320, 4), np.uint8),
        np.zeros((240, 320, 3), np.float32),
    ],
)
def test_what_is_no_rgb_image_is_refused(rgb) -> None:
    with pytest.raises(ValueError, match=r"rgb: expected \(H, W, 3\) uint8, got"):
        make_learner().saliency(rgb)


def test_maps_that_follow_edges_are_even_inside_and_sharp_between() -> None:
    rng = np.random.default_rng(0)
    rgb = np.full((60, 80, 3), 50, np.uint8)
    rgb[:, 40:] = 200
    noisy = np.where(np.arange(80) < 40, 0.2, 0.8) + rng.normal(0, 0.1, (60, 80))
    followed = EdgeFilter(rgb)(noisy.astype(np.float32))
    assert followed.dtype == np.float32
    left, right = followed[:, :39], followed[:, 41:]
    assert left.std() < 0.03
    assert right.mean() - left.mean() == pytest.approx(0.6, abs=0.03)
    assert followed[:, 38].mean() < 0.3 < 0.7 < followed[:, 41].mean()
    assert followed.min() >= 0
    assert followed.max() <= 1
