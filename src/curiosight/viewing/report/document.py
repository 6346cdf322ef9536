"""What all pages share: one file that asks for nothing from outside, its sections and lists."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files

from curiosight.viewing.report.markup import NOTHING, Markup, element, join

# Even what slipped through could load nothing and run nothing.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def document(title: str, sections: Iterable[Markup], *, style: str = "", script: str = "") -> str:
    """Return a page that looks like a report; no other script than the one given can run.

    style: CSS after the report's own. script: runs at the end of the page.
    """
    common_style = files(__package__).joinpath("report.css").read_text("utf-8")
    head = element(
        "head",
        {},
        element("meta", {"charset": "utf-8"}),
        element("meta", {"http-equiv": "Content-Security-Policy", "content": _policy(script)}),
        element("meta", {"name": "viewport", "content": "width=device-width, initial-scale=1"}),
        element("meta", {"name": "color-scheme", "content": "light dark"}),
        element("title", {}, title),
        element("style", {}, Markup(common_style + style)),
    )
    last = element("script", {}, Markup(script)) if script else NOTHING
    body = element("body", {}, element("main", {}, *sections), last)
    return "<!DOCTYPE html>\n" + element("html", {"lang": "en"}, head, body) + "\n"


def section(name: str, title: str, text: str, content: Markup) -> Markup:
    """Return a section with its heading; text: a paragraph before the content, or empty."""
    heading = element("h2", {"id": name}, title)
    introduction = element("p", {}, text) if text else NOTHING
    return element("section", {"aria-labelledby": name}, heading, introduction, content)


def list_section(name: str, title: str, lines: Sequence[str]) -> Markup:
    """Return a section that lists the lines; nothing where there are none."""
    if not lines:
        return NOTHING
    return section(name, title, "", element("ul", {}, *[element("li", {}, x) for x in lines]))


def pairs(named: Mapping[str, str], *, is_code: bool = False) -> Markup:
    """Return a list of names, each with a text; is_code: names are file names, say."""
    kind = "code" if is_code else "span"
    terms = [
        join((element("dt", {}, element(kind, {}, name)), element("dd", {}, text)))
        for name, text in named.items()
    ]
    return element("dl", {}, *terms)


def _policy(script: str) -> str:
    if not script:
        return _POLICY
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return f"{_POLICY}; script-src 'sha256-{digest}'"
