"""How an exploration begins: goals on the map, a strategy, the way home."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.experiments.components import choose_strategy
from curiosight.experiments.ros.inputs import Inputs
from curiosight.explorer import Strategy
from curiosight.frame import Viewpoint
from curiosight.robot.ros.exploring import Exploring, Rules
from curiosight.robot.ros.goals import Place, views_from
from curiosight.robot.ros.squares import Squares
from curiosight.worlds.travel import straight_ways, travel_seconds


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """What an exploration is begun with. values: of the node's parameters, as they are now."""

    config: Config
    values: dict[str, Any]
    squares: Squares
    rng: np.random.Generator

    def make_strategy(self, views: tuple[Viewpoint, ...]) -> Strategy:
        explorer = replace(self.config.explorer, strategy=self.values["strategy"])
        config = replace(self.config, explorer=explorer)
        return choose_strategy(config, views, self.rng, ways=_ways)

    def begin(self, inputs: Inputs, home: Place | None, max_s: float) -> Exploring:
        """Begin, where the robot is now; raises ValueError, in words, where something is missing.

        home: None = where it is.
        """
        values = self.values
        base, camera = inputs.base_pose(), inputs.camera_on_base()
        if base is None:
            raise ValueError(f"no tf from {values['world_frame']} to {values['base_frame']}")
        if camera is None:
            what = inputs.frames.colour_frame or "the camera, as no image has come"
            raise ValueError(f"no tf from {values['base_frame']} to {what}")
        if inputs.floor is None:
            raise ValueError(f"no map has come on {values['map_topic']}")
        here = float(base[0, 3]), float(base[1, 3])
        places = inputs.floor.reachable(here, values["clearance"], values["goal_spacing"])
        views, stands = views_from(
            places, self.squares, camera, n_headings=values["headings"], z=float(base[2, 3])
        )
        if not views:
            raise ValueError(f"the map on {values['map_topic']} has no free place for a goal")
        rules = Rules(
            looks=values["looks_per_goal"],
            goal_timeout_s=values["goal_timeout"],
            max_s=max_s,
            patience=values["patience"],
            min_fall=values["min_fall"],
        )
        home = home or Place.of(base)
        return Exploring(
            self.make_strategy, views, stands, self.squares, home, rules, time.monotonic()
        )


def _ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> npt.NDArray[np.float64]:
    return travel_seconds(*straight_ways(start, goals))
