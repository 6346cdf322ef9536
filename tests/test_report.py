"""The report is one sound page that needs nothing else, and shows what the run did."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import succeed
from curiosight.errors import DataError
from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Label
from curiosight.teacher import Segmentation
from curiosight.viewing.overlays import overlay_labels, overlay_saliency
from curiosight.viewing.report import (
    ExampleGroup,
    Report,
    ResultRow,
    Results,
    RoomMap,
    report_html,
    write_report,
)
from reports import (
    HOSTILE,
    NAMES,
    VIEW,
    Page,
    Row,
    assert_same_bytes_and_no_word,
    example,
    hostile_page,
    of_class,
    pictures_of,
    read,
    report,
    room_map,
    rows,
    text_of,
)

SECTIONS = [
    *("examples", "results", "curve", "map", "regions", "decisions"),
    *("problems", "limits", "making"),
]


class TestPage:
    def test_asks_for_nothing_from_outside(self):
        page = report_html(report())
        tree = Page.read(page)
        assert "://" not in page
        assert not re.search(r"url\(|@import", page)
        loading = {"script", "link", "iframe", "object", "embed", "base", "form", "a", "use"}
        assert not loading & {found.tag for found in tree.iter()}
        sources = [found.get("src", "") for found in tree.iter("img")]
        assert sources
        assert all(source.startswith("data:image/") for source in sources)
        for found in tree.iter():
            assert not {name for name in found.attrib if name.startswith(("on", "href", "xlink"))}

    def test_every_picture_says_what_it_shows(self):
        tree = read(report())
        pictures = [*tree.iter("img"), *(s for s in tree.iter("svg") if s.get("role") == "img")]
        assert len(pictures) == 5 + 1 + 1 + len(NAMES)
        assert all(picture.get("alt") or picture.get("aria-label") for picture in pictures)

    def test_sections_have_headings_in_order(self):
        tree = read(report())
        named = [section.get("aria-labelledby") for section in tree.iter("section")]
        assert named == SECTIONS
        assert [heading.get("id") for heading in tree.iter("h2")] == SECTIONS
        assert len(list(tree.iter("h1"))) == 1

    @pytest.mark.parametrize(
        ("left_out", "sections"),
        [
            ({"examples": [ExampleGroup("none", [])]}, {"examples"}),
            ({"results": [Results("none", (), ())]}, {"results"}),
            ({"steps": []}, {"curve", "regions"}),
            ({"steps": [Row(0, 0, None, None)]}, {"curve"}),
            ({"region_names": ()}, {"regions", "decisions"}),
            ({"decisions": ()}, {"decisions"}),
            ({"room_map": None}, {"map"}),
            ({"room_map": RoomMap(seen_from_above([None]), np.zeros(1, int), [0])}, {"map"}),
            ({"problems": (), "limits": (), "making": None}, {"problems", "limits", "making"}),
        ],
    )
    def test_what_is_not_known_is_left_out(self, left_out, sections):
        tree = read(replace(report(), **left_out))
        named = [section.get("aria-labelledby") for section in tree.iter("section")]
        assert named == [name for name in SECTIONS if name not in sections]

    def test_decisions_say_why_and_what_else(self):
        table = of_class(read(report()), "decisions")[0]
        cells = [text_of(cell) for cell in next(table.iter("tbody")).iter() if cell.tag != "tr"]
        assert cells[1:6] == ["12", "x1 y0", "7 s", "kitchen", "kitchen, 30 s away (0.125)"]
        assert cells[6:] == ["20", "kitchen", "0 s", "alone", ""]

    def test_title_and_sentence_are_enough(self):
        tree = read(Report("A room", "Nothing happened."))
        assert text_of(next(tree.iter("main"))) == "A roomNothing happened."

    def test_names_are_text_whatever_is_in_them(self, tmp_path):
        write_report(report(HOSTILE), tmp_path / "report.html")
        tree, shown = hostile_page(tmp_path / "report.html", read(report()))
        assert text_of(next(tree.iter("code"))) == shown

    def test_same_report_gives_same_bytes_and_no_word(self, tmp_path, capfd):
        assert_same_bytes_and_no_word(lambda path: write_report(report(), path), tmp_path, capfd)

    def test_is_small_enough_to_send(self):
        group = ExampleGroup("views", [example()] * 4)
        many = replace(report(), examples=[group] * 3, steps=rows(20_000))
        assert len(report_html(many)) < 3_000_000

    def test_unwritable_place_is_a_data_error(self, tmp_path):
        with pytest.raises(DataError, match="cannot be written"):
            write_report(report(), tmp_path / "missing" / "report.html")

    def test_wrong_tables_and_maps_are_refused(self):
        with pytest.raises(ValueError, match="rows: expected 1 values in 'error', got 2"):
            Results("", ("now",), (ResultRow("error", ("0.1", "0.2")),))
        with pytest.raises(ValueError, match="region_of_view: expected one for each of 8 views"):
            replace(room_map(), region_of_view=np.zeros(3, int))


class TestExamples:
    def test_images_are_the_pictures_that_were_given(self):
        shown = example()
        expected = [
            shown.rgb,
            overlay_labels(shown.rgb, shown.segmentation),
            overlay_saliency(shown.rgb, shown.saliency),
            overlay_labels(shown.rgb, Segmentation.of_labels(shown.ground_truth)),
        ]
        pictures = list(pictures_of(read(report())))
        assert len(pictures) == len(expected)
        for picture, image in zip(pictures, expected, strict=True):
            small = cv2.resize(image, (480, 360), interpolation=cv2.INTER_AREA)
            assert np.abs(picture.astype(int) - small).mean() < 4

    @pytest.mark.parametrize("missing", [{"ground_truth": None}, {"segmentation": None}])
    def test_pictures_that_there_are_not_are_left_out(self, missing):
        told = replace(report(), examples=[ExampleGroup("", [replace(example(), **missing)])])
        assert len(list(pictures_of(read(told)))) == 3

    def test_alt_texts_say_the_shares(self):
        labels = np.full(VIEW.ground_truth.shape, Label.NOT_SALIENT, np.uint8)
        labels[:120] = Label.SALIENT
        shown = replace(example(), segmentation=Segmentation.of_labels(labels))
        tree = read(replace(report(), examples=[ExampleGroup("", [shown])]))
        expected = "Labels from depth of frame-7: 25% salient, 75% not salient"
        assert expected in [image.get("alt") for image in tree.iter("img")]


def test_exploration_is_reported_the_same_but_for_the_time(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pages = []
    for name in ("a", "b"):
        options = ("--steps", 4, "--test-every", 4, "--gap", 0, "--out", tmp_path / name)
        succeed(capsys, "explore", room, *options)
        pages.append((tmp_path / name / "report.html").read_text("utf-8"))
    tree = Page.read(pages[0])
    sections = [section.get("aria-labelledby") for section in tree.iter("section")]
    assert sections == ["examples", "results", "curve", "map", "regions", "limits", "making"]
    captions = [text_of(row[0]) for row in of_class(tree, "example")]
    assert set(captions[:2]) == {"000000", "000004"}, "the test views come first"
    assert len(captions) == len(set(captions)) == len(of_class(tree, "of-4")) > 2
    assert "On 2 test frames it never learned from" in text_of(of_class(tree, "lead")[0])
    command = text_of(next(tree.iter("code")))
    assert command == f"curiosight explore {room} --config config.toml"
    timeless = [re.sub(r"<(\w+) class=\"[^\"]*measured\">.*?</\1>", "", page) for page in pages]
    assert timeless[0] == timeless[1]
    assert len(timeless[0]) < len(pages[0])
