"""What holds for a whole recording: up, the floor, tables and walls."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.teacher.cloud.outline import Side
from curiosight.teacher.cloud.repeats import Repeats
from curiosight.teacher.cloud.wall import Wall
from curiosight.teacher.supports.supports import Scene
from curiosight.teacher.supports.table_map import Table
from curiosight.teacher.supports.tops import Kind

Array = npt.NDArray[Any]
# So far from where cameras were, metres, the floor is as high as there.
MAX_AWAY = 50.0


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What holds for a whole recording.

    scene: what the lowest support in view is; its objects and gaps are larger on a floor.
    floor_only: nothing but the floor is a support: what carries things is one with them, as it is
        to the paper's robot.
    up_world: (3,) unit vector in the world's frame; None = poses do not tell it.
    floor_height: metres along `up_world`; None = not known.
    tables: what stands on the floor and carries things, lowest first.
    walls: and other large upright planes, in the world's frame.
    noise: of the sensor's inverse depth, 1/m, for `SegmentationSettings.for_sensor`; None = no
        plane tells it.
    up_camera: (3,) unit vector in the camera's frame within 45° of which up is, where no pose
        tells it; None = as a camera that is held upright sees it.
    surveyed: (2, 3) metres, lowest and highest place of the cameras along the world's axes; None =
        everywhere.
    doubt: why it is not known which way is up, in words; None = it is.
    outline: sides of the depth sensor's view in the image, see `find_outline`; None = to be
        found in each frame by itself.
    repeats: how depth of this size repeats its readings, see `find_repeats`; None = as outline.
    """

    scene: Scene = "floor"
    up_world: Array | None = None
    floor_height: float | None = None
    tables: tuple[Table, ...] = ()
    walls: tuple[Wall, ...] = ()
    noise: float | None = None
    up_camera: Array | None = None
    doubt: str | None = None
    surveyed: Array | None = None
    outline: tuple[Side, ...] | None = None
    repeats: Repeats | None = None
    floor_only: bool = False

    def supports(self) -> dict[str, int]:
        """Return how many supports of each kind are known, by what they are called."""
        counts = Counter(table.kind.value for table in self.tables if table.kind is not Kind.THING)
        return ({} if self.floor_height is None else {"floor": 1}) | dict(counts)

    def camera_height(self, T_world_camera: Pose | None) -> float | None:
        """Return the camera's height over the floor in metres; None where it is not known.

        Far from all that was surveyed it is not known either: such a pose is lost, or its
        floor another.
        """
        if T_world_camera is None or self.up_world is None or self.floor_height is None:
            return None
        position = T_world_camera[:3, 3]
        if self.surveyed is not None:
            low, high = self.surveyed
            if (position < low - MAX_AWAY).any() or (position > high + MAX_AWAY).any():
                return None
        return float(self.up_world @ position) - self.floor_height
