"""The first frames of a camera: what is found out of a recording as a whole is found of these."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets.dataset import GroundTruth
from curiosight.datasets.reading import AS_RECORDED
from curiosight.errors import DataError
from curiosight.experiments.snapshot import Snapshot
from curiosight.explorer import Regions
from curiosight.explorer.regions import needs_places
from curiosight.frame import Camera, Frame, Pose
from curiosight.learner.looks import Looks, look_of
from curiosight.robot.cameras.camera import CameraError, CameraFeed
from curiosight.robot.feed import EndedError, Feed, Shot
from curiosight.teacher import Survey

# So long somebody has for pointing a camera at all that it will look at.
LOOK_ROUND_S = 3.0
REGIONS = "places"
BEGUN = "camera.npz"  # of a run's folder


@dataclass(frozen=True, slots=True, eq=False)
class Begun:
    """What a watch found out of a camera's first frames, to go on with another time.

    looks: (n, 800) uint8, of each frame. survey: None = nobody asked for it. regions: of them.
    """

    looks: npt.NDArray[np.uint8]
    survey: Survey | None
    regions: Regions

    def write(self, path: Path, version: str) -> None:
        """Write it whole; version: see `Snapshot`."""
        Snapshot(version, (), {}).write(path, self, is_packed=True)

    @classmethod
    def read(cls, path: Path, version: str) -> Begun:
        """Return it; raises `DataError` for a file that is damaged, or another's."""
        begun = Snapshot(version, (), {}).read(path)
        is_fit = isinstance(begun, cls) and len(begun.looks) == len(begun.regions.of_view)
        if not is_fit:
            raise DataError(path, "holds no first frames of a camera", "begin anew")
        return begun  # type: ignore[no-any-return]


class FirstFrames:
    """Look round with a camera, and keep what was seen; a `Dataset`.

    n: so many frames are taken, evenly over `LOOK_ROUND_S`. is_wanted: asked meanwhile.
    begun: of another time; then one frame is taken, and the others are taken for known.
    rest: the frames that come after them, each by the number of that first one which looks most
        like it: a camera without poses is where it looks as it did there.

    Raises `DataError` where the camera is lost, or gives no frame at all.
    """

    def __init__(
        self,
        feed: CameraFeed,
        n: int,
        is_wanted: Callable[[], bool] = lambda: True,
        begun: Begun | None = None,
    ) -> None:
        with as_data_error():
            frames = _look_round(feed, n if begun is None else 1, is_wanted)
        if not frames:
            raise DataError(feed.device.name, "has no frames", "give one that has some")
        self.name, self.remarks = feed.device.name, feed.device.remarks
        self._frames, self.begun = frames, begun
        self.looks = np.stack([look_of(frame.rgb) for frame in frames])
        if begun is not None:
            self.looks = begun.looks
        self.ids: Sequence[str] = tuple(f"first-{number:03d}" for number in range(len(self.looks)))
        self.poses: Sequence[Pose | None] = (None,) * len(self.ids)
        self.camera: Camera | None = frames[0].camera
        self.has_depth = feed.device.has_depth
        feed.n_missed = 0  # nobody wanted those
        self.rest: Feed = _Recognised(feed, self.looks)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        return self._frames[index if len(self._frames) == len(self) else 0]

    def let_go(self) -> None:
        """Forget the images: what there is to find out of them is found out."""
        self._frames = []

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> GroundTruth | None:
        return None


def open_live(source: str) -> CameraFeed:
    """Open the camera that a source names; raises `DataError` where it is not there."""
    # At use: no other source needs what opens cameras.
    from curiosight.robot.cameras.opening import open_camera

    with as_data_error():
        return open_camera(source)


@contextmanager
def as_data_error() -> Iterator[None]:
    """Report what is wrong with a camera as what is wrong with any source."""
    try:
        yield
    except CameraError as error:
        raise DataError(error.source, error.found, error.remedy) from None


class _Recognised:
    """A feed whose frames are told by which of some known ones they look like: (n, 800) looks."""

    def __init__(self, feed: CameraFeed, looks: npt.NDArray[np.uint8]) -> None:
        self._feed, self._looks = feed, Looks(looks)

    @property
    def n_missed(self) -> int:
        return self._feed.n_missed

    def newest(self, timeout_s: float) -> Shot | None:
        with as_data_error():
            shot = self._feed.newest(timeout_s)
        if shot is None:
            return None
        return replace(shot, index=int(self._looks.likeness(look_of(shot.frame.rgb)).argmax()))

    def close(self) -> None:
        self._feed.close()


def for_camera(config: Config) -> Config:
    """Return the settings with regions that a camera can have, which tells no poses.

    Raises ValueError for settings that no camera can follow.
    """
    regions = config.explorer.regions or REGIONS
    if not needs_places(regions):
        raise ValueError(f"regions: expected {REGIONS} for a camera without poses, got {regions}")
    if not config.teacher.is_depth or ":" in config.teacher.source:
        raise ValueError(f"teacher: expected depth for a camera, got {config.teacher.source!r}")
    if config.reading != AS_RECORDED:
        raise ValueError("reading: expected nothing of a live camera to be overruled")
    return replace(config, explorer=replace(config.explorer, regions=regions))


def _look_round(feed: CameraFeed, n: int, is_wanted: Callable[[], bool]) -> list[Frame]:
    frames: list[Frame] = []
    first_at = 0.0
    try:
        while len(frames) < n and is_wanted():
            shot = feed.newest(0.1)
            if shot is None:
                continue
            first_at = first_at if frames else shot.taken_at
            if shot.taken_at >= first_at + len(frames) * LOOK_ROUND_S / n:
                frames.append(shot.frame)
    except EndedError:
        pass  # what there was is all there is
    return frames
