"""When a run that is under way writes its model, so that a kill does not lose all it learned."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Keeping:
    """Tell when the model is to be written: after so many looks or seconds, what comes first.

    It depends on the clock, and so nothing else may depend on it: writing changes no result.

    every_looks, every_s: since the model was written last.
    max_share: of the time that writing may take. Where it takes longer, on a slow disk say, it
        is done as much less often.
    expected_s: that the first writing will take.
    """

    def __init__(
        self,
        *,
        every_looks: int = 50,
        every_s: float = 30.0,
        max_share: float = 0.02,
        expected_s: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if every_looks < 1:
            raise ValueError(f"every_looks: expected 1 or more, got {every_looks}")
        if not every_s > 0:
            raise ValueError(f"every_s: expected a positive number, got {every_s}")
        if not 0 < max_share <= 1:
            raise ValueError(f"max_share: expected a number in (0, 1], got {max_share}")
        self._every_looks = every_looks
        self._every_s = every_s
        self._max_share = max_share
        self._clock = clock
        self._n_looks = 0
        self._since = clock()
        self._wait_s = expected_s / max_share

    def is_due(self) -> bool:
        """Count a look, and tell whether the model is to be written after it."""
        self._n_looks += 1
        passed_s = self._clock() - self._since
        is_time = self._n_looks >= self._every_looks or passed_s >= self._every_s
        return is_time and passed_s >= self._wait_s

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Take the time while the model is written."""
        start = self._clock()
        yield
        self._n_looks = 0
        self._since = self._clock()
        self._wait_s = (self._since - start) / self._max_share
