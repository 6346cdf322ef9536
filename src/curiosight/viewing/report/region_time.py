"""Time and learning progress in each region, a strip for each; and the colours of regions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.viewing.figures import window_shares
from curiosight.viewing.paper import Rgb, region_colours
from curiosight.viewing.report.content import ReportStep
from curiosight.viewing.report.markup import NOTHING, Markup, element, path_of, thinned

Floats = npt.NDArray[np.float64]

MAX_POINTS = 150  # of a strip
_MIN_CONTRAST = 1.8  # with the page; less is hard to see, and more leaves no room for shades


def window_of(n_steps: int) -> int:
    """Return over how many steps shares are counted, so that a strip shows some ten windows."""
    return int(np.clip(n_steps // 10, 5, 50))


def time_in_regions(steps: Sequence[ReportStep], names: Sequence[str]) -> Markup:
    """Return a table with a row for each region: share of the steps over time, progress, counts.

    Strips are in percent, x of the way through the steps. Shares and progress (eq. 2-3) each
    have one scale for all regions; a growing error counts as no progress, and the highest tenth
    of progress is cut off: two first errors make a slope far steeper than any that follow.
    """
    regions = np.array([step.region for step in steps])
    shares = window_shares(regions, len(names), window_of(len(steps)))
    progress = np.array([_progress_of(steps, region) for region in range(len(names))])
    fastest = _fastest(progress, regions)
    rows = [
        _row(
            region,
            name,
            int(np.count_nonzero(regions == region)),
            shares[region] / max(1e-9, float(shares.max())),
            np.minimum(progress[region] / fastest, 1),
        )
        for region, name in enumerate(names)
    ]
    head = element(
        "tr",
        {},
        element("th", {"scope": "col"}, "region"),
        element("th", {"scope": "col"}, "time →"),
        element("th", {"scope": "col", "class": "count"}, "frames"),
    )
    return element(
        "table",
        {"class": "regions"},
        element("thead", {}, head),
        element("tbody", {}, *rows),
    )


def region_key(names: Sequence[str]) -> Markup:
    """Return the list of the regions' colours."""
    items = [element("li", {}, _swatch(region), name) for region, name in enumerate(names)]
    return element("ul", {"class": "key"}, *items) if items else NOTHING


def region_styles(names: Sequence[str]) -> str:
    """Return CSS that gives the classes r0, r1, ... a --hue, for light pages, dark ones, paper."""
    colours = region_colours(names)
    on_light = _hues([_apart_from(colour, 1.0) for colour in colours])
    on_dark = _hues([_apart_from(colour, 0.01) for colour in colours])
    return f"{on_light}@media screen and (prefers-color-scheme:dark){{{on_dark}}}"


def _progress_of(steps: Sequence[ReportStep], region: int) -> Floats:
    """Return the region's progress, as last known at each step; NaN before."""
    known = np.full(len(steps), np.nan)
    last = np.nan
    for index, step in enumerate(steps):
        if step.region == region and step.learning_progress is not None:
            last = max(0.0, step.learning_progress)
        known[index] = last
    return known


def _fastest(progress: Floats, regions: npt.NDArray[np.int64]) -> float:
    """Return the progress that reaches a strip's top, from that of each step's own region."""
    steps = np.flatnonzero(regions >= 0)
    own = progress[regions[steps], steps]
    own = own[own > 0]
    return float(np.percentile(own, 90)) if len(own) else 1.0


def _row(region: int, name: str, n_steps: int, shares: Floats, progress: Floats) -> Markup:
    """Return a region's row; shares and progress in [0, 1]."""
    title = element("th", {"scope": "row"}, _swatch(region), name)
    described = f"Share of the time in {name}, and learning progress there"
    strip = element(
        "svg",
        {
            "class": "strip",
            "viewBox": "0 -8 100 108",
            "preserveAspectRatio": "none",
            "role": "img",
            "aria-label": described,
        },
        element("path", {"class": f"share r{region}", "d": _area(shares)}),
        _progress_line(progress),
    )
    cells = (element("td", {}, strip), element("td", {"class": "count"}, str(n_steps)))
    return element("tr", {}, title, *cells)


def _area(heights: Floats) -> str:
    """Return the path around the area below a curve of heights in [0, 1]."""
    points = thinned(_points(heights), MAX_POINTS)
    return path_of(np.vstack([[points[0, 0], 100], points, [points[-1, 0], 100]]), 1) + "z"


def _progress_line(heights: Floats) -> Markup:
    points = _points(heights)
    points = points[np.isfinite(heights)]
    if not len(points):
        return NOTHING
    return element("path", {"class": "progress", "d": path_of(thinned(points, MAX_POINTS), 1)})


def _points(heights: Floats) -> Floats:
    """Return (n, 2) points in percent, y downwards, of a curve of heights in [0, 1]."""
    return np.stack([np.linspace(0, 100, len(heights)), 100 * (1 - heights)], axis=1)


def _swatch(region: int) -> Markup:
    return element("span", {"class": f"swatch r{region}"})


def _hues(colours: Sequence[Rgb]) -> str:
    codes = ["".join(f"{round(255 * channel):02x}" for channel in colour) for colour in colours]
    return "".join(f".r{region}{{--hue:#{code}}}" for region, code in enumerate(codes))


def _apart_from(colour: Rgb, page: float) -> Rgb:
    """Return a colour further from white, or from black, until it shows on a page like that.

    page: its luminance. A pale pink becomes a stronger one rather than grey.
    """
    is_light = page > 0.5
    shown = np.array(colour)
    while _contrast(_luminance(shown), page) < _MIN_CONTRAST:
        distance = 1.04 * (1 - shown if is_light else shown) + 0.01
        shown = np.clip(1 - distance if is_light else distance, 0, 1)
    red, green, blue = shown.tolist()
    return red, green, blue


def _luminance(colour: Floats) -> float:
    """Return the relative luminance of an sRGB colour in [0, 1] (WCAG)."""
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def _contrast(first: float, second: float) -> float:
    low, high = sorted((first, second))
    return (high + 0.05) / (low + 0.05)
