"""The border of BMS that jumps: seeds moved inwards at random (Zhang and Sclaroff's program).

With its border handling on, the original floods each Boolean map from seeds of which one in a
hundred lies 5 to 24 pixels inside the image, so that a frame drawn around a picture surrounds
nothing. The numbers come from OpenCV's cv::RNG in its default state, map after map; they are
as much a part of the program as its thresholds, so they are drawn here as there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]

DEFAULT_STATE = 0xFFFFFFFF
MULTIPLIER = np.uint64(4164903690)
LOW_HALF = np.uint64(0xFFFFFFFF)
HALF = np.uint64(32)
FRAME = np.iinfo(np.int32).max


class BorderJumps(NamedTuple):
    """The seeds of one Boolean map after another, as indices into the framed, flat image.

    random: (1,) uint64, the state of the random numbers.
    border, seeds: (2 (H + W),) int32, each border pixel and the seed in its place.
    seeded, seen: number of the map that a pixel was last a seed of, of the search that last
        saw it. The frame counts as seen.
    queue: the pixels that a search found.
    counters: (2,) int32, the numbers of maps and of searches so far.
    """

    random: npt.NDArray[np.uint64]
    border: npt.NDArray[np.int32]
    seeds: npt.NDArray[np.int32]
    seeded: npt.NDArray[np.int32]
    seen: npt.NDArray[np.int32]
    queue: npt.NDArray[np.int32]
    counters: npt.NDArray[np.int32]


def start_jumps(height: int, width: int, *, n_skipped: int = 0) -> BorderJumps:
    """Return the state before the first map; so many random numbers are thrown away first."""
    random = np.array([DEFAULT_STATE], np.uint64)
    for _ in range(n_skipped):
        next_random(random)
    seen = np.full((height + 2, width + 2), FRAME, np.int32)
    seen[1:-1, 1:-1] = 0
    return BorderJumps(
        random=random,
        border=np.empty(2 * (height + width), np.int32),
        seeds=np.empty(2 * (height + width), np.int32),
        seeded=np.zeros(seen.size, np.int32),
        seen=seen.ravel(),
        queue=np.empty(seen.size, np.int32),
        counters=np.zeros(2, np.int32),
    )


@njit(cache=True, nogil=True)
def next_random(random: Array) -> np.uint64:
    """Return the next 32-bit number of OpenCV's cv::RNG as uint64; the state moves on."""
    random[0] = (random[0] & LOW_HALF) * MULTIPLIER + (random[0] >> HALF)
    number: np.uint64 = random[0] & LOW_HALF
    return number


@njit(cache=True, nogil=True)
def _jump(random: Array, longest: int) -> int:
    """Return by how many pixels a seed moves inwards: mostly by none, else by 5 to 24.

    In a tiny image it moves as far as there are pixels; the original reads outside of it.
    """
    high = next_random(random)
    uniform = np.float64((high << HALF) | next_random(random)) * 2.0**-64
    if uniform > 0.99:
        return min(longest, 5 + int(np.int64(next_random(random) % np.uint64(20))))
    return 0


@njit(cache=True, nogil=True)
def draw_seeds(jumps: BorderJumps, height: int, width: int) -> None:
    """Draw a seed for left and right of each row, then for top and bottom of each column."""
    stride = width + 2
    n = 0
    for v in range(1, height + 1):
        for origin, inwards in ((v * stride + 1, 1), (v * stride + width, -1)):
            jumps.border[n] = origin
            jumps.seeds[n] = origin + inwards * _jump(jumps.random, width - 1)
            n += 1
    for u in range(1, width + 1):
        for origin, inwards in ((stride + u, stride), (height * stride + u, -stride)):
            jumps.border[n] = origin
            jumps.seeds[n] = origin + inwards * _jump(jumps.random, height - 1)
            n += 1


@njit(cache=True, nogil=True)
def move_seeds(words: Array, levels: Array, k: int, jumps: BorderJumps) -> None:
    """Correct map k of framed words, made with seeds all along the border, in place.

    A component at the border whose seeds all jumped away is surrounded, one inside that a seed
    jumped into is not. All others stay as they are, so only places around jumps are searched.
    """
    height, width = levels.shape
    draw_seeds(jumps, height - 2, width - 2)
    jumps.counters[0] += 1
    for seed in jumps.seeds:
        jumps.seeded[seed] = jumps.counters[0]
    flat_words, flat_levels = words.ravel(), levels.ravel()
    bit = np.uint64(1) << np.uint64(k)
    for origin, seed in zip(jumps.border, jumps.seeds):  # noqa: B905 - Numba has no strict
        if seed == origin:
            continue
        if flat_words[seed] & bit:
            for index in range(_search(flat_levels, width, k, seed, False, jumps)):
                flat_words[jumps.queue[index]] ^= bit
        for index in range(_search(flat_levels, width, k, origin, True, jumps)):
            flat_words[jumps.queue[index]] |= bit


@njit(cache=True, nogil=True)
def _search(
    levels: Array, width: int, k: int, start: int, is_stopped: bool, jumps: BorderJumps
) -> int:
    """Queue the pixels of map k connected to a pixel; return their number.

    `is_stopped` ends the search with 0 at the first seed.
    """
    jumps.counters[1] += 1
    number, is_above = jumps.counters[1], levels[start] > k
    queue, seen = jumps.queue, jumps.seen
    queue[0], seen[start] = start, number
    n_done, n_found = 0, 1
    while n_done < n_found:
        pixel = queue[n_done]
        n_done += 1
        if is_stopped and jumps.seeded[pixel] == jumps.counters[0]:
            return 0
        for dv in (-width, 0, width):
            for neighbour in range(pixel + dv - 1, pixel + dv + 2):
                if seen[neighbour] < number and (levels[neighbour] > k) == is_above:
                    seen[neighbour] = number
                    queue[n_found] = neighbour
                    n_found += 1
    return n_found
