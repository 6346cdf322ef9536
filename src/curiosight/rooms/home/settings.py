"""What a home is drawn from, as it is written in a command: home:11,rooms=4,views=30."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from curiosight.rooms.home.change import Change, read_change
from curiosight.rooms.settings import (
    READERS,
    PathName,
    RoomSettings,
    SceneName,
    SensorName,
    Split,
    check_choices,
    check_seeds,
    fill_in_camera,
    read_options,
    read_switch,
    write_options,
)

PREFIX = "home:"
N_ROOMS, MAX_ROOMS = 8, 40
# Viewpoints a room, pictures of one way round a table, and most of all together.
N_VIEWS, N_ORBIT, MAX_VIEWS = 60, 300, 100_000


@dataclass(frozen=True, slots=True)
class HomeSettings:
    """Everything that decides what a home's images look like.

    seed: of the floor plan and of all that is in it. rooms: how many.
    views: how many viewpoints a room, or with a path pictures in all; None = 60, of a drive as
        many as it takes to have been in all rooms, of an orbit 300.
    change: what happens to the home after some looks; None = nothing. Test views show the home
        as it is then.
    unlearnable: one room's things and surfaces look different at every look.
    empty: how many rooms are nearly empty; None = one of four or more.
    The others are as of a room, see `RoomSettings`.
    """

    seed: int = 0
    rooms: int = N_ROOMS
    rearrange: int | None = None
    lights: int | None = None
    sensor: SensorName = "kinect"
    height: float | None = None
    tilt: float | None = None
    views: int | None = None
    split: Split = "train"
    blur: bool = False
    furniture: Path | None = None
    mount: float = 0.0
    scene: SceneName = "auto"
    change: Change | None = None
    unlearnable: bool = False
    empty: int | None = None
    path: PathName | None = None

    def __post_init__(self) -> None:
        fill_in_camera(self)
        if not 1 <= self.rooms <= MAX_ROOMS:
            raise ValueError(f"rooms: expected 1 to {MAX_ROOMS}, got {self.rooms}")
        most, of_room = (MAX_VIEWS // self.rooms, " a room") if not self.path else (MAX_VIEWS, "")
        if self.views is not None and not 1 <= self.views <= most:
            raise ValueError(f"views: expected 1 to {most}{of_room}, got {self.views}")
        choices = {"sensor": SensorName, "split": Split, "scene": SceneName, "path": PathName}
        check_choices(self, choices)
        check_seeds(self, ("seed", "rearrange", "lights"))
        if self.empty is not None and not 0 <= self.empty <= self.rooms:
            raise ValueError(f"empty: expected 0 to {self.rooms}, got {self.empty}")
        changed = None if self.change is None else self.change.room
        if changed is not None and changed >= self.rooms:
            raise ValueError(f"change: expected room=0 to {self.rooms - 1}, got {changed}")
        self.of_room(self.seed)  # what a room refuses, no home has

    def of_room(self, seed: int) -> RoomSettings:
        """Return what a room is drawn from, with a seed of its own."""
        return RoomSettings(
            seed,
            rearrange=self.rearrange,
            lights=self.lights,
            sensor=self.sensor,
            height=self.height,
            tilt=self.tilt,
            split=self.split,
            blur=self.blur,
            furniture=self.furniture,
            mount=self.mount,
            scene=self.scene,
            path=self.path,
        )

    def __str__(self) -> str:
        """Return the source string that `parse_home` reads."""
        default = HomeSettings(seed=self.seed, path=self.path)
        return write_options(PREFIX, self, default, () if self.path is None else ("path",))


def is_home(source: Path | str) -> bool:
    """Tell whether a source names a home to be drawn, rather than a folder."""
    return str(source).startswith(PREFIX)


def parse_home(source: str) -> HomeSettings:
    """Read home:SEED[,key=value…]; raises ValueError for what no home can be drawn from."""
    return HomeSettings(**read_options(source, PREFIX, HOME_READERS))


HOME_READERS: dict[str, Callable[[str], Any]] = {
    "rooms": int,
    **{name: reader for name, reader in READERS.items() if name not in ("plan", "over")},
    "change": read_change,
    "unlearnable": read_switch,
    "empty": int,
}
