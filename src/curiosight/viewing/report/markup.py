"""Write elements of HTML and SVG: whatever is not markup yet is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Attributes = Mapping[str, str | float]
Points = npt.NDArray[np.floating[Any]]
Scalar = TypeVar("Scalar", bound=np.generic)

_VOID = {"img", "input", "meta"}  # have no content and no end tag


class Markup(str):
    """Text that is markup already."""

    __slots__ = ()


NOTHING = Markup()


def element(name: str, attributes: Attributes, *content: str) -> Markup:
    """Return an element with its attributes and content."""
    named = "".join(f' {key}="{_written(value)}"' for key, value in attributes.items())
    if name in _VOID:
        return Markup(f"<{name}{named}>")
    return Markup(f"<{name}{named}>{join(content)}</{name}>")


def join(parts: Iterable[str]) -> Markup:
    """Return the parts one after the other, escaped where they are plain text."""
    return Markup("".join(p if isinstance(p, Markup) else escape(p) for p in parts))


def number(value: float, decimals: int = 2) -> str:
    """Write a number as short as its decimals allow."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def path_of(points: Points, decimals: int = 2) -> str:
    """Return the SVG path through (n, 2) points."""
    return "M" + "L".join(f"{number(x, decimals)} {number(y, decimals)}" for x, y in points)


def thinned(values: npt.NDArray[Scalar], n_most: int) -> npt.NDArray[Scalar]:
    """Return at most that many of the values, evenly spread, with the first and the last."""
    kept = np.linspace(0, len(values) - 1, min(len(values), n_most)).astype(int)
    few: npt.NDArray[Scalar] = values[kept]
    return few


def _written(value: str | float) -> str:
    return escape(value if isinstance(value, str) else number(value))
