"""RL-IAC: where to go when the way there takes time, as a semi-Markov decision problem."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.explorer.ground import LOOK_SECONDS
from curiosight.explorer.stays import Choice
from curiosight.explorer.tally import Tally

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_NEGLIGIBLE = 1e-12


class Planned:
    """Choose the region with which the sum of all progress to come, discounted, is largest.

    A stay in region a gives its interest r(a) at each of `n_stay` looks, a look takes d(a)
    seconds, the way to a from s takes t(s, a), and a second from now counts `discount` of now:

        V(s) = max over a of  discount^t(s, a) * (G(a) + discount^(n_stay * d(a)) * V(a)),
        G(a) = r(a) * sum over k = 1 ... n_stay of discount^(k * d(a)).

    This is solved exactly (`solve`); from here the first way is the true one. With
    `random_share` any region is drawn, as interests that are not looked after grow old.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        n_stay: int = 10,
        discount: float = 0.99,
        random_share: float = 0.1,
    ) -> None:
        if not 0 < discount < 1:
            raise ValueError(f"discount: expected above 0 to below 1, got {discount}")
        if not 0 <= random_share <= 1:
            raise ValueError(f"random_share: expected 0 to 1, got {random_share}")
        self._rng = rng
        self._n_stay = n_stay
        self._discount = discount
        self._random_share = random_share

    def __call__(self, interests: Sequence[float | None], tally: Tally) -> Choice:
        ground = tally.ground
        interest = known_interests(interests)
        looks = (LOOK_SECONDS + ground.inside)[:, None] * np.arange(1, self._n_stay + 1)
        gains = interest * (self._discount**looks).sum(axis=1)
        fades = self._discount ** looks[:, -1]
        values = solve(gains, fades, self._discount**ground.between)
        scores = self._discount ** tally.seconds_to_regions() * (gains + fades * values)
        is_random = self._rng.random() < self._random_share
        is_dull = not interest.max() > _NEGLIGIBLE
        if is_random or is_dull:
            why = "no progress anywhere" if is_dull else "to know all regions"
            return Choice(int(self._rng.integers(len(scores))), scores, f"at random: {why}")
        return Choice(int(scores.argmax()), scores, "most progress to come, discounted by seconds")


def solve(gains: Floats, fades: Floats, ways: Floats) -> Floats:
    """Return the (n,) values V(s) = max over a of ways[s, a] * (gains[a] + fades[a] * V(a)).

    gains: (n,) of a stay. fades: (n,) below 1, what its seconds leave of later gains; ways:
    (n, n) at most 1, what those of the way leave. By policy iteration, so exact.
    """
    here = np.arange(len(gains))
    policy = (ways * gains).argmax(axis=1)
    while True:
        values = _value_of(policy, ways[here, policy] * gains[policy], (ways * fades)[here, policy])
        worth = ways * (gains + fades * values)
        better = worth.max(axis=1) > worth[here, policy] + 1e-12 * (1 + abs(values))
        if not better.any():
            return values
        policy = np.where(better, worth.argmax(axis=1), policy)


def _value_of(policy: Ints, gains: Floats, fades: Floats) -> Floats:
    """Return V(s) = gains[s] + fades[s] * V(policy[s]): each turn sums twice as many stays."""
    while fades.max() > 1e-15:
        gains, fades, policy = gains + fades * gains[policy], fades * fades[policy], policy[policy]
    return gains


def known_interests(interests: Sequence[float | None]) -> Floats:
    """Return interests of 0 or more; what is not known yet is as interesting as the best."""
    known = [max(value, 0.0) for value in interests if value is not None]
    best = max(known) if known else 1.0
    return np.array([best if value is None else max(value, 0.0) for value in interests])
