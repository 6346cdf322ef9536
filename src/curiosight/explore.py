"""The method is one loop: choose a viewpoint, look, predict, compare, learn (sec. II-B)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the loop only calls what it is given
    from curiosight.explorer import Strategy
    from curiosight.frame import Viewpoint
    from curiosight.learner.learner import SaliencyLearner
    from curiosight.learner.observation import Observation
    from curiosight.worlds import World


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One turn of the loop; cost: of the way to its viewpoint, seconds."""

    index: int
    viewpoint: Viewpoint
    cost: float
    observation: Observation
    learning_progress: float | None


def explore(
    world: World,
    learner: SaliencyLearner,
    strategy: Strategy,
    n_steps: int,
    *,
    n_done: int = 0,
) -> Iterator[Step]:
    """Yield one Step per frame; the learner has learned from it when it is yielded.

    n_done: of the steps, those that all three have behind them.
    """
    from curiosight.explorer.outcome import Outcome  # at use: `--help` waits for no NumPy

    for index in range(n_done, n_steps):
        viewpoint = strategy.choose()
        cost = world.move_to(viewpoint)
        observation = learner.observe(world.capture())
        outcome = Outcome.of(observation, cost, learner.rescoring(observation))
        strategy.update(viewpoint, outcome)
        progress = strategy.progress_of(viewpoint.region)
        yield Step(index, viewpoint, cost, observation, progress)
