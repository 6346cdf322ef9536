"""The sets of features that can be asked for by name."""

from __future__ import annotations

from curiosight.frame import Rgb
from curiosight.learner.features.colour import PLACES, Rows, describe_superpixels
from curiosight.learner.features.contrast import LEVELS, describe_contrast
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.superpixels import ColourSpace, Superpixels
from curiosight.learner.features.surroundings import CHANNELS, height_in_image, surroundings
from curiosight.learner.features.texture import texture

COLOURS, CONTRAST, SURROUNDINGS, TEXTURE, HEIGHT, ITTI = SET_NAMES = (
    "colours",
    "contrast",
    "surroundings",
    "texture",
    "height",
    "itti",
)
ONNX = "onnx:"


def make_sets(names: str, colour_space: ColourSpace) -> tuple[FeatureSet, ...]:
    """Return sets by their names, joined by `+`, in this order.

    names: of `SET_NAMES`, or `onnx:FILE`, which comes last (`network` says what it may be).
    colour_space: of the sets that are colours.

    Raises ValueError for another name, `DataError` for a file that is no such network.
    """
    plain, has_network, file = names.partition(ONNX)
    plain = plain.removesuffix("+") if has_network else plain
    parts = plain.split("+") if plain else []
    sets = tuple(_make(part, colour_space) for part in parts)
    if has_network:
        from curiosight.learner.features.network import network

        sets += (network(file),)
    if not sets:
        raise ValueError(f"features: expected {_choices()}, got {names!r}")
    return sets


def count_features(names: str, colour_space: ColourSpace, *, contrast: bool = False) -> int:
    """Return how many columns sets have together."""
    sets = make_sets(names, colour_space) + (make_sets(CONTRAST, colour_space) if contrast else ())
    return sum(len(one.columns) for one in sets)


def _make(name: str, colour_space: ColourSpace) -> FeatureSet:
    if name == COLOURS:
        columns = _columns([f"at {u:+d} {v:+d}" for u, v in PLACES.tolist()], colour_space)
        return FeatureSet(name, columns, _describe_colours, colour_space)
    if name == CONTRAST:
        kinds = [*(f"contrast {2**level}" for level in LEVELS), "deviation"]
        return FeatureSet(
            name, _columns(kinds, colour_space), describe_contrast, colour_space, from_sums=True
        )
    if name == SURROUNDINGS:
        return surroundings(colour_space)
    if name == TEXTURE:
        return texture(colour_space)
    if name == HEIGHT:
        return height_in_image(colour_space)
    if name == ITTI:
        from curiosight.learner.features.itti import itti

        return itti()
    raise ValueError(f"features: expected {_choices()}, got {name!r}")


def _describe_colours(image: Rgb, superpixels: Superpixels) -> Rows:
    return describe_superpixels(image, superpixels)[0]


def _columns(kinds: list[str], colour_space: ColourSpace) -> tuple[str, ...]:
    return tuple(f"{channel} {kind}" for kind in kinds for channel in CHANNELS[colour_space])


def _choices() -> str:
    return f"{', '.join(SET_NAMES)}, onnx:FILE, or some of them joined by +"
