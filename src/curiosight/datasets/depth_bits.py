"""Tell whether the bits of depth files are rotated, as SUN3D and SUN RGB-D store them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import Raw, read_raw_depth

ROTATION = 3
N_FILES = 3
# Neighbours that differ; with fewer nothing can be said.
MIN_PAIRS = 50
# Of those, the share whose last three bits differ: of plain numbers about 7 in 8, of rotated
# ones next to none, as those bits are then the three highest of the distance.
MAX_SHARE_CHANGED = 0.25


def are_rotated(images: Iterable[Raw]) -> bool:
    """Tell whether (h, w) whole numbers of depth are rotated by three bits to the left.

    Told by what changes between one pixel and the next.
    """
    n_pairs = n_changed = 0
    for raw in images:
        pairs, changed = _changes(raw)
        n_pairs += pairs
        n_changed += changed
    return n_pairs >= MIN_PAIRS and n_changed < MAX_SHARE_CHANGED * n_pairs


def rotated_bits(files: Sequence[Path]) -> int:
    """Return how far the 16 bits of depth files are rotated to the left: 3, or 0 for plain.

    Told by a few of the files.
    """
    step = max(len(files) // N_FILES, 1)
    return ROTATION if are_rotated(_whole_numbers(files[::step])) else 0


def _whole_numbers(files: Sequence[Path]) -> Iterator[Raw]:
    for file in files:
        try:
            raw = read_raw_depth(file)
        except UnreadableFile:
            continue
        if raw.dtype == np.uint16:
            yield raw


def _changes(raw: Raw) -> tuple[int, int]:
    """Return how many neighbours differ, and how many of those in their last three bits."""
    left, right = raw[:, :-1], raw[:, 1:]
    differ = (left != right) & (left > 0) & (right > 0)
    low = (1 << ROTATION) - 1
    return int(differ.sum()), int((differ & ((left & low) != (right & low))).sum())
