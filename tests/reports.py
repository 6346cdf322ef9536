"""A report with everything in it, and its page read back as a tree."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder

import cv2
import numpy as np
import pytest

from curiosight.explorer.decision import Candidate, Decision
from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Label
from curiosight.teacher import Segmentation
from curiosight.viewing.examples import Example
from curiosight.viewing.report import (
    ExampleGroup,
    Footprint,
    Making,
    Report,
    ResultRow,
    Results,
    RoomMap,
    report_html,
)
from room import ROOM, kinect, poses_around, render

HOSTILE = "</style></title><script>alert('1')</script>\" onload=\"x&amp; 'é\udcff"
NAMES = ("x0 y0", "x0 y1", "x1 y0")
SQUARE = np.array([[-3, -3], [3, -3], [3, 3], [-3, 3]], float)
VIEW = render(kinect(640, 480), poses_around(1)[0])


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
    things = [Footprint(f"box {i}", SQUARE / 10 + box.centre[:2]) for i, box in enumerate(ROOM)]
    return RoomMap(
        seen_from_above(poses, (0, 0, 1)),
        np.arange(len(poses)) % 4 - 1,
        [0, 3, 3, 5, n_posed],
        (SQUARE,),
        [*things, Footprint("mug", SQUARE / 50, is_object=True)],
    )


def decisions(name: str) -> list[tuple[int, Decision]]:
    """Return a decision of three candidates, explained with a name, and one without a choice."""
    here, there = Candidate(0, None, 30.0, 0.125), Candidate(2, 0.5, 7.25, 0.25)
    among = Decision((here, Candidate(1, 0.0, 3.0, -1.0), there), 2, name)
    return [(12, among), (20, Decision((Candidate(0, 0.1, 0.0, 0.1),), 0, "alone"))]


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
        region_note=f"Called {name}.",
        decisions=decisions(name),
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


def hostile_page(path: Path, plain: Element) -> tuple[Element, str]:
    """Return a written page that calls everything HOSTILE, and that name as it is to be shown.

    plain: the same page with a harmless name, of which it must have the elements.
    """
    tree, shown = Page.read(path.read_bytes().decode()), HOSTILE.replace("\udcff", "?")
    assert [found.tag for found in tree.iter()] == [found.tag for found in plain.iter()]
    assert text_of(next(tree.iter("title"))) == shown
    assert any(shown in image.get("alt", "") for image in tree.iter("img"))
    assert not any("onload" in found.attrib for found in tree.iter())
    return tree, shown


def assert_same_bytes_and_no_word(
    write: Callable[[Path], None], folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("a.html", "b.html"):
        write(folder / name)
    assert (folder / "a.html").read_bytes() == (folder / "b.html").read_bytes()
    assert capfd.readouterr() == ("", "")
