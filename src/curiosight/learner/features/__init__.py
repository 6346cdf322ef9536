"""RGB to superpixels, the paper's 39 colour features (sec. II-A.1) and 15 of contrast."""

from curiosight.learner.features.colour import (
    N_FEATURES,
    RowOfPixel,
    Rows,
    RowsPer,
    describe_pixels,
    describe_superpixels,
)
from curiosight.learner.features.contrast import N_CONTRAST, describe_contrast
from curiosight.learner.features.rows import count_features, describe
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
    "ColourSpace",
    "RowOfPixel",
    "Rows",
    "RowsPer",
    "SeedsSegmenter",
    "Superpixels",
    "count_features",
    "describe",
    "describe_contrast",
    "describe_pixels",
    "describe_superpixels",
    "shrink",
    "to_colour_space",
]
