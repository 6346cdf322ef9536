"""The set `itti`: 42 maps of Itti, Koch and Niebur, averaged over superpixels."""

from __future__ import annotations

import numpy as np

from curiosight.learner.features import make_sets

(ITTI,) = make_sets("itti", "lab")


def halves() -> np.ndarray:
    """Two superpixels, left and right."""
    superpixels = np.zeros((240, 320), np.int32)
    superpixels[:, 160:] = 1
    return superpixels


def largest(image: np.ndarray) -> dict[str, int]:
    """Return the highest value of each channel's six maps on either half."""
    rows = ITTI(image, halves())
    found: dict[str, int] = {}
    for name, value in zip(ITTI.columns, rows.max(axis=0).tolist(), strict=True):
        channel = name.rpartition(" ")[0]
        found[channel] = max(found.get(channel, 0), value)
    return found


def test_there_are_seven_channels_of_six_maps() -> None:
    assert len(ITTI.columns) == 42
    assert ITTI.columns[0] == "intensity 2-5"
    assert ITTI.columns[-1] == "orientation 135 4-8"
    assert ITTI.colour_space == "rgb"


def test_an_even_image_has_no_contrast() -> None:
    assert not ITTI(np.full((240, 320, 3), (90, 40, 160), np.uint8), halves()).any()


def test_each_channel_tells_its_own_kind() -> None:
    v, u = np.mgrid[:240, :320]
    spot = (v - 120) ** 2 + (u - 80) ** 2 < 30**2
    light = np.where(spot[..., None], 200, 60).astype(np.uint8).repeat(3, axis=2)
    found = largest(light)
    assert found["intensity"] > 10
    assert found["red-green"] == found["blue-yellow"] == 0
    red = np.full((240, 320, 3), 80, np.uint8)
    red[spot] = (200, 20, 20)
    blue = np.full((240, 320, 3), 80, np.uint8)
    blue[spot] = (20, 20, 200)
    assert largest(red)["red-green"] > 2 * largest(red)["blue-yellow"]
    assert largest(blue)["blue-yellow"] > 2 * largest(blue)["red-green"]


def test_stripes_speak_to_their_orientation() -> None:
    """Upright and level stripes four pixels wide, of which the left half of the image is full."""
    stripes = np.full((240, 320, 3), 100, np.uint8)
    stripes[:, :160][:, (np.arange(160) // 2) % 2 == 0] = 160
    found = largest(stripes)
    assert found["orientation 0"] > 3 * found["orientation 90"]
    level = np.full((240, 320, 3), 100, np.uint8)
    level[(np.arange(240) // 2) % 2 == 0, :160] = 160
    found = largest(level)
    assert found["orientation 90"] > 3 * found["orientation 0"]
