"""The page of a comparison is sound, needs nothing else, and shows what was measured."""

from __future__ import annotations

import base64
import hashlib
import re
from dataclasses import replace
from xml.etree.ElementTree import Element

import cv2
import numpy as np
import pytest

from comparisons import METHODS, OURS, RIVAL, UNSCORED, comparison, many_methods, wall_row
from curiosight.errors import DataError
from curiosight.viewing.comparison import (
    ComparisonReport,
    comparison_html,
    confusion,
    write_comparison,
)
from reports import (
    HOSTILE,
    Page,
    assert_same_bytes_and_no_word,
    hostile_page,
    of_class,
    points_of,
    text_of,
)

SECTIONS = ["results", "curves", "wall", "problems", "limits", "making"]


def read(told: ComparisonReport) -> Element:
    return Page.read(comparison_html(told))


def rows_of(tree: Element) -> list[Element]:
    """Return the rows of the table of figures, without its head."""
    (table,) = of_class(tree, "methods")
    return list(table.find("tbody"))


def named_row(tree: Element, name: str) -> dict[str, Element]:
    """Return the cells of a method by the title of their column."""
    (table,) = of_class(tree, "methods")
    titles = [text_of(head)[:-2] for head in table.iter("th") if head.get("scope") == "col"][1:]
    (row,) = [row for row in rows_of(tree) if text_of(row[0]) == name]
    return dict(zip(titles, row[1:], strict=True))


class TestPage:
    def test_asks_for_nothing_from_outside(self):
        page = comparison_html(comparison())
        tree = Page.read(page)
        assert "://" not in page
        assert not re.search(r"url\(|@import|fetch|XMLHttp", page)
        loading = {"link", "iframe", "object", "embed", "base", "form", "a", "use"}
        assert not loading & {found.tag for found in tree.iter()}
        sources = [found.get("src", "") for found in tree.iter("img")]
        assert len(sources) == 5
        assert all(source.startswith("data:image/") for source in sources)
        for found in tree.iter():
            assert not {name for name in found.attrib if name.startswith(("on", "href", "xlink"))}

    def test_only_its_own_script_may_run(self):
        tree = read(comparison(HOSTILE))
        (script,) = tree.iter("script")
        digest = hashlib.sha256(text_of(script).encode()).digest()
        (policy,) = [
            meta.get("content", "") for meta in tree.iter("meta") if meta.get("http-equiv")
        ]
        assert policy.startswith("default-src 'none';")
        assert policy.endswith(f"script-src 'sha256-{base64.b64encode(digest).decode()}'")

    def test_sections_have_headings_in_order(self):
        tree = read(comparison())
        named = [section.get("aria-labelledby") for section in tree.iter("section")]
        assert named == SECTIONS
        assert [heading.get("id") for heading in tree.iter("h2")] == SECTIONS
        assert len(list(tree.iter("h1"))) == 1

    @pytest.mark.parametrize(
        ("left_out", "sections"),
        [
            ({"methods": ()}, {"results", "curves"}),
            ({"methods": [UNSCORED]}, {"curves"}),
            ({"wall": ()}, {"wall"}),
            ({"problems": (), "limits": ()}, {"problems", "limits"}),
            ({"facts": {}, "command": "", "files": {}}, {"making"}),
        ],
    )
    def test_what_is_not_known_is_left_out(self, left_out, sections):
        tree = read(replace(comparison(), **left_out))
        named = [section.get("aria-labelledby") for section in tree.iter("section")]
        assert named == [name for name in SECTIONS if name not in sections]

    def test_reliability_has_a_line_and_a_name_for_each_curve(self):
        curves = {"learned, error 0.030": np.array([[0.25, 0.5], [1.0, 1.0]])}
        tree = read(replace(comparison(), reliability=curves))
        (part,) = [
            found for found in tree.iter("section") if found.get("aria-labelledby") == "reliability"
        ]
        assert "learned, error 0.030" in text_of(part)
        (line,) = of_class(part, "line")
        assert line.get("d") == "M25 50L100 0"
        assert of_class(part, "diagonal")

    def test_every_picture_says_what_it_shows(self):
        tree = read(comparison())
        pictures = [*tree.iter("img"), *(s for s in tree.iter("svg") if s.get("role") == "img")]
        assert len(pictures) == 5 + 2
        assert all(picture.get("alt") or picture.get("aria-label") for picture in pictures)

    def test_names_are_text_whatever_is_in_them(self, tmp_path):
        write_comparison(comparison(HOSTILE), tmp_path / "report.html")
        tree, shown = hostile_page(tmp_path / "report.html", read(comparison()))
        assert shown in [text_of(row[0]) for row in rows_of(tree)]

    def test_same_report_gives_same_bytes_and_no_word(self, tmp_path, capfd):
        def write(path):
            write_comparison(comparison(), path)

        assert_same_bytes_and_no_word(write, tmp_path, capfd)

    def test_times_can_be_told_apart_from_what_lasts(self):
        slower = replace(comparison(), methods=[replace(RIVAL, ms=99.0), OURS])
        faster = replace(comparison(), methods=[replace(RIVAL, ms=1.0), OURS])
        pages = [comparison_html(told) for told in (slower, faster)]
        timeless = [re.sub(r"<(\w+) [^>]*class=\"measured\">.*?</\1>", "", page) for page in pages]
        assert pages[0] != pages[1]
        assert timeless[0] == timeless[1]

    def test_twenty_columns_of_noise_are_small_enough_to_send(self):
        rng = np.random.default_rng(0)
        row = replace(
            wall_row(),
            rgb=rng.integers(0, 256, (480, 640, 3), np.uint8),
            truth=np.zeros((480, 640), np.uint8),
            maps={f"method-{i}": rng.random((480, 640)) for i in range(17)},
        )
        told = replace(comparison(), wall=[row] * 6, methods=many_methods())
        assert len(comparison_html(told)) < 6_000_000

    def test_unwritable_place_is_a_data_error(self, tmp_path):
        with pytest.raises(DataError, match="cannot be written"):
            write_comparison(comparison(), tmp_path / "missing" / "report.html")


class TestTable:
    def test_has_a_row_for_each_method_the_best_first(self):
        tree = read(replace(comparison(), methods=METHODS))
        assert [text_of(row[0]) for row in rows_of(tree)] == ["ours (default)", "bms", "blank"]
        assert [row.get("class") for row in rows_of(tree)] == ["pick m0 ours", "pick m1", "pick m2"]

    def test_cells_hold_figures_and_mark_the_leaders(self):
        tree = read(replace(comparison(), methods=METHODS))
        ours, bms = named_row(tree, "ours (default)"), named_row(tree, "bms")
        assert text_of(ours["AUC"]) == "0.933[.912, .951]"
        assert ours["AUC"].get("data-value") == "0.9331"
        assert [cell.tag for cell in ours["AUC"]] == ["b", "small"]
        assert [cell.tag for cell in bms["AUC"]] == ["u"]
        assert [cell.tag for cell in bms["F1"]] == ["b"]
        assert ours["MAE"].get("title") == "95 % interval [.100, .200]"
        assert text_of(bms["ms"]) == "12.3"

    def test_what_is_missing_is_a_dash_that_cannot_be_sorted(self):
        blank = named_row(read(replace(comparison(), methods=METHODS)), "blank")
        assert text_of(blank["AUC"]) == text_of(blank["ms"]) == "–"
        assert "data-value" not in blank["AUC"].attrib

    def test_heads_explain_themselves_and_say_how_to_sort(self):
        tree = read(replace(comparison(), methods=METHODS))
        heads = [head for head in tree.iter("th") if head.get("scope") == "col"]
        assert [head.get("data-first") for head in heads] == [
            "ascending",
            *["descending"] * 3,
            *["ascending"] * 2,
        ]
        assert [text_of(head) for head in heads if head.get("aria-sort")] == ["AUC ↑"]
        assert heads[1].get("title", "").startswith("Area under the ROC curve")
        (notes,) = of_class(tree, "notes")
        assert [text_of(term) for term in notes.iter("dt")] == ["AUC", "F1", "wFβ", "MAE", "ms"]


class TestCurves:
    def test_lines_are_the_curves(self):
        tree = read(replace(comparison(), methods=[replace(OURS, figures={"roc_auc": 0.7})]))
        roc, precision_recall = of_class(tree, "line")
        np.testing.assert_allclose(points_of(roc.get("d")), [(0, 100), (10, 20), (100, 0)])
        expected = [(20, 0), (90, 30), (100, 70)]
        np.testing.assert_allclose(points_of(precision_recall.get("d")), expected, atol=0.006)

    def test_corner_is_shown_larger_where_good_curves_crowd(self):
        tree = read(replace(comparison(), methods=[OURS]))
        captions = [text_of(found) for found in tree.iter("figcaption")][:3]
        assert captions == ["ROC", "ROC, upper left corner", "Precision–recall"]
        corner = of_class(tree, "line")[1]
        np.testing.assert_allclose(points_of(corner.get("d"))[1], (50, 100))

    def test_ours_lies_above_all_and_all_are_named(self):
        methods = many_methods()
        tree = read(replace(comparison(), methods=methods))
        (first, *_) = of_class(tree, "inside")
        assert "ours" in list(first)[-1].get("class")
        assert {text_of(line) for line in first} == {method.name for method in methods}
        (key,) = of_class(tree, "lines")
        assert len(key) == len(methods)
        assert [text_of(item) for item in key][1:3] == ["method-1 0.940", "ours (default) 0.933"]

    def test_a_single_point_is_a_dot(self):
        dot = replace(OURS, roc=np.empty((0, 2)), precision_recall=np.array([[1.0, 0.25]]))
        (line,) = of_class(read(replace(comparison(), methods=[dot])), "line")
        assert line.get("d") == "M100 75h.01"


class TestWall:
    def test_pictures_are_those_of_the_frame(self):
        row = wall_row()
        tree = read(replace(comparison(), wall=[row]))
        (shown,) = of_class(tree, "tiles")
        assert [text_of(tile) for tile in shown] == [
            "image",
            "truth",
            "mistakes of ours (default)",
            "ours (default)",
            "bms",
        ]
        image, _, mistakes, *_ = (decoded(tile) for tile in shown.iter("img"))
        np.testing.assert_allclose(image.mean((0, 1)), row.rgb.mean((0, 1)), atol=3)
        expected = confusion(row.rgb, row.truth, row.maps["ours (default)"], row.threshold)
        assert np.abs(mistakes.astype(int) - expected).mean() < 12

    @pytest.mark.parametrize(("n_maps", "n_columns"), [(2, 5), (7, 10), (8, 6), (17, 10)])
    def test_lines_of_pictures_are_about_as_long(self, n_maps, n_columns):
        row = wall_row(tuple(f"map {i}" for i in range(n_maps)))
        (shown,) = of_class(read(replace(comparison(), wall=[row])), "tiles")
        assert len(shown) == n_maps + 3
        assert shown.get("style") == f"--columns:{n_columns}"

    def test_constant_maps_and_frames_without_objects_are_shown(self):
        row = wall_row()
        empty = replace(row, truth=np.zeros_like(row.truth), maps={"bms": np.zeros((2, 2))})
        (shown,) = of_class(read(replace(comparison(), wall=[empty])), "tiles")
        black = list(shown.iter("img"))[-1]
        assert decoded(black).max() == 0


def decoded(image: Element) -> np.ndarray:
    """Return the picture that an element holds, (h, w, 3) RGB."""
    content = base64.b64decode(image.get("src", "").partition(",")[2])
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture[..., ::-1]
