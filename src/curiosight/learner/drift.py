"""When a place is no longer what was learned of it: an error that has risen and stays."""

from __future__ import annotations

from dataclasses import dataclass

# Errors of single frames differ much: a rise of this much is none, and what exceeds it must
# have summed up to this before it is one. At a spread of 0.25 and a true rise of 0.3 that is
# fifteen frames, and once in some ten thousand frames it is chance.
TOLERANCE, ALARM = 0.10, 3.0
# Errors of the first frames say how bad it is to know little.
WARM_UP = 5


@dataclass(slots=True)
class Drift:
    """The Page-Hinkley test on the errors of frames before they are learned from.

    n: frames so far. mean: of their errors. excess: summed, over mean and tolerance; never below 0.
    """

    n: int = 0
    mean: float = 0.0
    excess: float = 0.0

    def add(self, error: float) -> bool:
        """Take in a frame's error, in [0, 1], and tell whether errors have risen; then forget."""
        self.n += 1
        self.mean += (error - self.mean) / self.n
        if self.n > WARM_UP:
            self.excess = max(0.0, self.excess + error - self.mean - TOLERANCE)
        if self.excess <= ALARM:
            return False
        self.n, self.mean, self.excess = 0, 0.0, 0.0
        return True
