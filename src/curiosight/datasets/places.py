"""In which room each frame was taken, where that is known: truth for scoring alone."""

from __future__ import annotations

from pathlib import Path

from curiosight.datasets.dataset import Dataset, KnowsPlaces
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text

PLACES = "places.txt"


def known_places(dataset: Dataset) -> tuple[int, ...] | None:
    """Return the number of each frame's room, -1 = not said; None where nothing is known.

    A drawn home knows it; of a recording it stands in places.txt, a line `<id> <number>` a
    frame. No learner, region or strategy may ask. Raises `DataError` for another line.
    """
    if isinstance(dataset, KnowsPlaces):
        return tuple(dataset.place(index) for index in range(len(dataset)))
    folder = getattr(dataset, "path", None)
    if folder is None or not (path := Path(folder) / PLACES).is_file():
        return None
    place_of: dict[str, int] = {}
    try:
        for line in read_text(path).splitlines():
            if line.strip() and not line.startswith("#"):
                id, number = line.rsplit(maxsplit=1)
                place_of[id] = int(number)
    except (OSError, ValueError) as error:
        raise DataError(path, f"cannot be read ({error})", "write lines `<id> <number>`") from error
    return tuple(place_of.get(id, -1) for id in dataset.ids)
