"""The hues that things are known again by: the same in other light, other than those of others."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.catalogue.hues import (
    INTENSITIES,
    N_BANDS,
    N_BINS,
    N_HUES,
    count_hues,
    hue_distances,
    mean_hues,
)

RED, TEAL, PURPLE = (190, 60, 40), (40, 130, 130), (120, 40, 150)
WHOLE = np.ones((24, 20), np.bool_)


def painted(*colours: tuple[int, int, int], light: float = 1.0) -> np.ndarray:
    """Return an image of as many bands, from the top, in light of some brightness."""
    bands = np.repeat(np.array(colours, np.uint8), 24 // len(colours), axis=0)
    linear = INTENSITIES[bands] * light
    lit = np.searchsorted(INTENSITIES, linear).astype(np.uint8)
    return np.repeat(lit[:, None], 20, axis=1)


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the distance of the hues of two images."""
    hues = [[mean_hues([count_hues(image, WHOLE, None)])] for image in (one, other)]
    return float(hue_distances(*hues)[0, 0])


@pytest.mark.parametrize("colour", [RED, TEAL, PURPLE])
def test_brighter_light_is_no_other_hue(colour: tuple[int, int, int]) -> None:
    assert distance(painted(colour), painted(colour, light=0.5)) < 0.35
    others = {RED, TEAL, PURPLE} - {colour}
    assert min(distance(painted(colour), painted(other)) for other in others) > 0.9


def test_hues_are_counted_from_the_top_however_the_camera_is_turned() -> None:
    flag = painted(RED, TEAL, PURPLE)
    upright = count_hues(flag, WHOLE, np.array([0.0, -1.0, 0.0]))
    assert np.isclose(upright.sum(), WHOLE.sum())
    assert distance(flag, flag[::-1]) > 0.7
    assert (count_hues(flag, WHOLE, None) == upright).all()
    assert (count_hues(flag[::-1], WHOLE, np.array([0.0, 1.0, 0.0])) == upright).all()
    turned = np.ascontiguousarray(np.rot90(flag))
    left = count_hues(turned, np.rot90(WHOLE), np.array([-1.0, 0.0, 0.0]))
    assert (left == upright).all()
    from_above = count_hues(flag, WHOLE, np.array([0.0, 0.0, -1.0])).reshape(N_BANDS, -1)
    assert (from_above == from_above[0]).all()


def test_each_view_counts_the_same_however_near() -> None:
    near, far = (np.zeros(N_HUES, np.float32) for _ in range(2))
    near[3], far[5] = 900, 9
    shares = mean_hues([near, far])
    assert (shares[3], shares[5], shares.sum()) == (0.5, 0.5, 1.0)
    assert mean_hues([np.zeros(N_HUES, np.float32)]).sum() == 0


def test_what_is_black_or_white_or_of_one_channel_has_its_bins() -> None:
    for colour in [(0, 0, 0), (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)]:
        hues = count_hues(painted(colour), WHOLE, None).reshape(N_BANDS, N_BINS, N_BINS)
        assert np.isclose(hues.sum(), WHOLE.sum())
    assert distance(painted((0, 0, 0)), painted((255, 255, 255))) < 0.01
