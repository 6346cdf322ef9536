"""The report is one sound page that needs nothing else, and shows what the run did."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from command import succeed
from curiosight.errors import DataError
from curiosight.exploration.from_above import FromAbove, seen_from_above
from curiosight.frame import Label
from curiosight.segmentation import Segmentation
from curiosight.viewing.examples import Example
from curiosight.viewing.overlays import overlay_labels, overlay_saliency
from curiosight.viewing.report import (
    ExampleGroup,
    Footprint,
    Making,
    Report,
    ResultRow,
    Results,
    RoomMap,
    report_html,
    write_report,
)
from curiosight.viewing.report.region_time import region_styles
from room import ROOM, kinect, poses_around, render

HOSTILE = "</style></title><script>alert('1')</script>\" onload=\"x&amp; 'é\udcff"
NAMES = ("x0 y0", "x0 y1", "x1 y0")
VIEW = render(kinect(640, 480), poses_around(1)[0])
SECTIONS = ["examples", "curve", "map", "regions", "problems", "limits", "making"]


@dataclass(frozen=True)
class Row:
    """A step as the report needs it."""

    step: int
    region: int
    error: float | None
    overall_error: float | None
    learning_progress: float | None = None


def rows(n_steps: int = 40) -> list[Row]:
    """Return steps in one region after the other; every third frame shows no object."""
    return [
        Row(step, 3 * step // n_steps, None if step % 3 == 2 else 1 / (1 + step), 0.9**step, 0.01)
        for step in range(n_steps)
    ]


def example(caption: str = "frame-7") -> Example:
    labels = np.where(VIEW.ground_truth == 255, Label.SALIENT, Label.NOT_SALIENT)
    labels[:, :100] = Label.UNKNOWN
    saliency = cv2.resize(VIEW.ground_truth, (160, 120)) / np.float32(255)
    truth = VIEW.ground_truth
    taught = Segmentation.of_labels(labels.astype(np.uint8))
    return Example(caption, VIEW.rgb, taught, saliency, truth)


def room_map(n_posed: int = 6) -> RoomMap:
    poses = [*poses_around(n_posed), None, None]
    outline = np.array([[-3, -3], [3, -3], [3, 3], [-3, 3]], float)
    things = [Footprint(f"box {i}", outline / 10 + box.centre[:2]) for i, box in enumerate(ROOM)]
    return RoomMap(
        seen_from_above(poses, (0, 0, 1)),
        np.arange(len(poses)) % 4 - 1,
        [0, 3, 3, 5, n_posed],
        outline,
        [*things, Footprint("mug", outline / 50, is_object=True)],
    )


def report(name: str = "kitchen") -> Report:
    """Return a report with everything in it, called `name` wherever a name can stand."""
    return Report(
        title=name,
        sentence=f"Looked at {name}.",
        took="It took 3 seconds.",
        results=[Results(name, ("before", name), (ResultRow(name, ("0.9", name), name),))],
        examples=[ExampleGroup(name, [example(name)]), ExampleGroup("none", [])],
        steps=rows(),
        region_names=(name, *NAMES[1:]),
        room_map=replace(room_map(), footprints=[Footprint(name, np.eye(3)[:, :2])]),
        making=Making(name, {name: name}, name, {name: 1.5}, {name: name}),
        problems=[name],
        limits=[name],
    )


class Page(HTMLParser):
    """Read a page as a tree; every element must be closed where it belongs."""

    def __init__(self) -> None:
        super().__init__()
        self._builder = TreeBuilder()
        self._open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len(attrs) == len(dict(attrs)), "an attribute is given twice"
        self._builder.start(tag, {name: value or "" for name, value in attrs})
        if tag in ("meta", "img"):
            self._builder.end(tag)
        else:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag
        self._builder.end(tag)

    def handle_data(self, data: str) -> None:
        if self._open:
            self._builder.data(data)
        else:
            assert not data.strip()

    @classmethod
    def read(cls, page: str) -> Element:
        parser = cls()
        parser.feed(page)
        parser.close()
        assert not parser._open
        return parser._builder.close()


def read(told: Report) -> Element:
    return Page.read(report_html(told))


def of_class(tree: Element, name: str) -> list[Element]:
    return [found for found in tree.iter() if name in found.get("class", "").split()]


def text_of(element: Element) -> str:
    return "".join(element.itertext())


def points_of(path: str) -> np.ndarray:
    """Return the (n, 2) points that an SVG path of absolute moves and lines goes through."""
    numbers = [float(number) for number in re.findall(r"-?[\d.]+", re.sub(r"h\.01", "", path))]
    return np.array(numbers).reshape(-1, 2)


def pictures_of(tree: Element) -> Iterator[np.ndarray]:
    """Yield the images of the examples, (h, w, 3) RGB."""
    for row in of_class(tree, "pictures"):
        for image in row.iter("img"):
            content = base64.b64decode(image.get("src", "").partition(",")[2])
            decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
            assert decoded is not None
            assert (image.get("width"), image.get("height")) == ("480", "360")
            yield decoded[..., ::-1]


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
            ({"steps": []}, {"curve", "regions"}),
            ({"steps": [Row(0, 0, None, None)]}, {"curve"}),
            ({"region_names": ()}, {"regions"}),
            ({"room_map": None}, {"map"}),
            ({"room_map": RoomMap(seen_from_above([None]), np.zeros(1, int), [0])}, {"map"}),
            ({"problems": (), "limits": (), "making": None}, {"problems", "limits", "making"}),
        ],
    )
    def test_what_is_not_known_is_left_out(self, left_out, sections):
        tree = read(replace(report(), **left_out))
        named = [section.get("aria-labelledby") for section in tree.iter("section")]
        assert named == [name for name in SECTIONS if name not in sections]

    def test_title_and_sentence_are_enough(self):
        tree = read(Report("A room", "Nothing happened."))
        assert text_of(next(tree.iter("main"))) == "A roomNothing happened."

    def test_names_are_text_whatever_is_in_them(self, tmp_path):
        write_report(report(HOSTILE), tmp_path / "report.html")
        page = (tmp_path / "report.html").read_bytes().decode()
        tree, shown = Page.read(page), HOSTILE.replace("\udcff", "?")
        tags = [found.tag for found in read(report()).iter()]
        assert [found.tag for found in tree.iter()] == tags
        assert text_of(next(tree.iter("title"))) == shown
        assert text_of(next(tree.iter("code"))) == shown
        assert any(shown in image.get("alt", "") for image in tree.iter("img"))
        assert not any("onload" in found.attrib for found in tree.iter())

    def test_same_report_gives_same_bytes_and_no_word(self, tmp_path, capfd):
        for name in ("a.html", "b.html"):
            write_report(report(), tmp_path / name)
        assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
        assert capfd.readouterr() == ("", "")

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


class TestCurve:
    def test_points_are_the_errors(self):
        steps = rows()
        tree = read(replace(report(), steps=steps))
        (overall,), (dots,) = of_class(tree, "overall")[:1], of_class(tree, "dots")
        expected = [(100 * row.step / 39, 100 * (1 - row.overall_error)) for row in steps]
        np.testing.assert_allclose(points_of(overall.get("d")), expected, atol=0.006)
        known = [row for row in steps if row.error is not None]
        expected = [(100 * row.step / 39, 100 * (1 - row.error)) for row in known]
        np.testing.assert_allclose(points_of(dots.get("d")), expected, atol=0.006)

    def test_lines_are_named_with_the_error_at_their_end(self):
        ends = {text_of(label) for label in of_class(read(report()), "end")}
        late = [row.error for row in rows() if row.error is not None][-10:]
        assert ends == {f"{0.9**39:.2f}test views", f"{np.mean(late):.2f}each frame"}

    def test_mean_line_starts_with_the_first_error(self):
        steps = [Row(step, 0, 0.25, None) for step in range(5)]
        (mean, label) = of_class(read(replace(report(), steps=steps)), "mean")
        np.testing.assert_allclose(points_of(mean.get("d"))[:, 1], 75)
        assert text_of(label) == "0.25each frame"

    def test_one_step_is_a_point(self):
        tree = read(replace(report(), steps=[Row(0, 0, 0.5, 0.25)]))
        np.testing.assert_allclose(points_of(of_class(tree, "overall")[0].get("d")), [[0, 75]])


class TestMap:
    def test_dots_are_where_it_looked(self):
        tree, room = read(replace(report(), room_map=room_map())), room_map()
        dots = of_class(tree, "dot")
        places = {(float(dot.get("cx")), -float(dot.get("cy"))) for dot in dots}
        expected = {tuple(room.views.positions[view].round(3)) for view in (0, 3, 5)}
        assert places == expected
        largest = max(dots, key=lambda dot: float(dot.get("r")))
        assert float(largest.get("cx")) == pytest.approx(room.views.positions[3, 0], abs=1e-3)

    def test_wedges_open_to_where_it_looked(self):
        views = FromAbove(np.array([[1.0, 2.0], [0.0, 0.0]]), np.array([np.pi / 2, 0.0]))
        tree = read(replace(report(), room_map=RoomMap(views, np.array([0, 1]), [0])))
        (wedge,) = of_class(tree, "wedge")
        assert wedge.get("class") == "wedge r0"
        position, left, *_, right = points_of(re.sub(r"A\S+ \S+ 0 0 1 ", " ", wedge.get("d")))
        np.testing.assert_allclose(position, (1, -2))
        assert left[0] < 1 < right[0]
        assert left[1] == right[1] < -2, "up on the map is less in SVG"

    def test_walls_and_things_are_drawn_and_furniture_named(self):
        tree = read(replace(report(), room_map=room_map()))
        (walls,) = of_class(tree, "walls")
        np.testing.assert_allclose(points_of(walls.get("d")), [(-3, 3), (3, 3), (3, -3), (-3, -3)])
        assert len(of_class(tree, "furniture")) == len(ROOM)
        assert len(of_class(tree, "object")) == 1
        names = [text_of(name) for name in of_class(tree, "thing")]
        assert [name for name in names if name] == [f"box {i}" for i in range(len(ROOM))]

    def test_views_beyond_counting_stay_a_small_page(self):
        n_views = 30_000
        around = np.linspace(0, 2 * np.pi, n_views)
        views = FromAbove(np.stack([np.cos(around), np.sin(around)], axis=1), around)
        room = RoomMap(views, np.arange(n_views) % 3, list(range(0, n_views, 2)))
        assert len(report_html(Report("", "", room_map=room, region_names=NAMES))) < 600_000


class TestRegions:
    def test_rows_count_the_frames(self):
        tree = read(replace(report(), region_names=NAMES, steps=rows(30)))
        (table,) = of_class(tree, "regions")
        assert [text_of(row) for row in table.iter("tr")][1:] == [f"{name}10" for name in NAMES]

    def test_strips_fill_while_it_was_there(self):
        tree = read(replace(report(), region_names=NAMES, steps=rows(30)))
        for region, area in enumerate(of_class(tree, "share")):
            assert area.get("class") == f"share r{region}"
            points = points_of(area.get("d"))
            at_middle = points[np.argmin(np.abs(points[:, 0] - 100 * (region + 0.5) / 3))]
            assert at_middle[1] == 0, "the whole window was spent there"
            elsewhere = points[np.argmin(np.abs(points[:, 0] - 100 * ((region + 1.5) % 3) / 3))]
            assert elsewhere[1] == 100

    def test_progress_is_known_from_its_first_step_on_and_never_negative(self):
        known = [Row(0, 0, 1, 1), Row(1, 0, 1, 1, 0.4), Row(2, 1, 1, 1), Row(3, 0, 1, 1, -0.4)]
        tree = read(replace(report(), region_names=NAMES[:2], steps=known))
        (line,) = of_class(tree, "progress")
        expected = [(33.3, 0), (66.7, 0), (100, 100)]
        np.testing.assert_allclose(points_of(line.get("d")), expected)

    @given(st.lists(st.text("xy 012", min_size=1), min_size=1, max_size=20, unique=True))
    def test_colours_show_on_light_and_on_dark_pages(self, names):
        light, dark = region_styles(names).split("@media")
        for style, page in ((light, 1.0), (dark, 0.01)):
            codes = re.findall(r"\.r\d+\{--hue:#(\w{6})\}", style)
            assert len(codes) == len(names)
            for code in codes:
                srgb = np.array([int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)])
                luminance = (srgb**2.2) @ [0.2126, 0.7152, 0.0722]
                contrast = (max(luminance, page) + 0.05) / (min(luminance, page) + 0.05)
                assert contrast > 1.7


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
    assert sections == ["examples", "curve", "map", "regions", "limits", "making"]
    captions = [text_of(row[0]) for row in of_class(tree, "example")]
    assert set(captions[:2]) == {"000000", "000004"}, "the test views come first"
    assert len(captions) == len(set(captions)) == len(of_class(tree, "of-4")) > 2
    assert "On 2 test frames it never learned from" in text_of(of_class(tree, "lead")[0])
    command = text_of(next(tree.iter("code")))
    assert command == f"curiosight explore {room} --config config.toml"
    timeless = [re.sub(r"<(\w+) class=\"[^\"]*measured\">.*?</\1>", "", page) for page in pages]
    assert timeless[0] == timeless[1]
    assert len(timeless[0]) < len(pages[0])
