"""What the parts of the node know of it."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Protocol

from curiosight.experiments.output import OutputFolder
from curiosight.experiments.ros.inputs import Inputs
from curiosight.experiments.ros.learning import Learning
from curiosight.experiments.ros.navigation import Navigation
from curiosight.experiments.ros.outputs import Outputs
from curiosight.experiments.ros.packages import Ros
from curiosight.robot.ros.squares import Squares


class Owner(Protocol):
    """The node, as its services and reports see it; see `CuriosightNode`.

    node: of rclpy. values: of the parameters, by name. switching: held while the watch is stopped
    and started.
    """

    ros: Ros
    node: Any
    log: Any
    folder: OutputFolder
    values: dict[str, Any]
    learning: Learning | None
    inputs: Inputs | None
    navigation: Navigation | None
    outputs: Outputs
    squares: Squares
    switching: threading.RLock
    is_active: bool
    n_unreadable: int

    @property
    def n_missed(self) -> int: ...
    @property
    def model(self) -> Path | None: ...
    def start(self) -> None: ...
