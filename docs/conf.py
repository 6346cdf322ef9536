"""Build the site: `make docs`. Pages are the Markdown files here and parts of the READMEs."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "src"))

project = "curiosight"
author = "The curiosight maintainers"
project_copyright = author
extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["conf.py"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["myst.header"]  # a part of a README begins below its title

# Only what the wheel of furo brings: no fonts, scripts or counters from elsewhere.
highlight_language = "none"  # what a terminal shows is no Python

html_theme = "furo"
html_title = "curiosight"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False  # read from other files, which file:// forbids
html_theme_options = {"navigation_with_keys": True}

autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "exclude-members": "__init__"}
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
add_module_names = False

# `<!-- part of README.md: ## First line, until: how the line after it begins -->`; either may be
# empty.
PART = re.compile(r"<!-- part of ([\w/.]+): (.*?), until: (.*?) -->")
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
# Which page an anchor of the README is on.
PAGE_OF = {"what-it-reaches": "figures.md", "what-it-cannot-do": "cannot.md"}
ARGUMENT = re.compile(r"^([\w.]+(?:, [\w.]+)*)(?:: | = )(.+)$")


def fill(app: Sphinx, page: str, source: list[str]) -> None:
    """Put the parts of READMEs into a page, and point links to the pages of the site."""
    text = LINK.sub(lambda link: _link(link, Path("docs"), page), source[0])
    source[0] = PART.sub(lambda marker: _part(marker, page), text)


def _part(marker: re.Match[str], page: str) -> str:
    name, first, after = marker.groups()
    text = (ROOT / name).read_text("utf-8")
    start = text.index(f"\n{first}\n") + 1 if first else 0
    end = text.index(f"\n{after}", start) + 1 if after else len(text)
    return LINK.sub(lambda link: _link(link, Path(name).parent, page), text[start:end])


def _link(link: re.Match[str], folder: Path, page: str) -> str:
    """Return a link of a file in a folder of the repository as one of a page of the site."""
    mark, said, target = link.groups()
    file, _, anchor = target.partition("#")
    if not file or "://" in target:
        return link[0]
    path = Path(*_resolved((folder / file).parts))
    hashed = f"#{anchor}" if anchor else ""
    if path == Path("README.md"):
        return f"[{said}]({PAGE_OF.get(anchor, 'index.md')})"
    if path == Path("benchmarks/README.md") or path == Path("benchmarks"):
        return f"[{said}](benchmarks.md{hashed})"
    if path == Path("docs", page).with_suffix(".md") and not anchor:
        return said
    if path.is_relative_to("docs"):
        said = path.stem.replace("-", " ") if said == str(path) else said
        return f"{mark}[{said}]({path.relative_to('docs')}{hashed})"
    if not (ROOT / path).exists():
        return link[0]  # the build complains
    return f"{said} (`{path}`)" if said.strip("`") not in str(path) else f"`{path}`"


def _resolved(parts: tuple[str, ...]) -> list[str]:
    kept: list[str] = []
    for part in parts:
        if part == "..":
            kept.pop()
        elif part != ".":
            kept.append(part)
    return kept


def tell(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Turn our docstrings into reStructuredText: names with what is said of them become a list."""
    told: list[str] = []
    is_listed = False
    for line in lines:
        argument = ARGUMENT.match(line)
        bare = line.strip()
        if argument is not None and what != "module":
            told += ["", f"* ``{argument[1]}``: {_escaped(argument[2])}"]
            is_listed = True
        elif is_listed and bare:
            told.append(f"  {_escaped(bare)}")
        else:
            is_listed = is_listed and bool(bare)
            told.append(_escaped(bare) if not line.startswith(">>>") else line)
    lines[:] = told


def _escaped(text: str) -> str:
    parts = re.split(r"(`[^`]*`)", text)
    # What follows a literal at once, as an s, would else belong to it.
    return "".join(
        f"`{part}`\\ " if part.startswith("`") else re.sub(r"([*|_\\])", r"\\\1", part)
        for part in parts
    )


def shorten(
    app: Sphinx,
    what: str,
    name: str,
    of: object,
    options: object,
    said: str | None,
    gives: str | None,
) -> tuple[str | None, str | None]:
    """Write the types of arrays as the code does."""
    array = re.compile(
        r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], "
        r"~?(?:numpy\.)?dtype\[~?(?:numpy\.)?([\w.~\[\]]*?)\]\]"
    )
    said, gives = (text and array.sub(r"NDArray[\1]", text) for text in (said, gives))
    return said, gives


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", fill)
    app.connect("autodoc-process-docstring", tell)
    app.connect("autodoc-process-signature", shorten)
