"""What keeps the state of a run: all that its command makes anew is outside of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from curiosight.config import Config
from curiosight.experiments.command_file import GivenCommand
from curiosight.experiments.components import same_views
from curiosight.experiments.snapshot import Snapshot
from curiosight.explorer.ground import Ways
from curiosight.explorer.own import is_own
from curiosight.explorer.strategies import make_strategy
from curiosight.frame import Viewpoint
from curiosight.learner.learner import SaliencyLearner


def run_snapshot(
    config: Config,
    given: GivenCommand | None,
    ids: Iterable[str],
    learner: SaliencyLearner,
    views: Sequence[Viewpoint],
    every_view: Iterable[Viewpoint],
    ways: Ways | None,
) -> Snapshot:
    """Return it. ids: of the frames. views: that a strategy chooses from, as it holds them."""
    outside: dict[str, object] = {
        "learner": learner,
        "views": views,
        "ways": ways,
        "make_strategy": make_strategy,
        "same_views": same_views,
    }
    for view in every_view:
        outside[f"view {view.index}"] = view
        outside[f"pose {view.index}"] = view.T_world_camera
    strategy = config.explorer.strategy
    own = [strategy.partition(":")[0].partition(".")[0]] if is_own(strategy) else []
    return Snapshot("" if given is None else given.version, ids, outside, own)
