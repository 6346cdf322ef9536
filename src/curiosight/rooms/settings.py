"""What a room is drawn from, as it is written in a command: room:7,plan=l,sensor=perfect."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

PlanShape = Literal["rect", "l"]
SensorName = Literal["kinect", "stereo", "lidar", "perfect"]
Split = Literal["train", "test"]
Over = Literal["table"]
SceneName = Literal["auto", "floor", "table"]
PathName = Literal["drive", "orbit"]

PREFIX = "room:"
# Metres and degrees of the paper's robot, whose camera stands on a mast.
MAST_HEIGHT, MAST_TILT = 1.0, 10.0
# Metres over the floor of a camera that one holds before one's face.
HELD_HEIGHT = 1.4
MAX_VIEWS = 10_000


@dataclass(frozen=True, slots=True)
class RoomSettings:
    """Everything that decides what a room's images look like.

    seed: of plan, furniture, things and views. plan: None = drawn from the seed.
    rearrange: seed of another arrangement of the things; None = as first drawn.
    lights: seed of other lights; None = as first drawn.
    sensor: "kinect" = noise, holes and range of a Kinect v1; "stereo" = those of a stereo camera;
        "lidar" = a phone's small and smooth image; "perfect" = depth everywhere.
    height, tilt: of the camera, metres over the floor and degrees down; None = the paper's
        robot's, which they become. With `over`, metres over the table, and None = each view its
        own, of 0.5 to 1.2 m and 60 to 90 degrees.
    views: how many viewpoints. split: "test" = other viewpoints than "train", as many.
    blur: motion blur.
    furniture: a Sweet Home 3D library (.sh3f) whose things stand among the others.
    over: "table" = an arm holds the camera over tables; None = a robot carries it.
    mount: degrees by which the camera is turned about its optical axis, clockwise as seen from
        behind it.
    scene: whose truth it is: "floor" = of a robot that takes what carries things for one object
        with them, so that only floor and walls are not salient; "auto", "table" = what carries
        things is a support. Over tables it is "table".
    path: "drive" = the views are pictures on a robot's way through the room, 30 a second;
        "orbit" = they are pictures of a hand-held camera that is carried round a table; None =
        views from anywhere.
    """

    seed: int = 0
    plan: PlanShape | None = None
    rearrange: int | None = None
    lights: int | None = None
    sensor: SensorName = "kinect"
    height: float | None = None
    tilt: float | None = None
    views: int = 200
    split: Split = "train"
    blur: bool = False
    furniture: Path | None = None
    over: Over | None = None
    mount: float = 0.0
    scene: SceneName = "auto"
    path: PathName | None = None

    def __post_init__(self) -> None:
        if self.over is not None and self.path is not None:
            raise ValueError(f"path: expected none with over={self.over}, got {self.path}")
        if self.over is None:
            fill_in_camera(self)
        check_choices(self, _CHOICES)
        check_seeds(self, ("seed", "rearrange", "lights"))
        self._check_camera()
        if not 1 <= self.views <= MAX_VIEWS:
            raise ValueError(f"views: expected 1 to {MAX_VIEWS}, got {self.views}")

    def _check_camera(self) -> None:
        limits = {"height": (0.2, 2.0, "metres"), "tilt": (0, 90, "degrees")}
        over = ""
        if self.over is not None:
            over = " over a table"
            limits = {"height": (0.3, 1.5, "metres"), "tilt": (45, 90, "degrees")}
        limits["mount"] = (-360, 360, "degrees")
        for name, (low, high, unit) in limits.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                where = "" if name == "mount" else over
                raise ValueError(f"{name}: expected {low} to {high} {unit}{where}, got {value}")

    def __str__(self) -> str:
        """Return the source string that `parse_room` reads."""
        default = RoomSettings(seed=self.seed, over=self.over, path=self.path)
        always = [name for name in ("over", "path") if getattr(self, name) is not None]
        return write_options(PREFIX, self, default, always)


def fill_in_camera(settings: Any) -> None:
    """Set a camera's height and tilt, where they are None, to what is usual of its path."""
    is_held = settings.path == "orbit"
    if is_held and settings.tilt is not None:
        found = f"path=orbit, which looks at its table; got {settings.tilt}"
        raise ValueError(f"tilt: expected none with {found}")
    usual = {"height": HELD_HEIGHT} if is_held else {"height": MAST_HEIGHT, "tilt": MAST_TILT}
    for name, value in usual.items():
        if getattr(settings, name) is None:
            object.__setattr__(settings, name, value)


_CHOICES = {
    "plan": PlanShape,
    "sensor": SensorName,
    "split": Split,
    "over": Over,
    "scene": SceneName,
    "path": PathName,
}


def is_room(source: Path | str) -> bool:
    """Tell whether a source names a room to be drawn, rather than a folder."""
    return str(source).startswith(PREFIX)


def parse_room(source: str) -> RoomSettings:
    """Read room:SEED[,key=value…]; raises ValueError for what no room can be drawn from."""
    return RoomSettings(**read_options(source, PREFIX, READERS))


def read_options(
    source: str, prefix: str, readers: Mapping[str, Callable[[str], Any]]
) -> dict[str, Any]:
    """Return the seed and the options of a source such as room:SEED[,key=value…].

    readers: what turns the text of each option into its value. Raises ValueError for others.
    """
    seed, *pairs = source.removeprefix(prefix).split(",")
    options: dict[str, Any] = {"seed": _read("seed", int, seed)}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if key not in readers or not equals:
            near = difflib.get_close_matches(key, readers, n=1)
            hint = f"; did you mean {near[0]}=?" if near and near[0] != key else ""
            expected = f"{prefix}SEED,key=value with " + ", ".join(readers)
            raise ValueError(f"{source}: expected {expected}; got {pair!r}{hint}")
        if key in options:
            raise ValueError(f"{source}: expected {key}= once, got it twice")
        options[key] = _read(key, readers[key], value)
    return options


def write_options(prefix: str, settings: Any, default: Any, always: Container[str] = ()) -> str:
    """Return the source string that is read back as the settings: what is not as by default.

    settings, default: dataclasses with a `seed` each. always: names that are written anyway.
    """
    changed = [
        f",{field.name}={_written(getattr(settings, field.name))}"
        for field in fields(settings)
        if getattr(settings, field.name) != getattr(default, field.name) or field.name in always
    ]
    return f"{prefix}{settings.seed}" + "".join(changed)


def check_choices(settings: Any, choices: Mapping[str, Any]) -> None:
    """Raise ValueError for a field that is none of its choices; None is always one."""
    for name, kinds in choices.items():
        value = getattr(settings, name)
        if value is not None and value not in get_args(kinds):
            raise ValueError(f"{name}: expected {' or '.join(get_args(kinds))}, got {value}")


def check_seeds(settings: Any, names: Iterable[str]) -> None:
    """Raise ValueError for a seed below 0; None is none."""
    for name in names:
        value = getattr(settings, name)
        if value is not None and value < 0:
            raise ValueError(f"{name}: expected 0 or more, got {value}")


def read_switch(text: str) -> bool:
    """Return what yes or no means."""
    return {"yes": True, "no": False}[text]


READERS: dict[str, Callable[[str], Any]] = {
    "plan": str,
    "rearrange": int,
    "lights": int,
    "sensor": str,
    "height": float,
    "tilt": float,
    "views": int,
    "split": str,
    "blur": read_switch,
    "furniture": Path,
    "over": str,
    "mount": float,
    "scene": str,
    "path": str,
}
_EXPECTED: dict[Any, str] = {int: "a whole number", float: "a number", read_switch: "yes or no"}


def _read(name: str, reader: Callable[[str], Any], text: str) -> Any:
    try:
        return reader(text)
    except (ValueError, KeyError) as error:
        if reader not in _EXPECTED:  # it says itself what it expects
            raise
        raise ValueError(f"{name}: expected {_EXPECTED[reader]}, got {text!r}") from error


def _written(value: object) -> str:
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)
