"""BMS in its four versions, against the originals' maps and the method told plainly."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from curiosight.evaluation.baselines.bms import bms, bms_fixation, bms_rliac
from curiosight.evaluation.baselines.bms_pami import bms_pami
from curiosight.evaluation.baselines.boolean_maps import (
    add_maps,
    dilate,
    levels_of,
    maps_between,
    reach_of,
    thresholds_of,
)
from curiosight.evaluation.baselines.border_jumps import (
    draw_seeds,
    move_seeds,
    next_random,
    start_jumps,
)
from curiosight.evaluation.baselines.maps import Saliency, stretched
from curiosight.frame import Rgb
from golden_maps import IMAGES, assert_equals_golden, golden_input
from plain_bms import PlainRandom, border_seeds, plain_attention, surrounded

Method = Callable[[Rgb], Saliency]

VERSIONS: list[Method] = [bms, bms_fixation, bms_rliac, bms_pami]


@pytest.mark.parametrize("image", IMAGES)
@pytest.mark.parametrize(
    ("method", "program", "pearson", "levels"),
    [
        (bms, "bms2013_sod", 0.99999, 2),
        (partial(bms, has_jumping_border=False), "bms2013_sod0", 0.99999, 2),
        (partial(bms, is_smoothed=True), "bms2013_sod_post", 0.99999, 4),
        (bms_fixation, "bms2013_fix", 1 - 1e-9, 0),
        (bms_rliac, "bms_rliac_sod", 1 - 1e-9, 0),
        (bms_pami, "bms_pami_fix", 0.99999, 1),
    ],
    ids=["bms", "no jumps", "smoothed", "fixation", "rliac", "pami"],
)
def test_equals_the_original(
    method: Method, program: str, pearson: float, levels: int, image: str
) -> None:
    saliency = method(golden_input(image))
    assert_equals_golden(saliency, program, image, pearson=pearson, levels=levels)


def test_jumping_border_finds_a_frame() -> None:
    """Without jumps a drawn frame surrounds nothing less than the picture."""
    rgb = golden_input("synth_frame")
    maps = [bms(rgb, has_jumping_border=jumps).ravel() for jumps in (True, False)]
    assert np.corrcoef(maps)[0, 1] < 0.9


def textured(height: int, width: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    noise = rng.integers(0, 256, (height // 4, width // 4, 3), np.uint8)
    return cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC)


@pytest.mark.parametrize("seed", range(3))
def test_rliac_equals_plain_bms(seed: int) -> None:
    rgb = textured(72, 96, seed)
    random = PlainRandom()
    random.next()
    plain = plain_attention(rgb, n_closing=13, n_dilation=1, random=random, by_norm=False)
    assert np.array_equal(np.rint(bms_rliac(rgb) * 255), np.rint(255 * stretched(plain)))


def test_jumps_equal_plain_seeds() -> None:
    jumps, random = start_jumps(31, 47), PlainRandom()
    for _ in range(3):
        draw_seeds(jumps, 31, 47)
        v, u = np.divmod(jumps.seeds, 47 + 2)
        assert list(zip(v - 1, u - 1, strict=True)) == border_seeds(31, 47, random)
    assert int(jumps.random[0]) == random.state


def test_random_numbers_are_those_of_opencv() -> None:
    random, plain = np.array([0xFFFFFFFF], np.uint64), PlainRandom()
    numbers = [int(next_random(random)) for _ in range(1000)]
    assert numbers == [plain.next() for _ in range(1000)]
    assert numbers[0] == 0xFFFFFFFF * 4164903690 % 2**32


greys = arrays(
    np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 60)
)


@settings(max_examples=60, deadline=None)
@given(greys, st.booleans())
def test_all_maps_at_once_equal_one_after_another(grey: np.ndarray, has_jumps: bool) -> None:
    thresholds = thresholds_of(grey, 8)
    levels = levels_of(grey, thresholds)
    words = maps_between(*reach_of(levels, len(thresholds)))
    jumps, random = start_jumps(*grey.shape), PlainRandom()
    for k, threshold in enumerate(thresholds):
        seeds = border_seeds(*grey.shape, random if has_jumps else None)
        if has_jumps:
            move_seeds(words, levels, k, jumps)
        bits = (words[1:-1, 1:-1] >> np.uint64(k)) & np.uint64(1)
        assert np.array_equal(bits.astype(bool), surrounded(grey > threshold, seeds))


def test_many_jumps_equal_plain_bms() -> None:
    """A grey of many small components, where jumps miss and meet them."""
    grey = textured(64, 96, 3)[..., 0].copy()
    thresholds = thresholds_of(grey, 4)
    levels = levels_of(grey, thresholds)
    words = maps_between(*reach_of(levels, len(thresholds)))
    before = words.copy()
    jumps, random = start_jumps(*grey.shape), PlainRandom()
    for k, threshold in enumerate(thresholds):
        move_seeds(words, levels, k, jumps)
        bits = (words[1:-1, 1:-1] >> np.uint64(k)) & np.uint64(1)
        seeds = border_seeds(*grey.shape, random)
        assert np.array_equal(bits.astype(bool), surrounded(grey > threshold, seeds))
    cleared, added = before & ~words, words & ~before
    assert cleared.any()
    assert added.any()


@settings(max_examples=30, deadline=None)
@given(arrays(np.uint64, st.tuples(st.integers(1, 12), st.integers(1, 12))), st.integers(0, 4))
def test_dilation_of_words_equals_opencv(words: np.ndarray, reach: int) -> None:
    dilated = dilate(words, reach)
    element = np.ones((2 * reach + 1,) * 2, np.uint8)
    for k in (0, 17, 63):
        plain, bits = ((image >> np.uint64(k)) & np.uint64(1) for image in (words, dilated))
        assert np.array_equal(bits, cv2.dilate(plain.astype(np.uint8), element))


@pytest.mark.parametrize("by_norm", [True, False])
def test_maps_add_up(by_norm: bool) -> None:
    maps = np.random.default_rng(0).random((10, 5, 7)) < 0.3
    maps[4], maps[9] = False, True
    words = sum(one.astype(np.uint64) << np.uint64(7 * k) for k, one in enumerate(maps))
    total = np.ones((5, 7))
    add_maps(total, words, by_norm=by_norm)
    counts = np.maximum(maps.sum(axis=(1, 2)), 1)
    weights = 1 / np.sqrt(counts) if by_norm else (counts < 35).astype(float)
    assert total == pytest.approx(1 + np.tensordot(weights, maps, 1))


def test_thresholds_stay_below_the_maximum() -> None:
    assert thresholds_of(np.array([[3, 19]], np.uint8), 8).tolist() == [3, 11]
    assert thresholds_of(np.array([[5, 5]], np.uint8), 8).size == 0


@pytest.mark.parametrize("method", VERSIONS)
def test_a_disk_stands_out(method: Method) -> None:
    rgb = np.full((120, 160, 3), 90, np.uint8)
    cv2.circle(rgb, (90, 60), 20, (200, 40, 40), -1)
    saliency = method(rgb)
    assert saliency[60, 90] > 0.25
    assert saliency[5:20, 5:20].max() < 0.05


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="step: expected 4 to 255"):
        bms_pami(textured(8, 8), step=3)
    with pytest.raises(ValueError, match="rgb: expected sides of 16 to 1"):
        bms(np.zeros((400, 4, 3), np.uint8))
