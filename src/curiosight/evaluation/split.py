"""Which frames are learned from and which are kept for testing."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.int64]
SplitKind = Literal["frames", "blocks"]
Split = tuple[Indices, Indices]


def every_nth(n_frames: int, every: int, *, gap: int = 3) -> Split:
    """Return the frames to learn from and those to test on: every `every`-th, from the first.

    gap: neighbours of a test frame on each side that are not learned from either, because
        they show nearly the same.
    """
    if every < 1 or gap < 0:
        raise ValueError(f"every, gap: expected 1 and 0 or more, got {every}, {gap}")
    if n_frames < gap + 2:
        raise ValueError(
            f"n_frames: expected {gap + 2} or more to keep some out with a gap of {gap}, "
            f"got {n_frames}"
        )
    test = np.arange(0, n_frames, every)
    training = away_from(test, n_frames, gap)
    if len(training) == 0:
        raise ValueError(
            f"test-every: expected more than {2 * gap + 1} for {n_frames} frames with a gap of "
            f"{gap}, or nothing is left to learn from; got {every}"
        )
    return training, test


def make_folds(
    n_frames: int, n_folds: int, kind: SplitKind, rng: np.random.Generator, *, gap: int = 3
) -> list[Split]:
    """Return each fold's frames to learn from and to test on; every frame is tested once.

    kind: "frames" deals them out at random, for recordings of separate scenes; "blocks" cuts
        the recording into stretches, with `gap` frames beside each left out of learning.
    """
    if gap < 0:
        raise ValueError(f"gap: expected 0 or more, got {gap}")
    if kind not in get_args(SplitKind):
        raise ValueError(f"split: expected {' or '.join(get_args(SplitKind))}, got {kind!r}")
    if not 2 <= n_folds <= n_frames:
        raise ValueError(f"folds: expected 2 to {n_frames} for {n_frames} frames, got {n_folds}")
    order: npt.NDArray[Any] = np.arange(n_frames)
    if kind == "frames":
        order, gap = rng.permutation(n_frames), 0
    parts = [np.sort(part) for part in np.array_split(order, n_folds)]
    splits = [(away_from(test, n_frames, gap), test) for test in parts]
    if not all(len(training) for training, _ in splits):
        raise ValueError(
            f"gap: expected less for {n_folds} blocks of {n_frames} frames, or a fold has "
            f"nothing to learn from; got {gap}"
        )
    return splits


def away_from(test: Indices, n_frames: int, gap: int) -> Indices:
    """Return the frames farther than `gap` from every test frame."""
    is_near = np.zeros(n_frames, np.bool_)
    for offset in range(-gap, gap + 1):
        near = test + offset
        is_near[near[(near >= 0) & (near < n_frames)]] = True
    return np.flatnonzero(~is_near)
