"""Tables and figures of a comparison say what was measured, and are the same each time."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from xml.etree import ElementTree

import cv2
import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import METHODS, OURS, RGB, RIVAL, UNSCORED, many_methods, truth, wall_row
from curiosight.errors import DataError
from curiosight.frame import Label
from curiosight.viewing.comparison import (
    COLUMNS,
    MethodResult,
    WallRow,
    confusion,
    draw_precision_recall,
    draw_roc,
    draw_wall,
    latex_table,
    markdown_table,
)
from curiosight.viewing.comparison.confusion import map_picture
from curiosight.viewing.comparison.curve_styles import is_crowded, styled, thinned_curve
from curiosight.viewing.comparison.standings import known_columns, ranked
from curiosight.viewing.comparison.wall import TILE_PX, blocks, folded, mosaic, tiles
from curiosight.viewing.paper import HUES
from curiosight.viewing.truth import IGNORED, truth_picture

COLUMN_OF = {column.key: column for column in COLUMNS}


def cells_of(table: str) -> dict[str, list[str]]:
    """Return the cells of a Markdown table by the first of each line."""
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()]
    return {first: others for first, *others in lines}


class TestContent:
    def test_unknown_columns_are_refused(self):
        with pytest.raises(ValueError, match="figures: expected keys of COLUMNS, got 'auc'"):
            MethodResult("bms", figures={"auc": 0.5})

    def test_numbers_must_be_finite(self):
        with pytest.raises(ValueError, match="figures: expected a finite number or None, got mae"):
            MethodResult("bms", figures={"mae": float("nan")})

    def test_curves_have_points(self):
        with pytest.raises(ValueError, match=r"roc: expected \(n, 2\), got \(3,\)"):
            MethodResult("bms", roc=np.zeros(3))

    def test_truth_is_as_large_as_its_image(self):
        with pytest.raises(ValueError, match=r"truth: expected \(48, 64\) like the image"):
            WallRow("7", RGB, truth()[1:], {})


class TestStandings:
    def test_best_comes_first_and_what_has_no_figure_last(self):
        assert [method.name for method in ranked(METHODS)] == ["ours (default)", "bms", "blank"]
        by_error = ranked(METHODS, "mae")
        assert [method.name for method in by_error] == ["bms", "ours (default)", "blank"]

    def test_equals_keep_their_order(self):
        equals = [replace(RIVAL, name=name) for name in "bca"]
        assert [method.name for method in ranked(equals)] == ["b", "c", "a"]

    def test_columns_without_any_figure_are_left_out(self):
        keys = [column.key for column in known_columns(METHODS)]
        assert keys == ["roc_auc", "f1", "weighted_f", "mae", "ms"]

    def test_ours_has_the_first_hue_and_the_best_others_the_next(self):
        drawn = styled([*many_methods(), replace(OURS, name="ours (paper)")])
        hues = {one.method.name: one.hue for one in drawn}
        assert hues["ours (default)"] == hues["ours (paper)"] == 0
        assert [hues[f"method-{i}"] for i in range(6)] == [1, 2, 3, 4, None, None]
        dashes = {one.method.name: one.dash for one in drawn}
        assert dashes["ours (default)"] != dashes["ours (paper)"]

    def test_corner_is_enlarged_where_the_best_crowd(self):
        assert is_crowded(styled(many_methods()))
        assert not is_crowded(styled([replace(RIVAL, figures={"roc_auc": 0.7})]))
        assert not is_crowded(styled([UNSCORED]))


class TestTables:
    def test_markdown_has_figures_the_best_bold_and_ours_marked(self):
        cells = cells_of(markdown_table(METHODS))
        assert next(iter(cells)) == "method"
        assert cells["method"] == ["AUC ↑", "F1 ↑", "wFβ ↑", "MAE ↓"], "times change, so no ms"
        ours = ["**0.933** [.912, .951]", "0.710", "**0.500**", "**0.120**"]
        assert cells["*ours (default)*"] == ours
        assert cells["bms"] == ["0.810", "**0.720**", "0.400", "**0.120**"], "equal as written"
        assert cells["blank"] == ["–", "0.100", "–", "0.300"]
        assert list(cells)[2:] == ["*ours (default)*", "bms", "blank"]

    def test_latex_underlines_the_second(self):
        lines = latex_table(METHODS).splitlines()
        rows = {line.split(" & ")[0]: line for line in lines if " & " in line}
        expected = r"\textbf{0.933} [.912, .951] & \underline{0.710} & \textbf{0.500}"
        assert rows[r"\emph{ours (default)}"].startswith(rf"\emph{{ours (default)}} & {expected}")
        assert rows["bms"] == (
            r"bms & \underline{0.810} & \textbf{0.720} & \underline{0.400} & \textbf{0.120} \\"
        )
        assert rows["blank"] == r"blank & -- & 0.100 & -- & \underline{0.300} \\"
        assert rows["Method"] == (
            r"Method & AUC $\uparrow$ & F1 $\uparrow$ & $F_\beta^{w}$ $\uparrow$ "
            r"& MAE $\downarrow$ \\"
        )
        assert r"\begin{tabular}{lcccc}" in lines

    @pytest.mark.parametrize(
        ("name", "latex", "markdown"),
        [
            ("a_b & 50%", r"a\_b \& 50\%", r"a\_b & 50%"),
            (r"~\x^{2}$#", r"\textasciitilde{}\textbackslash{}x\textasciicircum{}\{2\}\$\#", None),
            ("U²-Net | p", r"U\textsuperscript{2}-Net | p", r"U²-Net \| p"),
            ("two\nlines", "two lines", "two lines"),
            ("[1pt]", "{[}1pt]", r"\[1pt\]"),
        ],
    )
    def test_names_are_escaped(self, name, latex, markdown):
        named = [replace(RIVAL, name=name)]
        assert f"\n{latex} & " in latex_table(named)
        if markdown is not None:
            assert f"\n| {markdown} | " in markdown_table(named)

    @given(st.text(min_size=1))
    def test_a_name_never_breaks_a_markdown_row(self, name):
        lines = markdown_table([replace(RIVAL, name=name)]).split("\n")
        assert len(lines) == 4
        assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", lines[2])) == 6

    def test_no_methods_are_an_empty_table(self):
        assert markdown_table([]) == "| method |\n| :----- |\n"
        assert r"\begin{tabular}{l}" in latex_table([])

    def test_time_has_about_three_digits(self):
        (time,) = [column for column in COLUMNS if column.key == "ms"]
        assert RIVAL.figure(time) == 12.34
        assert OURS.figure(time) is None


class TestConfusion:
    def test_each_pixel_has_the_colour_of_its_outcome(self):
        rgb = np.full((2, 3, 3), 100, np.uint8)
        labels = np.array([[255, 255, 0], [0, 125, 125]], np.uint8)
        saliency = np.array([[0.9, 0.1, 0.8], [0.2, 0.9, 0.1]])
        expected = [
            [(30, 170, 128), (208, 135, 30), (170, 30, 114)],  # found, missed, false alarm
            [(100, 100, 100), IGNORED, IGNORED],
        ]
        np.testing.assert_array_equal(confusion(rgb, labels, saliency, 0.5), expected)

    def test_a_pixel_at_the_threshold_is_not_predicted(self):
        rgb = np.full((1, 1, 3), 100, np.uint8)
        labels = np.full((1, 1), Label.SALIENT, np.uint8)
        at = confusion(rgb, labels, np.full((1, 1), 0.5), 0.5)
        above = confusion(rgb, labels, np.full((1, 1), 0.5), 0.4)
        assert at[0, 0].tolist() == [208, 135, 30]
        assert above[0, 0].tolist() == [30, 170, 128]

    def test_ignored_pixels_are_hatched_and_nothing_else(self):
        grey = np.full_like(RGB, 120)
        picture = confusion(grey, truth(), np.zeros((12, 16)), 0.5)
        assert len(np.unique(picture[:, 50:].reshape(-1, 3), axis=0)) == 2
        assert len(np.unique(picture[:, :50].reshape(-1, 3), axis=0)) == 2

    def test_nothing_salient_leaves_false_alarms_only(self):
        labels = np.zeros(RGB.shape[:2], np.uint8)
        grey = np.full_like(RGB, 100)
        picture = confusion(grey, labels, np.ones((4, 4)), 0.5)
        assert (picture == (170, 30, 114)).all()

    def test_wrong_sizes_and_ranges_are_refused(self):
        with pytest.raises(ValueError, match=r"truth: expected \(48, 64\) like the image"):
            confusion(RGB, truth()[1:], np.zeros((4, 4)), 0.5)
        with pytest.raises(ValueError, match=r"saliency: expected \(h, w\) from 0 to 1"):
            confusion(RGB, truth(), np.full((4, 4), np.nan), 0.5)

    def test_truth_is_white_on_black(self):
        picture = truth_picture(truth())
        assert (picture[:, :20] == 255).all()
        assert (picture[:, 20:50] == 0).all()
        assert {tuple(pixel) for pixel in picture[:, 50:].reshape(-1, 3)} > {IGNORED}

    def test_maps_keep_their_range(self):
        assert (map_picture(np.full((3, 4), 0.2), (6, 8)) == 51).all()
        assert map_picture(np.ones((100, 100)), (6, 8)).shape == (6, 8, 3)


class TestWall:
    def test_tiles_are_image_truth_mistakes_and_maps(self):
        row = wall_row()
        shown = list(tiles(row, ["ours (default)", "bms"], has_mistakes=True))
        titles = ["image", "truth", "mistakes of ours (default)", "ours (default)", "bms"]
        assert [tile.title for tile in shown] == titles
        first = row.maps["ours (default)"]
        np.testing.assert_array_equal(shown[2].picture, confusion(RGB, row.truth, first, 0.5))
        assert {tile.picture.shape for tile in shown} == {RGB.shape}

    def test_a_map_that_is_missing_is_blank(self):
        (*_, mistakes, blank) = tiles(wall_row(("bms",)), ["gbvs"], has_mistakes=True)
        assert (mistakes.picture == 255).all()
        assert (blank.picture == 255).all()

    @pytest.mark.parametrize(("n_maps", "sizes"), [(0, [0]), (1, [1]), (9, [9]), (17, [8, 9])])
    def test_many_maps_are_dealt_out_in_order(self, n_maps, sizes):
        names = tuple(f"map {i}" for i in range(n_maps))
        dealt = blocks([wall_row(names)])
        assert [len(block) for block in dealt] == sizes
        assert [name for block in dealt for name in block] == list(names)

    def test_frames_of_different_sizes_lie_below_each_other(self):
        low = WallRow("low", RGB[:16], truth()[:16], wall_row().maps)
        made = mosaic([wall_row(), low], ["bms"], has_mistakes=False)
        assert made.picture.shape == (180 + 8 + 60, 3 * TILE_PX + 2 * 8, 3)
        assert made.captions == [("7", 90), ("low", 218)]
        assert made.titles == [("image", 120), ("truth", 368), ("bms", 616)]

    def test_titles_are_folded(self):
        assert folded("spectral-residual") == "spectral-\nresidual"
        assert folded("ours (default)") == "ours\n(default)"
        assert folded("bms-pami") == "bms-pami"
        assert folded("x" * 40) == "x" * 15 + "…"
        assert folded("") == ""


def picture(path):
    """Read a figure as (H, W, 3) RGB."""
    image = cv2.imread(str(path))
    assert image is not None
    return image[..., ::-1]


def n_pixels_of(image, hue: str) -> int:
    colour = [round(255 * share) for share in matplotlib.colors.to_rgb(hue)]
    return int((np.abs(image.astype(int) - colour).max(axis=2) <= 2).sum())


FIGURES = [
    (draw_roc, many_methods()),
    (draw_precision_recall, many_methods()),
    (draw_wall, [wall_row(), wall_row(caption="8")]),
]


class TestFigures:
    @pytest.mark.parametrize("ending", ["png", "svg"])
    @pytest.mark.parametrize(("draw", "shown"), FIGURES)
    def test_same_content_gives_same_bytes(self, draw, shown, ending, tmp_path):
        for name in "ab":
            draw(shown, tmp_path / f"{name}.{ending}")
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in "ab")
        assert first == second
        start = b"\x89PNG" if ending == "png" else b"<?xml"
        assert first.startswith(start)

    @pytest.mark.parametrize("draw", [draw_roc, draw_precision_recall])
    def test_ours_is_drawn_thickest_in_the_first_hue(self, draw, tmp_path):
        draw([*many_methods()], tmp_path / "curves.png")
        image = picture(tmp_path / "curves.png")
        assert n_pixels_of(image, HUES[0]) > n_pixels_of(image, HUES[1]) > 0

    @pytest.mark.parametrize("draw", [draw_roc, draw_precision_recall])
    def test_svg_is_sound_whatever_a_method_is_called(self, draw, tmp_path):
        draw([replace(RIVAL, name="$a_1 < <b>&é")], tmp_path / "curves.svg")
        drawn = (tmp_path / "curves.svg").read_bytes()
        assert ElementTree.parse(io.BytesIO(drawn)).getroot().tag.endswith("svg")
        assert re.search(rb"<dc:date>|Matplotlib v", drawn) is None

    @pytest.mark.parametrize("draw", [draw_roc, draw_precision_recall])
    @pytest.mark.parametrize("methods", [[], [UNSCORED]])
    def test_no_curves_are_empty_axes(self, draw, methods, tmp_path):
        draw(methods, tmp_path / "curves.png")
        assert picture(tmp_path / "curves.png").min() < 255

    def test_a_constant_map_is_a_dot(self, tmp_path):
        dot = replace(OURS, precision_recall=np.array([[1.0, 0.2]]))
        draw_precision_recall([replace(OURS, precision_recall=ROC_LESS)], tmp_path / "none.png")
        draw_precision_recall([dot], tmp_path / "dot.png")
        n_none = n_pixels_of(picture(tmp_path / "none.png"), HUES[0])
        assert n_pixels_of(picture(tmp_path / "dot.png"), HUES[0]) > n_none

    def test_wall_has_a_line_for_each_frame(self, tmp_path):
        heights = []
        for n_frames in (1, 2, 3):
            draw_wall([wall_row()] * n_frames, tmp_path / "wall.png")
            heights.append(picture(tmp_path / "wall.png").shape[0])
        assert heights[2] - heights[1] == pytest.approx(heights[1] - heights[0], abs=2)
        assert heights[1] > heights[0] + 100

    def test_twenty_columns_stay_within_a_page(self, tmp_path):
        names = tuple(f"method-{i}" for i in range(17))
        draw_wall([wall_row(names)], tmp_path / "wall.png")
        assert picture(tmp_path / "wall.png").shape[1] < 12 * 150

    def test_wall_without_frames_is_refused(self, tmp_path):
        with pytest.raises(ValueError, match="rows: expected at least one, got none"):
            draw_wall([], tmp_path / "wall.png")

    def test_unwritable_place_is_a_data_error(self, tmp_path):
        with pytest.raises(DataError, match="cannot be written"):
            draw_roc(METHODS, tmp_path / "missing" / "roc.svg")


ROC_LESS = np.empty((0, 2))


class TestThinning:
    def test_long_curves_keep_their_ends_and_their_shape(self):
        rates = np.linspace(0, 1, 20_000)
        curve = np.stack([rates, rates**0.05], axis=1)  # steep where points are few
        thinned = thinned_curve(curve)
        assert len(thinned) <= 502
        np.testing.assert_array_equal(thinned[[0, -1]], curve[[0, -1]])
        again = np.interp(rates, *thinned.T)
        assert np.abs(again - curve[:, 1])[1:].max() < 0.01

    def test_short_curves_stay(self):
        np.testing.assert_array_equal(thinned_curve(OURS.roc), OURS.roc)
