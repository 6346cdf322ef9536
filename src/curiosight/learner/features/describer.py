"""From an image to rows of features: superpixels, and sets of features side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Literal, get_args

from curiosight.errors.arguments import check_switch, check_whole
from curiosight.frame import Rgb
from curiosight.learner.features.cells import CellSegmenter
from curiosight.learner.features.colour import RowOfPixel, Rows, RowsPer
from curiosight.learner.features.feature_set import FeatureSet
from curiosight.learner.features.rows import Picture, describe
from curiosight.learner.features.sets import COLOURS, CONTRAST, ONNX, SET_NAMES, make_sets
from curiosight.learner.features.superpixels import ColourSpace, SeedsSegmenter

SuperpixelKind = Literal["seeds", "cells"]
Features = str | Sequence[FeatureSet]
# What files of version 0.1 call the only set that they know, with contrast or without.
FIRST_NAME = "39 mean colours"
# Of four pixels each.
MAX_SUPERPIXELS = 320 * 240 // 4


class Describer:
    """Describe images of 320 pixels width by rows of 8-bit features.

    features: names joined by `+`, see `make_sets`, or sets of one's own.
    rows_per: "pixel" describes every pixel exactly by the set `colours`. Of all other sets the
        pixels of a superpixel have one row, whatever is said here.
    contrast: add the set `contrast`.
    superpixels: "seeds", or "cells", which are ten times sooner.
    n_superpixels: for a 320x240 image.

    Raises ValueError for what there is not, `DataError` for a file that cannot be used.
    """

    def __init__(
        self,
        *,
        features: Features = COLOURS,
        rows_per: RowsPer = "pixel",
        colour_space: ColourSpace = "rgb",
        contrast: bool = False,
        superpixels: SuperpixelKind = "seeds",
        n_superpixels: int = 600,
    ) -> None:
        _check_choice("rows_per", rows_per, get_args(RowsPer))
        _check_choice("colour_space", colour_space, get_args(ColourSpace))
        _check_choice("superpixels", superpixels, get_args(SuperpixelKind))
        check_whole("n_superpixels", n_superpixels, 1, MAX_SUPERPIXELS)
        check_switch("contrast", contrast)
        sets = make_sets(features, colour_space) if isinstance(features, str) else (*features,)
        self.features = "+".join(one.name for one in sets)
        self.rows_per = rows_per
        self.colour_space = colour_space
        self.contrast = contrast
        self.superpixels = superpixels
        self.n_superpixels = n_superpixels
        self.base_sets = sets
        self.sets = sets + (make_sets(CONTRAST, colour_space) if contrast else ())
        _check_sets(self.sets)
        self._cut: SeedsSegmenter | CellSegmenter
        if superpixels == "seeds":
            self._cut = SeedsSegmenter(n_superpixels=n_superpixels)
        else:
            self._cut = CellSegmenter(n_superpixels=n_superpixels)

    @property
    def n_features(self) -> int:
        """The number of columns of a row."""
        return sum(len(one.columns) for one in self.sets)

    def __call__(self, rgb: Rgb) -> tuple[Rows, RowOfPixel]:
        """Return (n, n_features) uint8 rows of an (h, w, 3) image, and each pixel's row."""
        picture = Picture(rgb)
        cut = rgb if self.superpixels == "seeds" else picture.of_space(self.colour_space)
        return describe(picture, self._cut(cut), self.sets, rows_per=self.rows_per)

    def settings(self) -> dict[str, Any]:
        """Return what `__init__` needs for another such describer."""
        return {
            "features": self.base_sets,
            "rows_per": self.rows_per,
            "colour_space": self.colour_space,
            "contrast": self.contrast,
            "superpixels": self.superpixels,
            "n_superpixels": self.n_superpixels,
        }

    def definition(self) -> dict[str, Any]:
        """Return what the features mean, JSON-able, for a model's file."""
        said: dict[str, Any] = {
            "rows_per": self.rows_per,
            "colour_space": self.colour_space,
            "contrast": self.contrast,
            "n_superpixels": self.n_superpixels,
        }
        if self.features == COLOURS and self.superpixels == "seeds":
            return {"name": FIRST_NAME} | said  # as version 0.1 writes and reads it
        sets = [one.definition() for one in self.sets]
        return {"sets": sets, "superpixels": self.superpixels} | said

    @classmethod
    def of_definition(cls, said: dict[str, Any], own: Iterable[FeatureSet] = ()) -> Describer:
        """Return the describer that wrote a definition, of version 0.1 too.

        own: sets that are not ours, known by their names. Whether the sets mean what they did is
        to be seen from the result's own definition. Raises KeyError where something is not said.
        """
        colour_space, contrast = said["colour_space"], said["contrast"]
        own_of_name = {one.name: one for one in own}
        sets: tuple[FeatureSet, ...] = ()
        for name in _names(said):
            sets += (own_of_name[name],) if name in own_of_name else make_sets(name, colour_space)
        return cls(
            features=sets,
            rows_per=said["rows_per"],
            colour_space=colour_space,
            contrast=contrast,
            superpixels=said.get("superpixels", "seeds"),
            n_superpixels=said["n_superpixels"],
        )


def missing_sets(said: dict[str, Any], own: Iterable[FeatureSet] = ()) -> list[str]:
    """Return the names of a definition's sets that are neither ours nor `own`."""
    known = {*SET_NAMES, *(one.name for one in own)}
    return [name for name in _names(said) if name not in known and not name.startswith(ONNX)]


def _names(said: dict[str, Any]) -> list[str]:
    """Return the names of the sets of a definition, but for that of the contrast it asks for."""
    if "sets" not in said:
        return [COLOURS]
    names = [one["name"] for one in said["sets"]]
    return names[:-1] if said["contrast"] else names


def _check_choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f"{name}: expected {' or '.join(map(repr, choices))}, got {value!r}")


def _check_sets(sets: tuple[FeatureSet, ...]) -> None:
    names = [one.name for one in sets]
    if not names or len(set(names)) < len(names):
        raise ValueError(f"features: expected one set or more, each once, got {names}")
