"""RGB to superpixels and the paper's 39 colour features (sec. II-A.1)."""

from curiosight.features.colour import (
    N_FEATURES,
    RowOfPixel,
    Rows,
    RowsPer,
    describe_pixels,
    describe_superpixels,
)
from curiosight.features.superpixels import (
    ColourSpace,
    SeedsSegmenter,
    Superpixels,
    shrink,
    to_colour_space,
)

__all__ = [
    "N_FEATURES",
    "ColourSpace",
    "RowOfPixel",
    "Rows",
    "RowsPer",
    "SeedsSegmenter",
    "Superpixels",
    "describe_pixels",
    "describe_superpixels",
    "shrink",
    "to_colour_space",
]
