"""Graph-based visual saliency: where a random walk ends up that prefers steps to what differs.

Harel, Koch and Perona, "Graph-based visual saliency", NIPS 2006, as in their toolbox (release of
July 2012, default parameters). The toolbox concentrates the activation by a power where the paper
does so by a walk on a second graph.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.evaluation.baselines.dkl_colour import dkl_colour
from curiosight.evaluation.baselines.feature_channels import gabor_energy, pyramid
from curiosight.evaluation.baselines.maps import Saliency, check_rgb
from curiosight.evaluation.baselines.master_map import finished, master_size, small_map
from curiosight.frame import Rgb

Array = npt.NDArray[Any]
Channel = Literal["colour", "intensity", "orientation"]

SMALLEST_SIDE = 128
CONCENTRATING_POWER = 1.5
SIGMA_SHARE = 0.15
BLUR_SHARE = 0.02
LONGEST_WALK = 500  # steps; pictures need 10 to 100


def gbvs(
    rgb: Rgb,
    channels: Sequence[Channel] = ("colour", "intensity", "orientation"),
    levels: Sequence[int] = (2, 3, 4),
    angles_deg: Sequence[float] = (0, 45, 90, 135),
    longest_side: int = 32,
    tolerance: float = 1e-4,
) -> Saliency:
    """Return the graph-based saliency, (H, W) in [0, 1].

    Every feature of every level (level 2 has a quarter of the image's width) becomes a map whose
    longer side has `longest_side` pixels. Its walk is followed until a step changes the
    probabilities by `tolerance` or less (Euclidean), which is kept because the limit differs
    from it by up to 2 %. A map without contrast adds nothing. Raises ValueError where a side
    of the image has less than 128 pixels, as the original does.
    """
    check_rgb(rgb)
    if min(rgb.shape[:2]) < SMALLEST_SIDE:
        raise ValueError(
            f"rgb: expected sides of at least {SMALLEST_SIDE} pixels, got {rgb.shape[:2]}"
        )
    if not channels or set(channels) - set(get_args(Channel)):
        raise ValueError(f"channels: expected some of {get_args(Channel)}, got {channels}")
    if not levels or min(levels) < 0:
        raise ValueError(f"levels: expected numbers from 0, got {levels}")
    size = master_size(rgb.shape[:2], longest_side)
    closeness = closeness_table(*size)
    master = np.zeros(size)
    for feature in _features(rgb, channels, levels, angles_deg):
        contrast = small_map(feature, size)
        if contrast.any():
            master += visits(contrast, closeness, tolerance) ** CONCENTRATING_POWER
    return finished(master, rgb.shape[:2], BLUR_SHARE)


def gbvs_fast(rgb: Rgb) -> Saliency:
    """Return GBVS as the toolbox's fast mode does, (H, W) in [0, 1].

    Colour and two directions, of one level, on a map of 24 pixels, and a shorter walk.
    """
    return gbvs(
        rgb,
        channels=("colour", "orientation"),
        levels=(3,),
        angles_deg=(0, 90),
        longest_side=24,
        tolerance=3e-3,
    )


def _features(
    rgb: Rgb, channels: Sequence[Channel], levels: Sequence[int], angles_deg: Sequence[float]
) -> Iterator[Array]:
    """Yield the (h, w) feature maps, of sizes that differ with the level."""
    all_levels = pyramid(rgb, max(levels))
    for red, green, blue, intensity in (all_levels[index] for index in levels):
        if "colour" in channels:
            yield from dkl_colour(red, green, blue)
        if "intensity" in channels:
            yield intensity
        if "orientation" in channels:
            yield from (gabor_energy(intensity, angle) for angle in angles_deg)


def closeness_table(height: int, width: int) -> Array:
    """Return how readily a walk steps from column u by dv rows to column u', (w, 2h, w) float64.

    The indices are u, h + dv and u', so that all pixels of the map, seen from pixel (v, u), are
    consecutive: `table[u, h - v : 2 * h - v]`.
    """
    sigma = SIGMA_SHARE * (height + width) / 2
    columns = np.arange(width)
    across = columns[:, None, None] - columns
    down = np.arange(-height, height)[:, None]
    return np.exp(-(across**2 + down**2) / (2 * sigma**2))


def visits(contrast: Array, closeness: Array, tolerance: float) -> Array:
    """Return how often a walk over the (h, w) map visits each pixel; they sum to 1.

    A step from i to j is the likelier the closer they are and the more they differ. The walk
    starts anywhere, and ends once a step changes the probabilities by `tolerance` or less. The
    map must not be uniform.
    """
    weight_of_steps = _flow(contrast, np.ones_like(contrast), closeness)
    probabilities = np.full(contrast.shape, 1 / contrast.size)
    for _ in range(LONGEST_WALK):
        before = probabilities
        probabilities = _flow(contrast, before / weight_of_steps, closeness)
        if np.linalg.norm(probabilities - before) <= tolerance:
            break
    else:
        # Between two uniform areas the original walks to and fro for ever. On average it is at
        # a known limit: steps from i to j weigh as much as from j to i, so each pixel's share of
        # the visits is that of its steps' weight.
        probabilities = weight_of_steps
    shares: Array = probabilities / probabilities.sum()
    return shares


@njit(cache=True, nogil=True)
def _flow(contrast: Array, mass: Array, closeness: Array) -> Array:
    """Return sum_j closeness_ij |contrast_i - contrast_j| mass_j for all pixels i, (h, w).

    The matrix of all pairs is never stored: fetching it from memory would take longer than
    making it. The pixels j go in pairs, upper and lower, which halves what is read and written.
    """
    height, width = contrast.shape
    n = height * width
    values = contrast.ravel()
    flow = np.zeros(n)
    for u in range(width):
        seen_from = closeness[u].ravel()
        for v in range(0, height, 2):
            w = min(v + 1, height - 1)
            upper, lower = contrast[v, u], contrast[w, u]
            upper_mass, lower_mass = mass[v, u], mass[w, u] if w > v else 0.0
            from_upper = seen_from[(height - v) * width :][:n]
            from_lower = seen_from[(height - w) * width :][:n]
            for i in range(n):
                by_upper = upper_mass * from_upper[i] * abs(values[i] - upper)
                by_lower = lower_mass * from_lower[i] * abs(values[i] - lower)
                flow[i] += by_upper + by_lower
    return flow.reshape(height, width)
