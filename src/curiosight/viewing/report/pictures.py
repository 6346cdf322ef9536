"""Examples: what the camera saw, what depth said, what the model says, what is true."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from curiosight.frame import LABEL_COLOURS, Label, Rgb
from curiosight.teacher import Segmentation
from curiosight.viewing.examples import Example
from curiosight.viewing.overlays import (
    LABEL_NAMES,
    OUTLINE_COLOUR,
    Colour,
    overlay_labels,
    overlay_saliency,
)
from curiosight.viewing.report.content import ExampleGroup
from curiosight.viewing.report.embedding import shrunken, source
from curiosight.viewing.report.markup import Markup, element, join

MAX_WIDTH_PX = 480
_HATCHING = "repeating-linear-gradient(135deg,#fff 0 1px,transparent 1px 5px)"


def example_groups(groups: Sequence[ExampleGroup]) -> Markup:
    """Return what the colours mean, and all groups."""
    parts = [_key()]
    for group in groups:
        if group.examples:
            parts.append(element("h3", {}, group.title))
            parts += [_row(example) for example in group.examples]
    return join(parts)


def _row(example: Example) -> Markup:
    pictures = list(_pictures(example))
    return element(
        "figure",
        {"class": "example"},
        element("figcaption", {}, example.caption),
        element("div", {"class": f"pictures of-{len(pictures)}"}, *pictures),
    )


def _pictures(example: Example) -> Iterator[Markup]:
    rgb, of = example.rgb, f"of {example.caption}"
    yield _picture("What the camera saw", f"Colour image {of}", rgb)
    if example.segmentation is not None:
        said = _shares(example.segmentation.labels)
        overlay = overlay_labels(rgb, example.segmentation)
        yield _picture("What depth says", f"Labels from depth {of}: {said}", overlay)
    share = np.mean(example.saliency > 0.5)
    overlay = overlay_saliency(rgb, example.saliency)
    described = f"Predicted saliency {of}: {share:.0%} over one half"
    yield _picture("What the model says", described, overlay)
    if example.ground_truth is not None:
        truth = Segmentation.of_labels(example.ground_truth)
        said = _shares(truth.labels)
        yield _picture("What is true", f"Ground truth {of}: {said}", overlay_labels(rgb, truth))


def _picture(title: str, description: str, rgb: Rgb) -> Markup:
    return element(
        "figure",
        {},
        element("figcaption", {}, title),
        element("img", {"alt": description, **source(shrunken(rgb, MAX_WIDTH_PX))}),
    )


def _shares(labels: npt.NDArray[np.uint8]) -> str:
    """Say which share of the pixels each label has."""
    shares = {name: np.mean(labels == label) for label, name in LABEL_NAMES.items()}
    return ", ".join(f"{share:.0%} {name}" for name, share in shares.items() if share > 0)


def _key() -> Markup:
    """Name the colours of labels and of saliency."""
    swatches = [
        element("li", {}, element("span", {"class": "swatch", "style": _look(label)}), name)
        for label, name in LABEL_NAMES.items()
    ]
    ramp = np.linspace(0, 1, 96, dtype=np.float32)[None].repeat(12, axis=0)
    heat = overlay_saliency(np.full((*ramp.shape, 3), 100, np.uint8), ramp)
    scale = element("img", {"alt": "from grey to bright yellow", **source(heat, ".png")})
    prediction = element("li", {"class": "scale"}, "background ", scale, " object")
    return element("ul", {"class": "key"}, *swatches, prediction)


def _look(label: Label) -> str:
    """Return the style of a label's swatch, as the overlays paint it."""
    style = f"background-color:{_css(LABEL_COLOURS[label])}"
    if label is Label.SALIENT:
        style += f";border:2px solid {_css(OUTLINE_COLOUR)}"
    if label is Label.UNKNOWN:
        style += f";background-image:{_HATCHING}"
    return style


def _css(colour: Colour) -> str:
    return "rgb({},{},{})".format(*colour)
