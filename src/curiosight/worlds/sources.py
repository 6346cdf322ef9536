"""From what a command is given as a source to what can be looked at."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from curiosight.datasets import AS_RECORDED, Dataset, Reading, open_dataset
from curiosight.rooms import (
    DrawnViews,
    HomeViews,
    RoomViews,
    draw_room,
    is_home,
    is_room,
    parse_home,
    parse_room,
)

CAMERAS = ("realsense:", "oak:", "camera:")


def open_source(
    source: Path | str,
    *,
    ground_truth: Path | str | None = None,
    reading: Reading = AS_RECORDED,
) -> Dataset:
    """Open a recording's folder, or the views of what is drawn: room:SEED[,key=value…] or home:….

    ground_truth, reading: see `open_dataset`. Raises `DataError` for a recording that cannot be
    opened, ValueError for a room or home that cannot be drawn, and for a live camera.
    """
    if is_camera(source):
        found = f"got the live camera {source}, which `curiosight watch` looks through"
        raise ValueError(f"source: expected a recording or what is drawn, {found}")
    if not is_drawn(source):
        return open_dataset(source, ground_truth=ground_truth, reading=reading)
    if ground_truth is not None:
        raise ValueError("ground-truth: expected none for what is drawn, which has its own")
    check_drawn(reading)
    return open_drawn(str(source))


def is_camera(source: Path | str) -> bool:
    """Tell whether a source names a live camera: realsense:…, oak:… or camera:….

    >>> is_camera("realsense:"), is_camera("camera:0"), is_camera("recording")
    (True, True, False)
    """
    return str(source).startswith(CAMERAS)


def check_drawn(reading: Reading) -> None:
    """Raise ValueError where it overrules anything of what is drawn."""
    if reading != AS_RECORDED:
        raise ValueError("reading: expected nothing of what is drawn to be overruled, it is right")


def is_drawn(source: Path | str) -> bool:
    """Tell whether a source names a room or home to be drawn, rather than a folder."""
    return is_room(source) or is_home(source)


def open_drawn(source: str, *, views: int | None = None) -> DrawnViews:
    """Return the views of a room or home; views: how many instead, of a home in each room."""
    if is_home(source):
        home = parse_home(source)
        return HomeViews(home if views is None else replace(home, views=views))
    room = parse_room(source)
    return RoomViews(draw_room(room if views is None else replace(room, views=views)))
