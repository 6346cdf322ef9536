"""The numbers of the paper's segmentation, each with where it is from.

The paper prints the size of objects and the range (sec. II-A.2, III-A). The rest is from two
parameter files of that time, which its authors left with their later code: one for the robot's
floor, one for the tables of RGB-D Scenes. "Later code": what only that says. "Ours": in neither.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from curiosight.teacher.settings import check_positive


@dataclass(frozen=True, slots=True)
class PaperSupport:
    """What differs between a floor and a table, metres; the defaults are the floor's.

    min_plane_px: pixels of a 640×480 image that the main plane must hold; scaled for others.
    min_level_share: of the points nearest to the main plane, those whose own surface lies in it;
        with fewer it cuts through things and is no support (later code, which ignored it).
    min_height, max_height: where objects are over the main plane; what is lower counts as it.
    leaf: side of a voxel. tolerance: distance up to which voxels belong together.
    min_size, max_size: diagonal of an object's box, 0.10 to 1.50 on the floor (sec. II-A.2).
    """

    min_plane_px: int = 50_000
    min_level_share: float = 0.3
    min_height: float = 0.05
    max_height: float = 2.0
    leaf: float = 0.06
    tolerance: float = 0.10
    min_size: float = 0.10
    max_size: float = 1.50

    def __post_init__(self) -> None:
        check_positive(self, self.__slots__)
        for low, high in (("min_height", "max_height"), ("min_size", "max_size")):
            if getattr(self, low) >= getattr(self, high):
                raise ValueError(
                    f"{low}: expected less than {high} {getattr(self, high)}, "
                    f"got {getattr(self, low)}"
                )

    @property
    def voxel_limits(self) -> tuple[float, float]:
        """How many voxels an object has at least and at most: half its square, and its square."""
        return 0.5 * (self.min_size / self.leaf) ** 2, (self.max_size / self.leaf) ** 2


PAPER_FLOOR = PaperSupport()
PAPER_TABLE = PaperSupport(
    min_plane_px=5_000,
    min_level_share=0.6,
    min_height=0.01,
    max_height=1.0,
    leaf=0.02,
    tolerance=0.03,
    min_size=0.08,
    max_size=0.80,
)


@dataclass(frozen=True, slots=True)
class PaperSettings:
    """All thresholds of the paper's teacher, in metres unless the name says otherwise.

    max_range: nothing farther along z is salient (sec. III-A).
    plane_distance, wall_distance: of the points that belong to a plane, from it.
    n_hypotheses: planes that a RANSAC draws (later code). seed: where its chance starts, anew in
        every frame.
    camera_tilt_deg: how far down the camera looks, more or less: 10° on the robot, 40° over a
        table. max_tilt_deg: how far the main plane may be from that. Both ours: without them it
        may be a wall.
    min_normal_cosine: from a plane's normal to that of a point's own surface, for the point to
        speak for the plane (later code).
    max_wall_cosine: between a wall's normal and the main plane's, to be perpendicular.
    min_wall_diagonal: of the box around a wall's points.
    n_walls: planes that are tried (ours).
    border_px: width of the image's frame that no object may touch, not with one pixel.
    border_distance: to the range, that no object may come to.
    """

    max_range: float = 4.0
    plane_distance: float = 0.05
    wall_distance: float = 0.10
    n_hypotheses: int = 100
    seed: int = 0
    camera_tilt_deg: float = 25.0
    max_tilt_deg: float = 30.0
    min_normal_cosine: float = 0.9
    max_wall_cosine: float = 0.05
    min_wall_diagonal: float = 1.5
    n_walls: int = 4
    border_px: int = 10
    border_distance: float = 0.02
    floor: PaperSupport = field(default=PAPER_FLOOR)
    table: PaperSupport = field(default=PAPER_TABLE)

    def __post_init__(self) -> None:
        others = ("seed", "camera_tilt_deg", "floor", "table")
        check_positive(self, [name for name in self.__slots__ if name not in others])
        if self.seed < 0:
            raise ValueError(f"seed: expected 0 or more, got {self.seed}")
