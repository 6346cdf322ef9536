"""RL-IAC as the authors' code solves it: Q-learning, simulated before each decision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit
from curiosight.explorer.ground import LOOK_SECONDS, Ground
from curiosight.explorer.rl_iac import known_interests
from curiosight.explorer.stays import Choice
from curiosight.explorer.tally import Tally

Array = npt.NDArray[Any]
Ints = npt.NDArray[np.int64]

# Actions of a region: the authors' robot moves up, down, left and right.
N_NEIGHBOURS = 4


class SampledQ:
    """Choose by Q-learning on the graph of regions, simulated anew before each decision.

    `n_episodes` episodes of `n_seconds` start where one stands, epsilon-greedy; an action goes
    to one of the `N_NEIGHBOURS` nearest regions and looks there once. It is paid the interest
    of the region where it starts; interests below half of the largest count as 0. Then the best
    action is taken, with `random_share` any; with `jump_share` any region is gone to. As in
    their code, seconds matter only as they use up an episode.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        n_episodes: int = 1000,
        n_seconds: float = 100.0,
        epsilon: float = 0.5,
        gamma: float = 0.3,
        jump_share: float = 0.1,
        random_share: float = 0.1,
    ) -> None:
        if n_episodes < 1 or not n_seconds >= LOOK_SECONDS:
            raise ValueError(
                f"n_episodes, n_seconds: expected 1 or more each, got {n_episodes}, {n_seconds}"
            )
        self._rng = rng
        self._n_episodes = n_episodes
        self._n_seconds = n_seconds
        self._epsilon = epsilon
        self._gamma = gamma
        self._jump_share = jump_share
        self._random_share = random_share

    def __call__(self, interests: Sequence[float | None], tally: Tally) -> Choice:
        ground = tally.ground
        n_regions = ground.n_regions
        here = 0 if tally.here is None else int(ground.region_of[tally.here])
        neighbours = nearest_regions(ground)
        values = self._simulate(known_interests(interests), ground, neighbours, here)
        scores = np.zeros(n_regions)
        scores[neighbours[here]] = values[here]
        if n_regions == 1 or self._rng.random() < self._jump_share:
            return Choice(int(self._rng.integers(n_regions)), scores, "jump to any region")
        if self._rng.random() < self._random_share:
            place = int(self._rng.choice(neighbours[here]))
            return Choice(place, scores, "any neighbour, at random")
        place = int(neighbours[here][values[here].argmax()])
        return Choice(place, scores, "neighbour with the highest Q")

    def _simulate(self, interest: Array, ground: Ground, neighbours: Ints, here: int) -> Array:
        """Return (n_regions, n_actions) Q values."""
        interest = np.where(interest < interest.max() / 2, 0.0, interest)
        seconds = np.take_along_axis(ground.between, neighbours, axis=1) + LOOK_SECONDS
        n_steps = int(self._n_seconds / LOOK_SECONDS)
        chance = self._rng.random((self._n_episodes, n_steps, 2))
        values = self._rng.uniform(0, 0.001, neighbours.shape)
        _learn(
            values, interest, neighbours, seconds, here, chance,
            self._n_seconds, self._epsilon, self._gamma,
        )  # fmt: skip
        return values


def nearest_regions(ground: Ground) -> Ints:
    """Return (n_regions, n_actions) the nearest other regions of each; itself where it is alone."""
    n_regions = len(ground.between)
    ways = ground.between + np.diag(np.full(n_regions, np.inf if n_regions > 1 else 0.0))
    n_actions = max(1, min(N_NEIGHBOURS, n_regions - 1))
    return np.argsort(ways, axis=1, kind="stable")[:, :n_actions]


@njit(cache=True, nogil=True)
def _learn(
    values: Array,
    interest: Array,
    neighbours: Array,
    seconds: Array,
    start: int,
    chance: Array,
    n_seconds: float,
    epsilon: float,
    gamma: float,
) -> None:
    """Update Q values by episodes; chance: (n_episodes, n_steps, 2) uniform numbers."""
    n_tried = np.zeros(values.shape, np.int64)
    n_actions = values.shape[1]
    for episode in range(chance.shape[0]):
        region, left = start, n_seconds
        for step in range(chance.shape[1]):
            if chance[episode, step, 0] < epsilon:
                action = int(chance[episode, step, 1] * n_actions)
            else:
                action = int(np.argmax(values[region]))
            left -= seconds[region, action]
            if left < 0:
                break
            to = int(neighbours[region, action])
            n_tried[region, action] += 1
            target = interest[region] + gamma * values[to].max()
            values[region, action] += (target - values[region, action]) / n_tried[region, action]
            region = to
