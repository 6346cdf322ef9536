"""Whether numbers that come one after the other have become larger than they were."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from dataclasses import dataclass, field

# So many of the last numbers say what is usual; from so many on a new one can be told from them.
# The newest do not count: those of a change would pass for usual ones.
N_KEPT, LEAST_KNOWN, N_NEWEST = 200, 20, 15
# The less, the more is bet on numbers that are larger than nearly all before.
STAKE = 0.3


@dataclass(slots=True)
class Rise:
    """A sequential test that needs no model of the numbers, only that their order tells nothing.

    Each number gets the conformal p-value of its rank among those before it (Vovk, *Testing
    randomness online*, Statistical Science 36, 2021). A bet against it, k * p ** (k - 1), wins the
    more the smaller p is, and on average nothing as long as p is uniform. The winnings of all bets
    that might have begun at any number so far are summed as Shiryaev and Roberts do, which is an
    e-detector (Shin, Ramdas and Rinaldo, *E-detectors*, New England Journal of Statistics in Data
    Science 2, 2024): while nothing changes, `evidence` grows by one a number on average, so that it
    exceeds A once in A numbers at the most, whatever their distribution. Here the newest numbers
    are not among those that a number is compared with, for which that is not exact; how
    often it does is then found by chance, see `Drift`. Numbers that fall, as errors do that
    are learned from, only lower it.

    known: the last numbers, the newest last. evidence: that they have risen. n_since: how many of
    them are likeliest to be of the rise.
    """

    known: deque[float] = field(default_factory=lambda: deque(maxlen=N_KEPT + N_NEWEST))
    evidence: float = 0.0
    n_since: int = 0
    _likeliest: float = 1.0
    # All but the newest, in the order of their size.
    _usual: list[float] = field(default_factory=list)

    def add(self, number: float) -> float:
        """Take in a number, not NaN, and return the evidence."""
        if len(self._usual) >= LEAST_KNOWN:
            n_as_large = len(self._usual) - bisect_left(self._usual, number)
            p = (1 + n_as_large) / (1 + len(self._usual))
            won = winnings(p)
            self.evidence = (1 + self.evidence) * won
            # Of all bets that one has won most that begins where the product is largest.
            self.n_since = min(N_KEPT, 1 + self.n_since) if self._likeliest > 1 else 1
            self._likeliest = max(1.0, self._likeliest) * won
        self._keep(number)
        return self.evidence

    def _keep(self, number: float) -> None:
        """Take a number for one of the newest, and the oldest of these for a usual one."""
        if len(self.known) == N_KEPT + N_NEWEST:
            del self._usual[bisect_left(self._usual, self.known[0])]
        self.known.append(number)
        if len(self.known) > N_NEWEST:
            insort(self._usual, self.known[-1 - N_NEWEST])


def winnings(p: float) -> float:
    """Return what a stake of 1 becomes at a p-value in (0, 1]: 1 on average if p is uniform."""
    return STAKE * float(p ** (STAKE - 1))
