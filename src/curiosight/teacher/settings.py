"""The thresholds of the teacher, with two sets for what stands on a floor or on a table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Self

# Metres, shares, pixels: nothing here is as large, and larger numbers overflow.
MOST = 1e6


def check_positive(settings: object, names: Iterable[str]) -> None:
    """Raise ValueError unless the named settings are above 0."""
    for name in names:
        value = getattr(settings, name)
        if not value > 0:
            raise ValueError(f"{name}: expected a positive number, got {value}")
        if value > MOST:
            raise ValueError(f"{name}: expected no more than {MOST:g}, got {value}")


@dataclass(frozen=True, slots=True)
class SupportSettings:
    """Thresholds for what stands on a support, in metres; the defaults are the floor's.

    min_size, max_size: diagonal of an object's box, upright on its support (sec. II-A.2).
    max_width: diagonal of its ground plan, unless it is known to carry nothing: chairs stay
        below, cupboards do not.
    leaf, tolerance: side of a voxel; gap up to which voxels belong together.
    slab: thickness of the layer on the support that counts as the support itself.
    max_height: over the support, beyond which nothing is an object.
    part_touching: whether concave creases and steps in depth part what stands together. Most
        of what touches on a table are two objects; on a floor it is one chair.
    """

    min_size: float = 0.10
    max_size: float = 1.50
    max_width: float = 1.00
    leaf: float = 0.06
    tolerance: float = 0.10
    slab: float = 0.03
    max_height: float = 2.0
    part_touching: bool = False

    def __post_init__(self) -> None:
        check_positive(self, [name for name in self.__slots__ if name != "part_touching"])
        if self.min_size >= self.max_size:
            raise ValueError(
                f"min_size: expected less than max_size {self.max_size}, got {self.min_size}"
            )


FLOOR = SupportSettings()
TABLE = SupportSettings(
    min_size=0.05,
    max_size=0.85,
    max_width=0.85,
    leaf=0.02,
    tolerance=0.03,
    slab=0.01,
    max_height=1.0,
    part_touching=True,
)


# The best noise that is believed, 1/m: 5 mm at 3 m, for floors that are not flat either.
MIN_NOISE = 0.0005
# Farther than this times the range set, pixels are too sparse on small things.
MAX_REACH = 1.5
# A grid is not coarser than set by more than this, or small images tell too little.
MAX_COARSER = 1.2
# What such a sensor sees is worth a finer grid.
FINE_STRIDE = 2


@dataclass(frozen=True, slots=True)
class SegmentationSettings:
    """All thresholds, in metres unless the name says otherwise.

    Sizes and range are the paper's (sec. II-A.2). What it does not print follows its authors'
    later parameter files, except the sensor's noise, which they leave out.

    max_range: nothing farther along z teaches.
    min_wall_diagonal: of a vertical plane's visible part, to be a wall; `min_cut_wall_diagonal`
        where the image's frame cuts it.
    wall_gap: clusters whose points keep closer to a wall than this are part of it.
    min_table_area, min_table_diagonal: of a level surface (m², metres), to carry things if some
        stand on it, as a stool does: smaller ones are a box's lid. With .25 and .7 only tables do.
    max_small_height: of such a surface, metres over the floor; what is higher is a sill or the
        board of a shelf, which carries things with 1.3.
    stride: every so many rows and columns are looked at, of a 640x480 image; others have about
        as many on their grid.
    border_px: width of the image's frame that no object may touch, in pixels of a 640x480 image.
    min_cluster_px: fewer pixels of a 640x480 image are no cluster: of others as many as cover as
        much of the view.
    noise: of inverse depth, 1/m; bands around planes grow by noise·z². A Kinect's disparity
        step is 0.0028.
    follow_sensor: where the recording's sensor is clearly better than `noise` says, bands are
        thinner, the range is longer and the grid finer, see `for_sensor`.
    """

    max_range: float = 4.0
    min_wall_diagonal: float = 1.5
    min_cut_wall_diagonal: float = 1.0
    wall_gap: float = 0.10
    min_table_area: float = 0.07
    min_table_diagonal: float = 0.38
    max_small_height: float = 0.8
    stride: int = 3
    border_px: int = 10
    min_cluster_px: int = 200
    noise: float = 0.0035
    follow_sensor: bool = False
    floor: SupportSettings = field(default=FLOOR)
    table: SupportSettings = field(default=TABLE)

    def __post_init__(self) -> None:
        others = ("floor", "table", "follow_sensor")
        check_positive(self, [name for name in self.__slots__ if name not in others])

    def stride_at(self, scale: float) -> int:
        """Return every how many columns and rows of an image are looked at; scale: its columns
        for one of a 640x480 image.
        """
        usual = self.stride * scale
        stride = max(1, round(usual))
        return stride - 1 if stride > max(1, MAX_COARSER * usual) else stride

    def for_sensor(self, noise: float | None) -> Self:
        """Return the thresholds for a sensor with this noise of inverse depth, 1/m.

        None = not known. Nothing changes unless it is less than half of what is set.
        """
        if not self.follow_sensor or noise is None or noise > 0.5 * self.noise:
            return self
        noise = max(noise, MIN_NOISE)
        reach = min((self.noise / noise) ** 0.5, MAX_REACH)
        return replace(
            self,
            noise=noise,
            max_range=reach * self.max_range,
            stride=min(self.stride, FINE_STRIDE),
            follow_sensor=False,
        )
