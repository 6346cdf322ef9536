"""Pictures show what they claim, and reach the disk whole and always the same."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from curiosight.errors import DataError
from curiosight.explorer import make_regions
from curiosight.explorer.progress import moving_mean
from curiosight.frame import Label
from curiosight.metrics import Scores
from curiosight.teacher import Cluster, Segmentation, Verdict
from curiosight.viewing.examples import Example, examples
from curiosight.viewing.figures import (
    learning_curve,
    reliability,
    roc,
    time_per_region,
    window_shares,
)
from curiosight.viewing.overlays import OUTLINE_COLOUR, overlay_labels, overlay_saliency
from curiosight.viewing.paper import HUES, new_figure, region_colours, save_figure, spread
from curiosight.viewing.region_map import regions_from_above
from room import poses_around

RGB = np.random.default_rng(0).integers(60, 200, (48, 64, 3), np.uint8)
NAMES = ("x0 y0 heading 0", "x0 y0 heading 1", "x0 y1 heading 0", "costs $1")


@dataclass(frozen=True)
class Row:
    """A step as the figures need it."""

    step: int
    region: int
    error: float | None
    overall_error: float | None


ROWS = [
    Row(step, step // 5 % 5 - 1, None if step % 3 else 0.5, 1 / (1 + step)) for step in range(40)
]


def segmentation() -> Segmentation:
    """Return 4 x 4 blocks of labels: an object top left, and each other label somewhere."""
    labels = np.full((48, 64), Label.NOT_SALIENT, np.uint8)
    labels[:24, :32], labels[:24, 32:], labels[24:, 32:] = (
        Label.SALIENT,
        Label.UNKNOWN,
        Label.UNAVAILABLE,
    )
    number = (labels == Label.SALIENT).astype(np.uint16)
    cluster = Cluster(Verdict.OBJECT, (0, 0, 32, 24), 768, (0.2, 0.2, 0.2), 1.0, 0.0)
    return Segmentation(labels, number, (cluster,))


def ranking(*, has_negatives: bool = True):
    scores = Scores()
    saliency = np.linspace(0, 1, 100, dtype=np.float32)
    scores.add(saliency, (saliency > 0.4) | (not has_negatives))
    return scores.ranking()


def example() -> Example:
    return Example("frame-$0_1$", RGB, segmentation(), np.linspace(0, 1, 768).reshape(24, 32))


def picture(path):
    """Read a figure as (H, W, 3) RGB."""
    image = cv2.imread(str(path))
    assert image is not None
    return image[..., ::-1]


def has_colour(image, colour, *, tolerance: int = 2) -> bool:
    return bool((np.abs(image.astype(int) - colour).max(axis=2) <= tolerance).any())


def hue(index: int) -> list[int]:
    return [round(255 * share) for share in matplotlib.colors.to_rgb(HUES[index])]


class TestOverlays:
    def test_labels_are_told_apart(self):
        before = RGB.copy()
        overlay = overlay_labels(RGB, segmentation())
        assert overlay.shape == RGB.shape
        assert overlay.dtype == np.uint8
        salient, unknown = overlay[4:20, 4:28], overlay[4:20, 36:60]
        other, unavailable = overlay[28:44, 4:28], overlay[28:44, 36:60]
        assert salient[..., 1].mean() > salient[..., (0, 2)].mean() + 20
        assert other[..., 2].mean() > other[..., 0].mean() + 30
        assert unavailable.mean() < other.mean() < unknown.mean()
        np.testing.assert_array_equal(RGB, before)

    def test_each_object_has_an_outline_of_two_pixels(self):
        overlay = overlay_labels(RGB, segmentation())
        is_outline = (overlay == OUTLINE_COLOUR).all(axis=2)
        expected = np.zeros(is_outline.shape, bool)
        expected[:24, :32] = True
        expected[:22, :30] = False  # the image's own edge is none of the object's
        np.testing.assert_array_equal(is_outline, expected)

    def test_unknown_is_hatched_and_nothing_else(self):
        grey = np.full_like(RGB, 120)
        overlay = overlay_labels(grey, segmentation())
        assert len(np.unique(overlay[:24, 32:].reshape(-1, 3), axis=0)) == 2
        assert len(np.unique(overlay[24:, :32].reshape(-1, 3), axis=0)) == 1

    def test_legend_is_a_strip_below(self):
        plain = overlay_labels(RGB, segmentation())
        explained = overlay_labels(RGB, segmentation(), has_legend=True)
        assert explained.shape[0] > plain.shape[0]
        np.testing.assert_array_equal(explained[: len(plain)], plain)

    def test_labels_of_another_size_are_refused(self):
        with pytest.raises(ValueError, match=r"segmentation: expected \(20, 64\)"):
            overlay_labels(RGB[:20], segmentation())

    def test_saliency_glows_on_grey(self):
        saliency = np.zeros((24, 32), np.float32)
        saliency[:, 16:] = 1
        overlay = overlay_saliency(RGB, saliency)
        assert overlay.shape == RGB.shape
        assert np.ptp(overlay[:, :28].astype(int), axis=2).max() == 0
        assert overlay[:, 36:].mean() > 2 * overlay[:, :28].mean()


class TestPaper:
    @given(st.lists(st.floats(0, 1), min_size=1, max_size=20), st.floats(0.001, 0.3))
    def test_spread_keeps_order_and_distance(self, positions, gap):
        positions.sort()
        moved = spread(positions, gap)
        least = min(gap, 1 / max(1, len(moved) - 1))
        assert (np.diff(moved) >= least - 1e-9).all()
        assert moved[0] >= -1e-9
        assert moved[-1] <= 1 + 1e-9

    def test_spread_leaves_what_is_apart(self):
        np.testing.assert_allclose(spread([0.1, 0.5, 0.9], 0.2), [0.1, 0.5, 0.9])

    @pytest.mark.parametrize(
        "names",
        [
            [f"x{x} y{y} heading {h}" for x in (0, 1) for y in (0, 1) for h in range(4)],
            [f"slice {number}" for number in range(5)],
            [f"room {number} view 0" for number in range(30)],
            ["kitchen"],
        ],
    )
    def test_regions_have_colours_of_their_own(self, names):
        colours = region_colours(names)
        assert len(set(colours)) == len(names)
        assert all(0 <= channel <= 1 for colour in colours for channel in colour)

    def test_unwritable_place_is_a_data_error_and_leaves_nothing(self, tmp_path):
        (tmp_path / "taken.png").mkdir()
        with pytest.raises(DataError, match="cannot be written"):
            save_figure(new_figure(2, 2), tmp_path / "taken.png")
        with pytest.raises(DataError, match="cannot be written"):
            save_figure(new_figure(2, 2), tmp_path / "missing" / "figure.png")
        assert [path.name for path in tmp_path.iterdir()] == ["taken.png"]


class TestFigures:
    @given(st.lists(st.floats(0, 1), max_size=30), st.integers(1, 12))
    def test_moving_mean_is_that_of_a_loop(self, values, n_mean):
        expected = [np.mean(values[max(0, i - n_mean + 1) : i + 1]) for i in range(len(values))]
        np.testing.assert_allclose(moving_mean(np.array(values), n_mean), expected, atol=1e-12)

    @given(st.lists(st.integers(-1, 3), min_size=1, max_size=30), st.integers(1, 12))
    def test_window_shares_are_those_of_a_loop(self, regions, n_window):
        shares = window_shares(np.array(regions), 4, n_window)
        size = min(n_window, len(regions))
        for step in range(len(regions)):
            first = min(max(0, step - size // 2), len(regions) - size)
            window = regions[first : first + size]
            expected = [window.count(region) / size for region in range(4)]
            np.testing.assert_allclose(shares[:, step], expected)

    def test_learning_curve_draws_what_there_is(self, tmp_path):
        learning_curve(ROWS, tmp_path / "both.png")
        assert has_colour(picture(tmp_path / "both.png"), hue(0))
        untested = [Row(row.step, 0, row.error, None) for row in ROWS]
        learning_curve(untested, tmp_path / "steps.png")
        assert not has_colour(picture(tmp_path / "steps.png"), hue(0))
        learning_curve([Row(0, 0, None, None)], tmp_path / "nothing.png")
        assert picture(tmp_path / "nothing.png").std() > 0

    def test_time_per_region_shows_each_region(self, tmp_path):
        time_per_region(ROWS, NAMES, tmp_path / "time.png", n_window=10)
        image = picture(tmp_path / "time.png")
        for colour in region_colours(NAMES):
            assert has_colour(image, [round(255 * channel) for channel in colour])

    def test_roc_shows_curves_and_survives_one_class(self, tmp_path):
        rankings = {"all": ranking(), "only salient": ranking(has_negatives=False)}
        roc(rankings, tmp_path / "roc.png")
        assert has_colour(picture(tmp_path / "roc.png"), hue(0))

    def test_reliability_shows_a_curve_each(self, tmp_path):
        curves = {"learned": np.array([[0.1, 0.0], [0.9, 1.0]]), "fused": np.array([[0.5, 0.5]])}
        reliability(curves, tmp_path / "reliability.png")
        for place in range(2):
            assert has_colour(picture(tmp_path / "reliability.png"), hue(place))
        with pytest.raises(ValueError, match="curves"):
            reliability({}, tmp_path / "none.png")

    def test_examples_shows_the_images(self, tmp_path):
        examples([example(), example()], tmp_path / "examples.png")
        image = picture(tmp_path / "examples.png")
        assert image.shape[0] < 1.2 * image.shape[1]
        assert has_colour(image, OUTLINE_COLOUR)

    @pytest.mark.parametrize("n_posed", [0, 1, 18])
    def test_regions_are_drawn_with_and_without_poses(self, tmp_path, n_posed):
        poses = [*poses_around(n_posed), *[None] * (20 - n_posed)]
        regions = make_regions("pose:2x1x2" if n_posed else "time:4", poses, [""] * 20)
        path = tmp_path / "map.png"
        regions_from_above(poses, regions, [0, 5, 5, 19, 2], path)
        assert has_colour(picture(path), np.round(255 * np.array(region_colours(regions.names)[0])))

    def test_regions_of_other_views_are_refused(self, tmp_path):
        regions = make_regions("time:2", [None] * 4, list("abcd"))
        with pytest.raises(ValueError, match="poses: expected one for each of 4 views, got 3"):
            regions_from_above([None] * 3, regions, [], tmp_path / "map.png")

    @pytest.mark.parametrize(
        "draw",
        [
            lambda path: learning_curve([], path),
            lambda path: time_per_region([], NAMES, path),
            lambda path: examples([], path),
            lambda path: roc({}, path),
        ],
    )
    def test_nothing_to_draw_is_refused(self, tmp_path, draw):
        with pytest.raises(ValueError, match="expected at least one"):
            draw(tmp_path / "figure.png")
        assert list(tmp_path.iterdir()) == []

    def test_same_run_gives_same_bytes_whatever_the_users_settings(self, tmp_path):
        learning_curve(ROWS, tmp_path / "a.png")
        with matplotlib.rc_context({"font.size": 20, "axes.edgecolor": "red"}):
            learning_curve(ROWS, tmp_path / "b.png")
            assert matplotlib.rcParams["font.size"] == 20
        assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_names_of_any_characters_are_drawn_without_a_word(tmp_path, recwarn):
    figure = new_figure(2, 2)
    axes = figure.subplots()
    title = axes.set_title("a\x1b[31m\x07 \u202e\nsecond line")
    axes.set_xlabel("日本語")
    save_figure(figure, tmp_path / "one.png")
    assert title.get_text() == "a\\x1b[31m\\x07 \\u202e\nsecond line"
    assert len(recwarn) == 0
