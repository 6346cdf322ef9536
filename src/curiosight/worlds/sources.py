"""From what a command is given as a source to what can be looked at."""

from __future__ import annotations

from pathlib import Path

from curiosight.datasets import AS_RECORDED, Dataset, Reading, open_dataset
from curiosight.rooms import RoomViews, draw_room, is_room, parse_room


def open_source(
    source: Path | str,
    *,
    ground_truth: Path | str | None = None,
    reading: Reading = AS_RECORDED,
) -> Dataset:
    """Open a recording's folder, or the views of a room that is drawn: room:SEED[,key=value…].

    ground_truth, reading: see `open_dataset`. Raises `DataError` for a recording that cannot be
    opened, ValueError for a room that cannot be drawn.
    """
    if not is_room(source):
        return open_dataset(source, ground_truth=ground_truth, reading=reading)
    if ground_truth is not None:
        raise ValueError("ground-truth: expected none for a room, which has its own")
    if reading != AS_RECORDED:
        raise ValueError("reading: expected nothing of a room to be overruled, it is drawn right")
    return RoomViews(draw_room(parse_room(str(source))))
