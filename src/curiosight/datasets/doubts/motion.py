"""Do the poses explain how depth changes from view to view? In which unit, with which axes?

Points of one frame are cast into another. Where unit and poses are right they meet the surface
that the other frame measured, or vanish behind something nearer; they hardly ever hang in what
it saw to be free. Both are counted over many pairs of frames, for the poses as given and for all
other ways they may be meant: world to camera, any of the 48 assignments of camera axes, depth in
another unit than positions. Small or pure motion leaves many of them equal: then none is doubted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.frame import Depth, Frame

Numbers = npt.NDArray[np.float64]

# The given first, then the usual.
N_USUAL_RATIOS = 7
RATIOS = (1.0, 0.2, 5.0, 0.1, 10.0, 0.001, 1000.0, 0.01, 100.0, 0.25, 4.0, 0.125, 8.0, 0.5, 2.0)
# A point meets a surface within this share of its distance: noise, drift, outlines.
TOLERANCE = 0.03
FREE_SHARE = 0.9
# A point in free space speaks against a reading as four that meet a surface speak for it: a floor
# meets itself under any reading that keeps the camera's height. Right recordings have 0 to 7 %.
FREE_WEIGHT = 4.0
N_POINTS_SCREENED, N_POINTS, N_KEPT = 60, 600, 10
# Another reading is believed where it explains this many pairs' worth of points, by this factor
# more than the given one, and in nearly all pairs that tell the two apart.
MIN_SUPPORT = 1.0
MIN_GAIN = 1.4
# Where poses are noisier than the motion, one of 1440 readings fits by chance: an odd one.
MAX_ODDITIES = 1
MIN_SHARE_MET = 0.85
# Of what the given reading leaves unexplained, the most that a better one may leave.
MAX_SHARE_LEFT = 0.5
MIN_VOTES, MIN_SHARE_OF_VOTES, VOTE, FREE_VOTE = 3, 0.8, 0.1, 0.03
TIE = 0.9

# Our axes as they are, of OpenGL, mirrored upwards, mirrored sidewards; forward, left, up.
USUAL_AXES = (
    *(np.diag(signs) for signs in ((1.0, 1, 1), (1, -1, -1), (1, -1, 1), (-1, 1, 1))),
    np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]),
)


@dataclass(frozen=True, slots=True)
class Reading:
    """A way to read a recording's poses, and its depth beside them.

    axes: (3, 3) signed permutation, its columns our camera's axes (right, down, forward) in
        the axes that the recording gives its camera. ratio: by which depth must be multiplied
        to have the unit of positions.
    """

    is_inverted: bool
    axes: Numbers
    ratio: float

    @property
    def is_plain(self) -> bool:
        """Tell whether the poses are read as they stand, whatever the unit."""
        return not self.is_inverted and bool((self.axes == np.eye(3)).all())

    @property
    def n_oddities(self) -> int:
        """Count what makes the reading unlikely beforehand: two faults, odd axes, an odd unit."""
        has_usual_axes = any((self.axes == usual).all() for usual in USUAL_AXES)
        has_usual_ratio = self.ratio in RATIOS[:N_USUAL_RATIOS]
        return (
            (not self.is_plain and self.ratio != 1) + (not has_usual_axes) + (not has_usual_ratio)
        )


@dataclass(frozen=True, slots=True)
class Verdict:
    """What motion tells: the best reading if the given one is contradicted, else None.

    share_given, share_best: of the points that are not hidden, those that meet a surface.
    knows_unit: whether the given unit is supported and every other contradicted.
    """

    best: Reading | None
    share_given: float
    share_best: float
    knows_unit: bool


def judge_motion(frames: Sequence[Frame], seed: int = 0) -> Verdict | None:
    """Compare all readings of the poses on frames with depth and pose; None without evidence."""
    rng = np.random.default_rng(seed)
    posed = [frame for frame in frames if frame.T_world_camera is not None]
    few = [_points(frame, N_POINTS_SCREENED, rng) for frame in posed]
    many = [_points(frame, N_POINTS, rng) for frame in posed]
    pairs = [
        (i, j)
        for i, j in product(range(len(posed)), repeat=2)
        if i != j and min(len(few[i]), len(few[j])) == N_POINTS_SCREENED
    ]
    if not pairs:
        return None
    screened = _Counts.of(posed, few, pairs, _ways())
    kept = screened.foremost(N_KEPT)
    counts = _Counts.of(posed, many, pairs, [_ways()[way] for way in kept])
    return counts.verdict()


def _ways() -> list[tuple[bool, Numbers]]:
    """Return inverted-or-not and axes, the usual ones first."""
    others = [
        np.eye(3)[:, order] * signs
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    axes = list(USUAL_AXES)
    axes += [a for a in others if not any((a == b).all() for b in axes)]
    return [(is_inverted, a) for a in axes for is_inverted in (False, True)]


@dataclass(frozen=True, slots=True)
class _Counts:
    """Shares of points that meet a surface and that hang free, (pair, way, ratio)."""

    ways: list[tuple[bool, Numbers]]
    met: Numbers
    free: Numbers

    @staticmethod
    def of(
        frames: Sequence[Frame],
        points: Sequence[Numbers],
        pairs: Sequence[tuple[int, int]],
        ways: list[tuple[bool, Numbers]],
    ) -> _Counts:
        met, free = np.zeros((2, len(pairs), len(ways), len(RATIOS)))
        for row, (i, j) in enumerate(pairs):
            camera, depth = frames[j].camera, frames[j].depth
            rotations, shifts = _relative(frames[i], frames[j], ways)
            if camera is None or depth is None:
                continue  # gave no points, so is in no pair
            intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
            inverse = 1 / np.array(RATIOS)
            _count(points[i], depth, intrinsics, rotations, shifts, inverse, met[row], free[row])
            met[row] /= len(points[i])
            free[row] /= len(points[i])
        return _Counts(ways, met, free)

    @property
    def scores(self) -> Numbers:
        """Return what each reading explains, in pairs' worth of points, (way, ratio)."""
        scores: Numbers = self.met.sum(axis=0) - FREE_WEIGHT * self.free.sum(axis=0)
        return scores

    def share_met(self, way: int, ratio: int) -> float:
        met, free = self.met[:, way, ratio].sum(), self.free[:, way, ratio].sum()
        return float(met / max(met + free, 1e-9))

    def foremost(self, n: int) -> list[int]:
        """Return the given way and those with the best scores, in their own order."""
        order = np.argsort(-self.scores.max(axis=1), kind="stable")
        return sorted({0, *order[:n].tolist()})

    def verdict(self) -> Verdict | None:
        scores = self.scores
        if scores.max() < MIN_SUPPORT:
            return None
        # Of the ways that are as good the most usual; likewise of units.
        way = int(np.argmax(scores.max(axis=1) >= TIE * scores.max()))
        enough = TIE * scores[way].max()
        usual = int(scores[way, :N_USUAL_RATIOS].argmax())
        ratio = usual if scores[way, usual] >= enough else int(scores[way].argmax())
        ratio = 0 if scores[way, 0] >= enough else ratio
        share_given, share_best = self.share_met(0, 0), self.share_met(way, ratio)
        worth = (self.met - FREE_WEIGHT * self.free).clip(min=0)
        gain = worth[:, way, ratio] - worth[:, 0, 0]
        # Less shift means more overlap: that alone is no argument for the given reading.
        is_against = (gain < -VOTE) & (self.free[:, way, ratio] > FREE_VOTE)
        n_for, n_against = int((gain > VOTE).sum()), int(is_against.sum())
        best = Reading(self.ways[way][0], self.ways[way][1], RATIOS[ratio])
        is_believed = (
            best.n_oddities <= MAX_ODDITIES
            and scores[way, ratio] > MIN_GAIN * max(scores[0, 0], 0)
            and share_best >= MIN_SHARE_MET
            and 1 - share_best < MAX_SHARE_LEFT * (1 - share_given)
            and n_for >= max(MIN_VOTES, MIN_SHARE_OF_VOTES * (n_for + n_against))
        )
        others = scores[0, 1:5].max()  # the wrong units that happen
        knows_unit = scores[0, 0] >= MIN_SUPPORT and scores[0, 0] > MIN_GAIN * max(others, 0)
        return Verdict(best if is_believed else None, share_given, share_best, bool(knows_unit))


def _points(frame: Frame, n: int, rng: np.random.Generator) -> Numbers:
    """Return up to n points of the frame, (n, 3) in its camera and its unit of depth."""
    camera, depth = frame.camera, frame.depth
    if camera is None or depth is None:
        return np.empty((0, 3))
    seen = np.flatnonzero(depth > 0)
    v, u = np.divmod(rng.choice(seen, min(n, len(seen)), replace=False), depth.shape[1])
    z = depth[v, u].astype(np.float64)
    return np.column_stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z])


def _relative(
    first: Frame, second: Frame, ways: list[tuple[bool, Numbers]]
) -> tuple[Numbers, Numbers]:
    """Return rotations (n, 3, 3) and shifts (n, 3) from the first camera to the second."""
    a, b = np.asarray(first.T_world_camera), np.asarray(second.T_world_camera)
    is_inverted = np.array([inverted for inverted, _ in ways])[:, None, None]
    between = np.where(is_inverted, b @ np.linalg.inv(a), np.linalg.inv(b) @ a)
    axes = np.array([axes for _, axes in ways])
    turned_back = axes.transpose(0, 2, 1)
    rotations = turned_back @ between[:, :3, :3] @ axes
    return rotations, np.ascontiguousarray((turned_back @ between[:, :3, 3:])[..., 0])


@njit(cache=True, nogil=True)
def _count(
    points: Numbers,
    depth: Depth,
    intrinsics: tuple[float, float, float, float],
    rotations: Numbers,
    shifts: Numbers,
    scales: Numbers,
    met: Numbers,
    free: Numbers,
) -> None:
    """Count the points that meet a surface of `depth` and that hang free before it.

    scales: of the shifts, one a ratio; met, free: (way, ratio), added to.
    """
    fx, fy, cx, cy = intrinsics
    height, width = depth.shape
    for way in range(len(rotations)):
        r, t = rotations[way], shifts[way]
        for x, y, z in points:
            turned_x = r[0, 0] * x + r[0, 1] * y + r[0, 2] * z
            turned_y = r[1, 0] * x + r[1, 1] * y + r[1, 2] * z
            turned_z = r[2, 0] * x + r[2, 1] * y + r[2, 2] * z
            for ratio in range(len(scales)):
                scale = scales[ratio]
                z_there = turned_z + t[2] * scale
                if z_there <= 1e-9:
                    continue
                u = fx * (turned_x + t[0] * scale) / z_there + cx + 0.5
                v = fy * (turned_y + t[1] * scale) / z_there + cy + 0.5
                if not (0 <= u < width and 0 <= v < height):
                    continue
                measured = depth[int(v), int(u)]
                if abs(z_there - measured) < TOLERANCE * measured:
                    met[way, ratio] += 1
                elif z_there < FREE_SHARE * measured:
                    free[way, ratio] += 1
