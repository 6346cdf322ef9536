"""Do outlines in depth lie on the edges in colour, or beside them?

Where a near surface ends before a far one, colour mostly has an edge of the same direction. For
every shift and scale of the outlines it is summed how strong the edges under them are and how
parallel; edges of any other direction cancel out, so that only the right place stands out. Depth
that was never registered is seen from another place and through another lens: its outlines are
shifted and, about the image's middle, scaled. Frames of one recording agree on that, chance does
not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from curiosight.frame import Depth, Frame, Rgb

Scores = npt.NDArray[np.float32]
Complex = npt.NDArray[np.complex64]

# Images are brought to this size along their longer side; all pixels here are of that.
SIDE = 320
# A near surface ends where depth jumps by this share; beyond this many times the median distance
# readings are noise that looks like outlines. Holes up to this width are shadows of what is near.
MIN_JUMP, FARTHEST, WIDEST_HOLE = 0.06, 1.5, 10
MIN_POINTS, MAX_POINTS = 30, 1000
# Outlines of one cell of the image are shifted as one.
CELL, LARGEST_SHIFT, REACH = 20, 12, 15
UNSCALED = 7
SCALES = (np.arange(16) - UNSCALED) * 0.02 + 1
# Where none of these stands out, lenses that differ by more are tried: a RealSense's by 1.6.
ZOOMS = (1.28, 1.6, 0.78, 0.62)
# As given, give or take a scale of 0.02 and a shift of 2: outlines of right ones differ by that.
NEAR_SCALES = slice(UNSCALED - 1, UNSCALED + 2)
NEAR_SHIFTS = slice(LARGEST_SHIFT - 2, LARGEST_SHIFT + 3)
# What is believed: it stands out by so many standard deviations (depth of another scene: up to
# 3.9), agrees so well (another scene: 0.1; right recordings: mostly 0.3 to 0.5), in most frames
# better than as given, and by a part of what it stands out by.
MIN_DEVIATIONS, MIN_AGREEMENT, MIN_GAIN = 4.3, 0.15, 0.1
MIN_FRAMES, MIN_SHARE_OF_FRAMES = 3, 0.8
MIN_DISTANCE = 2.5
# As given they agree well enough that no other lens is tried (another scene: up to 0.07).
MIN_AGREEMENT_GIVEN = 0.1


@dataclass(frozen=True, slots=True)
class Misplacement:
    """Where outlines of depth lie beside the edges of colour.

    distance_px: how far, in the mean. scale: by which depth must be scaled about the image's
    middle; shift_px: (right, down), by which it must then be moved. Pixels are colour's.
    given, best: agreement of outlines and edges as they are, and then; 1 = perfect, 0 = chance.
    """

    distance_px: float
    scale: float
    shift_px: tuple[float, float]
    given: float
    best: float


@dataclass(frozen=True, slots=True)
class _Look:
    """One frame's outlines and edges.

    u, v: (n,) columns and rows of outline points from the image's middle. directions: (n,) of
    outlines, unit complex numbers of twice the angle, so that opposite ones are the same.
    edges: (H, W) likewise, their length the strength from 0 to 1.
    """

    u: npt.NDArray[np.float64]
    v: npt.NDArray[np.float64]
    directions: Complex
    edges: Complex


def find_misplacement(frames: Sequence[Frame]) -> Misplacement | None:
    """Return where depth's outlines are beside colour's edges; None without clear evidence."""
    looks = list(_looks(frames))
    if len(looks) < MIN_FRAMES:
        return None
    plain = _agreements(looks, 1.0)
    near = plain[:, NEAR_SCALES, NEAR_SHIFTS, NEAR_SHIFTS].max(axis=(1, 2, 3))
    if near.mean() > MIN_AGREEMENT_GIVEN and _gain(plain, near) <= MIN_GAIN:
        return None
    zoom, scores = 1.0, plain
    place = _believed_place(plain, near)
    if place is None or place[0] in (0, len(SCALES) - 1):
        zoomed = [(1.0, plain), *((zoom, _agreements(looks, zoom)) for zoom in ZOOMS)]
        zoom, scores = max(zoomed, key=lambda pair: float(pair[1].mean(axis=0).max()))
        place = _believed_place(scores, near)
    if place is None:
        return None
    scale = float(zoom * SCALES[place[0]])
    down, right = (index - LARGEST_SHIFT for index in place[1:])
    distance = _mean_distance(looks, scale, right, down)
    if distance < MIN_DISTANCE:
        return None
    pixels = max(frames[0].rgb.shape[:2]) / SIDE
    shift = right * pixels, down * pixels
    best = float(scores.mean(axis=0)[place])
    return Misplacement(distance * pixels, scale, shift, float(near.mean()), best)


def _mean_distance(looks: Sequence[_Look], scale: float, right: int, down: int) -> float:
    moves = [np.hypot((scale - 1) * look.u + right, (scale - 1) * look.v + down) for look in looks]
    return float(np.concatenate(moves).mean())


def _believed_place(scores: Scores, near: Scores) -> tuple[int, int, int] | None:
    """Return the place (scale, down, right) in (frame, …) `scores` that is believed, if one is.

    near: (frame,), what outlines as given reach.
    """
    together = scores.mean(axis=0)
    scale, down, right = (int(k) for k in np.unravel_index(together.argmax(), together.shape))
    best = float(together.max())
    around = scores[:, scale, max(down - 1, 0) : down + 2, max(right - 1, 0) : right + 2]
    share = float((around.max(axis=(1, 2)) > near).mean())
    is_believed = (
        best - float(together.mean()) > MIN_DEVIATIONS * float(together.std())
        and best > MIN_AGREEMENT
        and _gain(scores, near) > MIN_GAIN
        and share >= MIN_SHARE_OF_FRAMES
    )
    return (scale, down, right) if is_believed else None


def _gain(scores: Scores, near: Scores) -> float:
    """Return how much better the best place is than as given, as a part of what it stands out."""
    together = scores.mean(axis=0)
    best = float(together.max())
    return (best - float(near.mean())) / max(best - float(together.mean()), 1e-9)


def _looks(frames: Sequence[Frame]) -> Iterator[_Look]:
    """Look at the frames that have enough outlines."""
    rng = np.random.default_rng(0)
    for frame in frames:
        if frame.depth is None:
            continue
        depth = _filled(_brought(np.nan_to_num(frame.depth, posinf=0), cv2.INTER_NEAREST))
        v, u = np.nonzero(_is_outline(depth))
        if len(v) < MIN_POINTS:
            continue
        kept = rng.permutation(len(v))[:MAX_POINTS]
        v, u = v[kept], u[kept]
        inverse = np.divide(1, depth, out=np.zeros_like(depth), where=depth > 0)
        across = _directions(cv2.GaussianBlur(inverse, (0, 0), 1)[..., None])[v, u]
        directions = (across / np.maximum(np.abs(across), 1e-12)).astype(np.complex64)
        middle = (np.array(depth.shape) - 1) / 2
        yield _Look(u - middle[1], v - middle[0], directions, _edges(frame.rgb))


def _brought(image: npt.NDArray[np.generic], interpolation: int) -> npt.NDArray[np.float32]:
    height, width = image.shape[:2]
    ratio = SIDE / max(height, width)
    size = max(round(ratio * width), 1), max(round(ratio * height), 1)
    return np.asarray(cv2.resize(image, size, interpolation=interpolation), np.float32)


def _filled(depth: Depth) -> Depth:
    """Fill narrow holes of a row with the farther side: shadows lie behind what throws them."""
    is_read = depth > 0
    columns = np.arange(depth.shape[1])
    left = np.maximum.accumulate(np.where(is_read, columns, -1), axis=1)
    right = np.where(is_read, columns, len(columns))
    right = np.minimum.accumulate(right[:, ::-1], axis=1)[:, ::-1]
    is_narrow = (left >= 0) & (right < len(columns)) & (right - left <= WIDEST_HOLE)
    sides = [
        np.take_along_axis(depth, ends.clip(0, len(columns) - 1), axis=1) for ends in (left, right)
    ]
    return np.where(is_narrow, np.maximum(*sides), 0).astype(np.float32)


def _is_outline(depth: Depth) -> npt.NDArray[np.bool_]:
    """Tell the pixels of near surfaces that end before far ones."""
    square = np.ones((3, 3), np.uint8)
    near, far = cv2.erode(depth, square), cv2.dilate(depth, square)
    jumps = (near > 0) & (far > (1 + MIN_JUMP) * near) & (2 * depth < near + far)
    if not jumps.any():
        return np.asarray(jumps)
    return np.asarray(jumps & (depth < FARTHEST * np.median(depth[depth > 0])))


def _edges(rgb: Rgb) -> Complex:
    shrinks = max(rgb.shape[:2]) > SIDE
    small = _brought(rgb, cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
    across = _directions(cv2.GaussianBlur(small, (0, 0), 1))
    strength = np.sqrt(np.abs(across))
    usual = max(float(np.percentile(strength, 80)), 1.0)
    # Of length 1 - usual / (strength + usual).
    return np.asarray(across / np.maximum(strength * (strength + usual), 1e-9), np.complex64)


def _directions(image: npt.NDArray[np.float32]) -> Complex:
    """Return gradients of (H, W, channels), squared as complex numbers and summed: (H, W)."""
    right = cv2.Sobel(image, cv2.CV_32F, 1, 0).reshape(image.shape)
    down = cv2.Sobel(image, cv2.CV_32F, 0, 1).reshape(image.shape)
    return np.asarray(((right + 1j * down) ** 2).sum(axis=2), np.complex64)


def _agreements(looks: Sequence[_Look], zoom: float) -> Scores:
    """Return how outlines agree with edges, (frame, scale, down, right), scaled by `zoom`."""
    return np.stack([_agreement(look, zoom) for look in looks])


def _agreement(look: _Look, zoom: float) -> Scores:
    """Return a frame's mean agreement for all scales and shifts, (scale, down, right)."""
    height, width = look.edges.shape
    u = np.rint(zoom * look.u + (width - 1) / 2).astype(np.int64)
    v = np.rint(zoom * look.v + (height - 1) / 2).astype(np.int64)
    is_inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    u, v, directions = u[is_inside], v[is_inside], look.directions[is_inside]
    n_shifts = 2 * LARGEST_SHIFT + 1
    total = np.zeros((len(SCALES), n_shifts, n_shifts), np.float32)
    if len(u) < MIN_POINTS:
        return total
    columns = -(-width // CELL)
    cells, of_cell = np.unique(v // CELL * columns + u // CELL, return_inverse=True)
    in_cells = _shifted(look.edges, v, u, directions, of_cell)
    middles = (np.column_stack([cells // columns, cells % columns]) + 0.5) * CELL
    middles -= (height / 2, width / 2)
    # A cell that a scale moves farther than REACH says nothing for it.
    border = 2 * REACH
    in_cells = np.pad(in_cells, ((0, 0), (border, border), (border, border)))
    start = border + REACH - LARGEST_SHIFT
    for row, scale in enumerate(SCALES):
        offsets = np.rint((scale - 1) * middles).astype(int).clip(-start, start) + start
        for cell, (down, right) in enumerate(offsets):
            total[row] += in_cells[cell, down : down + n_shifts, right : right + n_shifts]
    smooth = np.stack([cv2.blur(scores, (3, 3)) for scores in total])
    return np.asarray(smooth / len(u), np.float32)


def _shifted(
    edges: Complex,
    v: npt.NDArray[np.int64],
    u: npt.NDArray[np.int64],
    directions: Complex,
    of_cell: npt.NDArray[np.int64],
) -> Scores:
    """Sum for each cell how its outlines agree with edges, (cell, down, right) up to REACH."""
    side = 2 * REACH + 1
    members = np.zeros((int(of_cell.max()) + 1, len(v)), np.float32)
    members[of_cell, np.arange(len(v))] = 1
    total = np.zeros((len(members), side * side), np.float32)
    for image, weights in ((edges.real, directions.real), (edges.imag, directions.imag)):
        # The real part of one number times the other's conjugate: the cosine of twice the angle.
        windows = sliding_window_view(np.pad(image, REACH), (side, side))[v, u]
        total += (members * weights) @ windows.reshape(len(v), -1)
    return total.reshape(-1, side, side)
