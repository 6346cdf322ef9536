"""RGB to superpixels, and sets of features of them: the paper's 39 colours and others."""

from curiosight.learner.features.cells import CellSegmenter
from curiosight.learner.features.colour import (
    N_FEATURES,
    RowOfPixel,
    Rows,
    RowsPer,
    describe_pixels,
    describe_superpixels,
)
from curiosight.learner.features.contrast import N_CONTRAST, describe_contrast
from curiosight.learner.features.describer import (
    Describer,
    Features,
    SuperpixelKind,
    missing_sets,
)
from curiosight.learner.features.feature_set import FeatureSet, mean_of_pixels, to_bytes
from curiosight.learner.features.rows import Picture, describe
from curiosight.learner.features.sets import SET_NAMES, count_features, make_sets
from curiosight.learner.features.superpixels import (
    ColourSpace,
    SeedsSegmenter,
    Superpixels,
    shrink,
    to_colour_space,
)

__all__ = [
    "N_CONTRAST",
    "N_FEATURES",
    "SET_NAMES",
    "CellSegmenter",
    "ColourSpace",
    "Describer",
    "FeatureSet",
    "Features",
    "Picture",
    "RowOfPixel",
    "Rows",
    "RowsPer",
    "SeedsSegmenter",
    "SuperpixelKind",
    "Superpixels",
    "count_features",
    "describe",
    "describe_contrast",
    "describe_pixels",
    "describe_superpixels",
    "make_sets",
    "mean_of_pixels",
    "missing_sets",
    "shrink",
    "to_bytes",
    "to_colour_space",
]
