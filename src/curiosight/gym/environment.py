"""Where to look next as a problem for a reinforcement learner: learning is the reward."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Dict, Discrete

from curiosight.config import Config, load_config
from curiosight.experiments.contest.tour import Tour, views_in_regions
from curiosight.experiments.dividing import graph_ways
from curiosight.explorer.ground import LOOK_SECONDS, Ground
from curiosight.gym.known import Known, Numbers
from curiosight.gym.sources import prepared_source

Observation = dict[str, Numbers]


class LookEnv(gymnasium.Env):  # type: ignore[misc]
    """Choose a region; the nearest view least seen there is looked at and learned from.

    An observation has of each region the looks, the mean error of the last 30 looks, the
    progress, the mean uncertainty, and the seconds of the way there (docs/gym.md). The reward
    is the fall of the overall error by second of the robot's time, the way and 1 s a look.

    An episode is truncated after `n_looks`, or once `max_seconds` are spent; it never
    terminates. The learner and its chance are new after every `reset`; with a seed they are
    those of the run of `curiosight compare` with that seed.

    source: a recording's folder, room:SEED or home:SEED. config: None = the preset `default`.
    folder: where the source is kept once it is described and labelled; None = in a temporary
    folder until the process ends.

    Raises as `open_source` for the source, ValueError for other arguments.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        source: str,
        *,
        folder: str | Path | None = None,
        config: Config | None = None,
        n_looks: int = 400,
        max_seconds: float | None = None,
        render_mode: str | None = None,
    ) -> None:
        if n_looks < 1:
            raise ValueError(f"n_looks: expected 1 or more, got {n_looks}")
        if max_seconds is not None and not 0 < max_seconds < math.inf:
            raise ValueError(f"max_seconds: expected a positive number, got {max_seconds}")
        if render_mode is not None:
            raise ValueError(f"render_mode: expected None, got {render_mode!r}")
        self._config = load_config() if config is None else config
        self._n_looks, self._max_seconds = n_looks, max_seconds
        self._prepared = prepared_source(source, self._config, folder)
        self._begin(np.random.default_rng(0))
        self._is_over = True
        self.action_space = Discrete(self._n_actions())
        self.observation_space = self._space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start with a learner that has seen nothing; options are not used."""
        super().reset(seed=seed)
        # As `Run`: the first is the learner's, the second would be its strategy's.
        learner_rng, _ = self.np_random.spawn(2)
        self._begin(learner_rng)
        self._tour.enter_phase()
        self._error = self._tour.measure()
        self._is_over = False
        return self._observe(), self._info()

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Look once."""
        if self._is_over:
            raise ResetNeeded("step: expected a call of reset before, as the episode is over")
        if action not in self.action_space:
            last = self._n_actions() - 1
            raise ValueError(f"action: expected an integer from 0 to {last}, got {action!r}")
        tour = self._tour
        if tour.enter_phase():
            # What changed is not what this look has unlearned.
            self._error = tour.measure()
        number, before = self._number(int(action)), self._error
        outcome = tour.look(self.ground.views[number])
        self._known.add(number, outcome)
        self._error = tour.measure()
        reward = (before - self._error) / (outcome.seconds + LOOK_SECONDS)
        is_late = self._max_seconds is not None and tour.seconds >= self._max_seconds
        self._is_over = tour.n_looks >= self._n_looks or is_late
        return self._observe(), reward, False, self._is_over, self._info()

    def _begin(self, rng: np.random.Generator) -> None:
        views, regions = views_in_regions(self._prepared, self._config)
        seconds = graph_ways(regions, self._prepared.poses)
        self._tour = Tour(self._prepared, self._config, rng, seconds)
        self.ground = Ground(views, self._tour.ways)
        self._known = Known(self.ground, self._config)

    def _n_actions(self) -> int:
        return self.ground.n_regions

    def _number(self, action: int) -> int:
        """Return the number of the view that an action looks at."""
        return self._known.next_view(action)

    def _observe(self) -> Observation:
        return self._known.of_regions()

    def _space(self) -> Dict:
        """Return what observations may be; nothing in it is without bounds."""
        n_views = len(self.ground)
        longest = max(float(self.ground.seconds_from(view).max()) for view in range(n_views))
        lowest = {"progress": -1.0}
        highest = dict.fromkeys(("looks", "view_looks"), float(self._n_looks))
        # A way of 0 is possible where no poses are known, a space of 0 to 0 is not.
        highest |= dict.fromkeys(("seconds", "view_seconds"), max(longest, LOOK_SECONDS))
        return Dict(
            {
                name: Box(lowest.get(name, 0.0), highest.get(name, 1.0), values.shape, np.float32)
                for name, values in self._observe().items()
            }
        )

    def _info(self) -> dict[str, Any]:
        """Return what is for the record, and not for the one who chooses."""
        here = self._tour.here
        return {
            "id": None if here is None else self._prepared.ids[here.index],
            "region": None if here is None else here.region,
            "seconds": self._tour.seconds,
            "metres": self._tour.metres,
            "overall_error": self._error,
        }


class LookViewEnv(LookEnv):
    """Choose a viewpoint, by its number in `ground.views`.

    An observation has also of each viewpoint the looks and the seconds of the way there; all
    else is as in `LookEnv`.
    """

    def _n_actions(self) -> int:
        return len(self.ground)

    def _number(self, action: int) -> int:
        return action

    def _observe(self) -> Observation:
        return {**self._known.of_regions(), **self._known.of_views()}
