"""The lifecycle node: what it does when it is configured, activated, deactivated, cleaned up."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.config import Config
from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.ros.beginning import Beginning
from curiosight.experiments.ros.inputs import Inputs
from curiosight.experiments.ros.learning import Learning
from curiosight.experiments.ros.navigation import Navigation
from curiosight.experiments.ros.outputs import Outputs
from curiosight.experiments.ros.packages import Ros
from curiosight.experiments.ros.parameters import NAMES, Value, check, declare
from curiosight.experiments.ros.reporting import Reporting
from curiosight.experiments.ros.services import Services
from curiosight.frame import Frame
from curiosight.robot.feed import Incoming, Shot
from curiosight.robot.ros.detections import detect
from curiosight.robot.ros.exploring import Exploring
from curiosight.robot.ros.goals import Place
from curiosight.robot.ros.squares import Squares
from curiosight.robot.watch import Look, Mapped

NAME = "curiosight"


@dataclass(frozen=True, slots=True)
class Asked:
    """What the command line asks for; parameters of the same name go before."""

    model: Path | None = None
    is_learning: bool = False


class CuriosightNode:
    """The node. node: of rclpy, whose lifecycle calls `configure`, `activate` and so on."""

    def __init__(self, ros: Ros, config: Config, folder: OutputFolder, asked: Asked) -> None:
        self.ros, self.config, self.folder = ros, config, folder
        self.node: Any = ros.rclpy_lifecycle.LifecycleNode(NAME)
        self.log = self.node.get_logger()
        given: dict[str, Value] = {"model": str(asked.model or ""), "learn": asked.is_learning}
        self.values = declare(ros, self.node, given)
        self.learning: Learning | None = None
        self.inputs: Inputs | None = None
        self.squares = Squares(1.0)
        self.outputs = Outputs(ros, self.node)
        self.services: Services | None = None
        self.navigation: Navigation | None = None
        self.is_active = False
        self.n_unreadable = 0
        self._incoming: Incoming[Any] | None = None
        self._rng = np.random.default_rng(config.run.seed)
        # Held while the watch is stopped and started.
        self.switching = threading.RLock()
        self.reporting = Reporting(self)
        self.node.add_on_set_parameters_callback(self._check_parameters)
        self.node.add_managed_entity(_entity(ros, self))

    def _check_parameters(self, changed: list[Any]) -> Any:
        """Refuse, with a reason, what cannot be; take over what may change at any time."""
        result = self.ros.rcl_interfaces_msg.SetParametersResult
        values = {one.name: one.value for one in changed if one.name in NAMES}
        try:
            check(values, is_configured=self.inputs is not None)
        except (ValueError, DataError) as error:
            return result(successful=False, reason=str(error))
        self.values |= values
        exploring = None if self.navigation is None else self.navigation.exploring
        if exploring is not None and "strategy" in values:
            exploring.change_strategy(self.start_of_exploring().make_strategy)
        return result(successful=True)

    @property
    def n_missed(self) -> int:
        """How many images were overtaken by newer ones before they were mapped."""
        return 0 if self._incoming is None else self._incoming.n_missed

    @property
    def model(self) -> Path | None:
        return Path(self.values["model"]) if self.values["model"] else None

    def configure(self) -> None:
        """Load the model, warm up, and offer what there is."""
        values = self.values
        if not (values["model"] or values["learn"]):
            raise ValueError("model: expected a run or model, or learn; got neither")
        if values["learn"] and not values["depth_topic"]:
            raise ValueError("depth_topic: expected one to learn from, got none")
        learning = Learning(self.config, self.folder, is_learning=values["learn"])
        learning.begin(self.model)
        self.learning = learning
        self.squares = Squares(values["region_size"])
        self.inputs = Inputs(self.ros, self.node, values, self._hear)
        self.outputs.open()
        self.services = Services(self)
        if self.ros.nav2_msgs_action is not None and self.ros.curiosight_msgs_action is not None:
            self.navigation = Navigation(self.ros, self.node, values, self)
        self.reporting.start()

    def activate(self) -> None:
        """Listen, map and learn."""
        assert self.inputs is not None
        self.inputs.open()
        with self.switching:
            self.start()
        self.is_active = True
        self.reporting.begin()
        self.log.info("active")

    def deactivate(self) -> None:
        """Stop all that, and save."""
        assert self.inputs is not None
        self.is_active = False
        if self.navigation is not None:
            self.navigation.stop_exploring()
        self.inputs.close()
        with self.switching:
            self.stop()

    def cleanup(self) -> None:
        """Let go of the model and of what was offered."""
        self.reporting.stop()
        if self.navigation is not None:
            self.navigation.close()
        if self.services is not None:
            self.services.close()
        self.outputs.close()
        self.learning = self.inputs = self.services = self.navigation = None

    def shutdown(self) -> None:
        """End, from whatever state."""
        if self.is_active:
            self.deactivate()
        if self.inputs is not None:
            self.cleanup()

    def start(self) -> None:
        """Begin to map with the model as it is."""
        assert self.learning is not None
        assert self.inputs is not None
        self._incoming = Incoming(self._frame_of)
        self.learning.start(
            self._incoming,
            self._settled,
            self._mapped,
            self._looked,
            has_depth=self.inputs.has_depth,
        )

    def stop(self) -> None:
        assert self.learning is not None
        self._incoming = None
        self.learning.stop()

    def _hear(self, message: Any) -> None:
        incoming = self._incoming
        if incoming is not None:
            incoming.put(message)

    def _frame_of(self, message: Any) -> Frame | None:
        assert self.inputs is not None
        try:
            return self.inputs.frames.mapped(message)
        except UnreadableFile as error:
            self.n_unreadable += 1
            self.log.warning(f"an image was passed over: {error}", throttle_duration_sec=5.0)
            return None

    def _settled(self, shot: Shot) -> Shot:
        assert self.inputs is not None
        return Shot(self.inputs.frames.settled(shot.frame), shot.index, shot.taken_at)

    def _mapped(self, mapped: Mapped) -> None:
        """Publish a map, in the thread that made it."""
        assert self.inputs is not None
        outputs, saliency = self.outputs, mapped.saliency
        stamp, frame = mapped.shot.frame.stamp_ns or 0, self.inputs.frames.colour_frame
        if outputs.is_wanted("saliency"):
            grey = np.rint(255 * saliency).astype(np.uint8)
            outputs.image("saliency", grey, "mono8", stamp, frame)
        if outputs.is_wanted("saliency_float"):
            outputs.image("saliency_float", saliency, "32FC1", stamp, frame)
        if outputs.is_wanted("detections"):
            found = detect(saliency, threshold=self.values["threshold"])
            outputs.detections(found, stamp, frame)

    def _looked(self, look: Look) -> None:
        """Publish what the teacher says, and note the look where it was taken."""
        assert self.inputs is not None
        frame, segmentation = look.verdict.shot.frame, look.verdict.segmentation
        name = self.inputs.frames.colour_frame
        if self.outputs.is_wanted("labels"):
            self.outputs.image("labels", segmentation.labels, "mono8", frame.stamp_ns or 0, name)
        learning = self.learning
        if frame.problem is not None or learning is None or not learning.teacher.is_ready:
            return
        pose = frame.T_world_camera
        region = None if pose is None else self.squares.at(float(pose[0, 3]), float(pose[1, 3]))
        if region is not None:
            self.squares.note(region, look.error)
        if self.navigation is not None:
            self.navigation.look(region, look.outcome, look.verdict.shot.taken_at)

    def start_of_exploring(self) -> Beginning:
        return Beginning(self.config, self.values, self.squares, self._rng)

    def begin(self, home: Place | None, max_s: float) -> Exploring:
        """Begin to explore; raises ValueError where something is missing for that."""
        if not self.is_active or self.inputs is None:
            raise ValueError("the node is not active")
        exploring = self.start_of_exploring().begin(self.inputs, home, max_s)
        self.log.info("explore: begun")
        return exploring

    def error(self) -> float | None:
        return self.squares.error()

    def name_of(self, region: int) -> str:
        return self.squares[region].name


def _entity(ros: Ros, owner: CuriosightNode) -> Any:
    """Return what the lifecycle of a node calls."""
    done = ros.rclpy_lifecycle.TransitionCallbackReturn

    def attempt(job: Callable[[], None]) -> Any:
        try:
            job()
        except (ValueError, DataError, OSError) as error:
            owner.log.error(str(error))
            return done.FAILURE
        except Exception as error:  # rclpy would swallow it without a word
            owner.log.fatal(f"{type(error).__name__}: {error}")
            return done.ERROR
        return done.SUCCESS

    def method(name: str) -> Callable[[Any, Any], Any]:
        job = getattr(owner, name)
        return lambda entity, state: attempt(job)

    names = ("configure", "activate", "deactivate", "cleanup", "shutdown")
    methods = {f"on_{name}": method(name) for name in names}
    return type("Entity", (ros.rclpy_lifecycle.ManagedEntity,), methods)()
