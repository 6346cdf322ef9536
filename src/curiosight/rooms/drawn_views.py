"""Views of what is drawn as a recording: rendered when asked for, with the truth of every pixel."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.frame import Camera, Depth, Frame, Pose
from curiosight.rooms.colour_sensor import develop, draw_look
from curiosight.rooms.free_space import Place, Polygon
from curiosight.rooms.renderer import Rendering
from curiosight.rooms.room import LOOKS, VISITS, stream
from curiosight.rooms.sensing import Readings, sense
from curiosight.rooms.settings import PathName, SensorName

# Pictures a second of a camera on its path.
RATE_HZ = 30.0
# A Kinect's colour camera, depth registered to it.
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
# A view is asked for its frame, its truth and its distances, while the next few are drawn ahead.
_N_KEPT = 6


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What a camera in a room gets to see, and what is really there.

    truth: (H, W) uint8, 255 salient, 0 not salient, 125 ignored.
    true_depth: (H, W) float32 metres along z. ids: (H, W) int32 number of the part.
    readings: what the depth sensor gives, of its own size; `frame.depth` is made of it.
    """

    frame: Frame
    truth: npt.NDArray[np.uint8]
    true_depth: Depth
    ids: npt.NDArray[np.int32]
    readings: Readings


class ViewSettings(Protocol):
    """What the settings of all that is drawn say."""

    @property
    def seed(self) -> int: ...
    @property
    def sensor(self) -> SensorName: ...
    @property
    def blur(self) -> bool: ...
    @property
    def path(self) -> PathName | None: ...


class Space(Protocol):
    """Where a camera can be brought."""

    def contains(self, place: Place) -> bool:
        """Tell whether it can be brought to (x, y)."""
        ...

    def check(self, place: Place) -> None:
        """Raise ValueError for a place that it cannot be brought to."""
        ...

    def way(self, start: Place, goal: Place) -> float:
        """Return the metres of the way between two places."""
        ...

    def ways(self, start: Place, goals: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the (n,) metres of the ways to (n, 2) places."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """What stands on the floor, seen from above: its name, and (4, 2) corners in the world."""

    name: str
    polygon: Polygon
    is_object: bool


class DrawnViews(ABC):
    """Views of what is drawn: rendered when asked for; a `Dataset`.

    settings: what it is drawn from. poses: T_world_camera of each viewpoint.
    """

    name = "room"
    has_depth = True
    camera = CAMERA
    remarks: tuple[str, ...] = ()

    def __init__(self, settings: ViewSettings, poses: Sequence[Pose], ids: Sequence[str]) -> None:
        self.settings = settings
        self.path = str(settings)
        self.poses = tuple(poses)
        self.ids = tuple(ids)
        self._looks: OrderedDict[int, Look] = OrderedDict()
        self._lock = threading.Lock()
        self._metres: dict[int, npt.NDArray[np.float64]] = {}

    @property
    @abstractmethod
    def free_space(self) -> Space:
        """Where the camera can be brought, and how long the ways are."""

    def metres_from(self, index: int) -> npt.NDArray[np.float64]:
        """Return the (n,) metres of the ways from a viewpoint to all, found once."""
        if index not in self._metres:
            places = np.stack(self.poses)[:, :2, 3]
            self._metres[index] = self.free_space.ways(places[index], places)
            self._metres[index].flags.writeable = False
        return self._metres[index]

    def look_from(
        self,
        T_world_camera: Pose,
        id: str,
        rng: np.random.Generator,
        *,
        camera: Camera = CAMERA,
        n_looks: int = 0,
    ) -> Look:
        """Look from anywhere; chance is in the exposure and in the sensors' noise.

        n_looks: how many looks there were before, where it changes while it is looked at.
        """
        drawn = self._render(camera, T_world_camera, rng, n_looks)
        return self._sensed(*drawn, T_world_camera, id, rng, camera)

    def _sensed(
        self,
        rendering: Rendering,
        truth: npt.NDArray[np.uint8],
        T_world_camera: Pose,
        id: str,
        rng: np.random.Generator,
        camera: Camera,
    ) -> Look:
        """Return what the sensors make of what a perfect camera sees."""
        rgb = develop(rendering.radiance, draw_look(rng, blur=self.settings.blur), rng)
        readings = sense(self.settings.sensor, rendering, camera, rng)
        depth = readings.registered(camera)
        frame = Frame(id, rgb, depth, camera, T_world_camera)
        return Look(frame, truth, rendering.depth, rendering.ids, readings)

    def visits(
        self, index: int, rngs: Sequence[np.random.Generator], *, n_looks: int = 0
    ) -> Iterator[Look]:
        """Yield visits to a view, each with its own chance; drawn once where that is enough."""
        pose, id = self.poses[index], self.ids[index]
        drawn = None
        for rng in rngs:
            if drawn is None or self.is_drawn_anew:
                drawn = self._render(CAMERA, pose, rng, n_looks)
            yield self._sensed(*drawn, pose, id, rng, CAMERA)

    def let_go(self) -> None:
        """Free the memory of what draws the views; it is made anew when one is asked for."""
        with self._lock:
            self._looks.clear()

    @property
    def is_drawn_anew(self) -> bool:
        """Tell whether some of it looks different at every look."""
        return False

    @abstractmethod
    def _render(
        self, camera: Camera, T_world_camera: Pose, rng: np.random.Generator, n_looks: int
    ) -> tuple[Rendering, npt.NDArray[np.uint8]]:
        """Return what a perfect camera sees, and the (H, W) truth of it; see `look_from`."""

    @abstractmethod
    def _stream(self, number: int, *more: int) -> np.random.Generator:
        """Return a source of chance that differs between splits and arrangements too."""

    def looks_stream(self, index: int) -> np.random.Generator:
        """Return the chance in a view's exposure and noise."""
        return self._stream(LOOKS, index)

    @abstractmethod
    def at_places(self, places: Sequence[tuple[float, float, float]]) -> DrawnViews:
        """Return the views from chosen places: metres x, y, degrees heading, see `pose_at`."""

    @abstractmethod
    def test_views(self, n_views: int) -> DrawnViews:
        """Return other viewpoints, for testing."""

    @property
    def n_before_change(self) -> int | None:
        """How many looks see it as it is at first; None = it does not change."""
        return None

    @abstractmethod
    def own_test_views(self, *, is_after: bool = False) -> DrawnViews:
        """Return the views that an exploration is tested on; is_after: after the change."""

    @abstractmethod
    def is_place_of(self, other: DrawnViews) -> bool:
        """Tell whether other views are of the same walls and furniture."""

    @property
    @abstractmethod
    def outlines(self) -> Sequence[Polygon]:
        """The walls seen from above."""

    @property
    @abstractmethod
    def footprints(self) -> Sequence[Standing]:
        """What stands on the floor, seen from above."""

    def visits_stream(self, n_looks: int) -> np.random.Generator:
        """Return the chance in a look that is one more visit."""
        return stream(self.settings, VISITS, n_looks)

    def seconds_of(self, index: int) -> float:
        """Return when a view is recorded: on a path as a camera does, else once a second."""
        return float(index) if self.settings.path is None else index / RATE_HZ

    def _stamped(self, frame: Frame, index: int) -> Frame:
        """Return a frame with its time, on a path: views from anywhere have none."""
        if self.settings.path is None:
            return frame
        return replace(frame, stamp_ns=round(1e9 * self.seconds_of(index)))

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        return self.look(index).frame

    def has_ground_truth(self, index: int) -> bool:
        return True

    def ground_truth(self, index: int) -> npt.NDArray[np.uint8]:
        return self.look(index).truth

    def true_depth(self, index: int) -> Depth:
        """Return the real distances of a view, (H, W) metres along z."""
        return self.look(index).true_depth

    @abstractmethod
    def instance_truth(self, index: int) -> npt.NDArray[np.int32]:
        """Return a view's objects, (H, W) int32: a number each, 0 = none, -1 = ignored."""

    def look(self, index: int) -> Look:
        """Return a view and its truth; the last few are kept."""
        index = range(len(self))[index]
        with self._lock:
            if index not in self._looks:
                rng = self.looks_stream(index)
                pose, id = self.poses[index], self.ids[index]
                look = self.look_from(pose, id, rng, n_looks=index)
                self._looks[index] = replace(look, frame=self._stamped(look.frame, index))
            self._looks.move_to_end(index)
            while len(self._looks) > _N_KEPT:
                self._looks.popitem(last=False)
            return self._looks[index]
