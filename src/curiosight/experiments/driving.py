"""Draw a drive through a room or home before it is watched: live, drawing would be too slow."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from curiosight.datasets.dataset import GroundTruth
from curiosight.frame import Camera, Frame, Pose
from curiosight.rooms import (
    DrawnViews,
    HomeSettings,
    HomeViews,
    RoomSettings,
    RoomViews,
    draw_room,
    is_home,
    parse_home,
    parse_room,
)

LEAST_FRAMES = 300
# Of a room's drive so many times as many pictures are planned, of which every sixth is drawn.
ROOM_PACE = 6


def parse_drawn(source: str) -> HomeSettings | RoomSettings:
    """Read what a source names; raises ValueError for what cannot be drawn."""
    return parse_home(source) if is_home(source) else parse_room(source)


def plan_drive(
    settings: HomeSettings | RoomSettings, least: int = LEAST_FRAMES
) -> tuple[DrawnViews, str]:
    """Return the views of a drive through a room or home, and how they were chosen.

    A robot drives round the room, or through all rooms of the home; of its pictures at least so
    many are taken, evenly, so that it seems to go faster. A source that names a path of its own,
    or an arm over tables, keeps it.
    """
    if isinstance(settings, HomeSettings):
        home = settings
        if home.path is not None and home.views is not None:
            return HomeViews(replace(home, views=max(least, home.views))), ""
        driven = replace(home, path=home.path or "drive", views=None)
        views = HomeViews(driven)
        if len(views) < least:  # it goes round again
            return HomeViews(replace(driven, views=least), like=views), ""
        return thinned(views, max(least, home.rooms * (home.views or 0)))
    room = settings
    if room.path is not None or room.over is not None:
        return RoomViews(draw_room(replace(room, views=max(least, room.views)))), ""
    n = max(least, room.views)
    return thinned(RoomViews(draw_room(replace(room, path="drive", views=ROOM_PACE * n))), n)


def thinned(views: DrawnViews, n: int) -> tuple[DrawnViews, str]:
    """Return n of the views, evenly; all where they are no more."""
    if len(views) <= n:
        return views, ""
    chosen = np.linspace(0, len(views) - 1, n).round().astype(int)
    poses = [views.poses[index] for index in chosen]
    said = f"a drive of {len(views)} pictures, {len(views) / n:.0f} times as fast"
    if isinstance(views, HomeViews):
        return HomeViews(views.home.settings, poses, like=views), said
    assert isinstance(views, RoomViews)
    return RoomViews(views.room, poses), said


class DrawnDrive:
    """The frames of a drive, drawn once and kept in a file that ends with the program; a `Dataset`.

    views: of the drive; `draw` takes them up. Frames are as drawn, to the bit, but without stamps:
    they are replayed at one pace. Several threads may ask.
    """

    def __init__(self, views: DrawnViews) -> None:
        self.name, self.path, self.remarks = views.name, views.path, views.remarks
        self.ids: Sequence[str] = views.ids
        self.poses: Sequence[Pose | None] = views.poses
        self.camera: Camera = views.camera
        self.has_depth = True
        self._views = views
        # Without a name: even a kill leaves nothing behind.
        self._file = tempfile.TemporaryFile(prefix="curiosight-drive-")  # noqa: SIM115
        self._lock = threading.Lock()
        pixels = self.camera.width * self.camera.height
        self._rgb_bytes, self._frame_bytes = 3 * pixels, 7 * pixels

    def draw(self) -> Iterator[int]:
        """Draw frame after frame; yield the number of each once it is kept."""
        for index in range(len(self)):
            frame = self._views[index]
            assert frame.depth is not None
            with self._lock:
                self._file.seek(index * self._frame_bytes)
                self._file.write(frame.rgb.tobytes() + frame.depth.tobytes())
            yield index

    def close(self) -> None:
        """Let go of the frames."""
        self._file.close()

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        with self._lock:
            self._file.seek(index * self._frame_bytes)
            content = self._file.read(self._frame_bytes)
        if len(content) < self._frame_bytes:
            raise ValueError(f"index: expected a frame that was drawn, got {index}")
        size = self.camera.height, self.camera.width
        rgb = np.frombuffer(content, np.uint8, self._rgb_bytes).reshape(*size, 3)
        depth = np.frombuffer(content, np.float32, offset=self._rgb_bytes).reshape(size)
        return Frame(self.ids[index], rgb, depth, self.camera, self.poses[index])

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> GroundTruth | None:
        return None
