"""The page of a catalogue: a card an entry, to be filtered by change, in one file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from curiosight.catalogue import CHANGES, Entry
from curiosight.errors.files import replace_file
from curiosight.frame import Rgb
from curiosight.viewing.catalogue.plan import plan_of
from curiosight.viewing.report.document import document, list_section, section
from curiosight.viewing.report.embedding import source
from curiosight.viewing.report.markup import NOTHING, Markup, element, join, number

ALL = "all"


@dataclass(frozen=True, slots=True, eq=False)
class CatalogueReport:
    """What a page shows.

    pictures: of the entries, (h, w, 3) uint8, by their numbers; any may be missing.
    visits: names of the recordings, first to last. warnings: what a reader should know.
    """

    entries: Sequence[Entry]
    pictures: Mapping[int, Rgb]
    visits: Sequence[str]
    command: str
    warnings: Sequence[str] = ()


def write_catalogue(report: CatalogueReport, path: Path) -> None:
    """Write the page, completely or not at all; the same report gives the same bytes."""
    replace_file(path, catalogue_html(report).encode("utf-8", "replace"))


def catalogue_html(report: CatalogueReport) -> str:
    """Return the page; it needs nothing else."""
    style = files(__package__).joinpath("catalogue.css").read_text("utf-8")
    return document("What is there", _sections(report), style=style)


def _sections(report: CatalogueReport) -> Iterator[Markup]:
    counts = Counter[str](entry.change for entry in report.entries)
    yield _opening(report, counts)
    is_compared = len(report.visits) > 1
    if report.entries:
        if is_compared:
            yield _filters(counts)
        yield section("where", "Where", "", plan_of(report.entries))
    for place in sorted({entry.place for entry in report.entries}, key=_known_first):
        here = [entry for entry in report.entries if entry.place == place]
        title = "Things" if place is None else f"Place {place}"
        cards = [_card(one, report.pictures.get(one.id), is_compared) for one in here]
        yield section(f"place-{place}", title, "", element("div", {"class": "cards"}, *cards))
    yield list_section("warnings", "Worth knowing", report.warnings)
    making = element("pre", {}, element("code", {}, report.command))
    yield section("making", "How this was made", "", making)


def _known_first(place: int | None) -> tuple[bool, int]:
    return place is None, place or 0


def _opening(report: CatalogueReport, counts: Mapping[str, int]) -> Markup:
    n_there = len(report.entries) - counts["gone"]
    things = "1 thing is" if n_there == 1 else f"{n_there} things are"
    sentence = f"{things} there."
    if len(report.visits) > 1:
        told = ", ".join(f"{counts[change]} {change}" for change in CHANGES)
        sentence = f"{things} there; since the visit before: {told}."
    visits = element("ol", {"class": "visits"}, *[element("li", {}, x) for x in report.visits])
    lead = element("p", {"class": "lead"}, sentence)
    return element("header", {}, element("h1", {}, "What is there"), lead, visits)


def _filters(counts: Mapping[str, int]) -> Markup:
    """Return buttons that show the entries of one change alone; they need no script."""
    buttons = []
    for name in (ALL, *CHANGES):
        n = sum(counts.values()) if name == ALL else counts[name]
        given: dict[str, str | float] = {"type": "radio", "name": "change", "id": f"show-{name}"}
        if name == ALL:
            given["checked"] = "checked"
        label = element("label", {"for": f"show-{name}", "class": name}, f"{name} ", _small(n))
        buttons.append(join((element("input", given), label)))
    legend = element("legend", {}, "Show")
    return element("fieldset", {"class": "filters"}, legend, *buttons)


def _small(n: int) -> Markup:
    return element("small", {}, str(n))


def _card(entry: Entry, picture: Rgb | None, is_compared: bool) -> Markup:
    image = NOTHING
    if picture is not None:
        text = f"thing {entry.id}, in the view that shows most of it"
        image = element("img", {**source(picture), "alt": text, "loading": "lazy"})
    badge = element("span", {"class": f"badge {entry.change}"}, entry.change)
    title = element("h3", {}, f"{entry.id} ", badge if is_compared else NOTHING)
    size = " × ".join(number(100 * length, 0) for length in entry.size_m)
    x, y, z = (number(metres) for metres in entry.T_world_centre[:3, 3])
    views = "1 view" if entry.n_views == 1 else f"{entry.n_views} views"
    lines = [f"on {entry.support}", f"{size} cm", f"at {x}, {y}, {z} m", views]
    if entry.T_world_before is not None:
        before = ", ".join(number(metres) for metres in entry.T_world_before[:3, 3])
        lines.append(f"was at {before} m")
    lines.append(f"sure by {number(100 * entry.confidence, 0)} %")
    told = element("ul", {}, *[element("li", {}, line) for line in lines])
    kind = {"class": f"card {entry.change}", "id": f"entry-{entry.id}"}
    return element("article", kind, element("div", {"class": "photo"}, image), title, told)
