"""What the page of a contest tells; every text is plain text, escaped when it is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Table = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class SourceReport:
    """One source of a contest.

    table: of table.json. figures: SVG files by what they show, drawn into the page.
    regions: SVG files by strategy: where its looks went.
    """

    name: str
    table: Table
    figures: Mapping[str, Path] = field(default_factory=dict)
    regions: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ContestReport:
    """A contest, told for a person.

    command: that makes it again. settings: all of them, to fold out.
    """

    sentence: str
    sources: Sequence[SourceReport]
    command: str
    settings: str = ""
