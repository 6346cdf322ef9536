"""Memory of many threads: keep the C library from hoarding it."""

from __future__ import annotations

import ctypes
import sys
from contextlib import suppress

# Of glibc's `mallopt`: how many heaps threads share.
_M_ARENA_MAX = -8
N_HEAPS = 2


def share_heaps(n_heaps: int = N_HEAPS) -> None:
    """Let all threads share a few heaps, where the C library can be told.

    By itself glibc gives each thread a heap of its own, up to eight a core, and what is freed in
    one is of no use to another: over hours that is some hundred megabytes more. To be called
    before threads are started.
    """
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):  # another C library
            ctypes.CDLL(None).mallopt(_M_ARENA_MAX, n_heaps)
