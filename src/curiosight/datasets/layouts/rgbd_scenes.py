"""Read RGB-D Scenes v1 (University of Washington), the table tops of the paper."""

from __future__ import annotations

import glob
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, find_sequences, list_images
from curiosight.datasets.matlab import read_matlab
from curiosight.errors import DataError


@dataclass(frozen=True, slots=True)
class ObjectBox:
    """A box around an annotated object of a frame.

    category, instance: of the RGB-D Object Dataset, such as coffee_mug, 5.
    box: (x, y, width, height) in pixels. The file's are taken to count from 1, as MATLAB does.
    """

    category: str
    instance: int
    box: tuple[int, int, int, int]


class RgbdScenes(Calibrated):
    """The data set, one of its places such as `desk`, or a sequence such as `desk/desk_1`.

    Boxes are no masks: a box holds background too, and what is in no box may be an object of a
    kind that was not annotated. So they are no ground truth; `boxes` gives them as they are.
    """

    name = "RGB-D Scenes v1"
    evidence = "depth that is called after its folder, such as desk_1/desk_1_1_depth.png"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one below, holds depth called after the folder."""
        return bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        entries: list[Entry] = []
        self._box_files: list[Path] = []
        for prefix, sequence in _sequences(path).items():
            listed = _list_sequence(path, sequence, prefix)
            entries += listed
            self._box_files += [_box_file(sequence)] * len(listed)
        self._boxes: dict[Path, list[tuple[ObjectBox, ...]]] = {}
        remarks: list[str] = []
        has_boxes = any(file.is_file() for file in set(self._box_files))
        if has_boxes and not any(entry.ground_truth for entry in entries):
            remarks.append(
                "the boxes around objects are no masks: ground truth needs masks of its own"
            )
        super().__init__(path, entries, remarks)

    def boxes(self, index: int) -> tuple[ObjectBox, ...] | None:
        """Return the boxes around a frame's annotated objects; None where nobody looked for any.

        Raises `DataError` where the file of boxes is no good.
        """
        file = self._box_files[index]
        if not file.is_file():
            return None
        if file not in self._boxes:
            self._boxes[file] = _read_boxes(file)
        number = self.entries[index].rgb.stem.rpartition("_")[2]
        # Frames count from 1. Any other name is none of those that were annotated.
        place = int(number) - 1 if number.isdecimal() else -1
        boxes = self._boxes[file]
        return boxes[place] if 0 <= place < len(boxes) else None


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, _holds_frames, levels=2)


def _holds_frames(folder: Path) -> bool:
    name = glob.escape(folder.resolve().name)
    return any(folder.glob(f"{name}_*_depth.png"))


def _box_file(sequence: Path) -> Path:
    folder = sequence.resolve()
    return folder.with_name(f"{folder.name}.mat")


def _list_sequence(root: Path, sequence: Path, prefix: str) -> list[Entry]:
    ground_truth = find_ground_truth(root, sequence, prefix)
    return [
        Entry(
            id=prefix + id,
            rgb=rgb,
            depth=sequence / f"{rgb.stem}_depth.png",
            ground_truth=ground_truth.get(id),
        )
        for id, rgb in list_images(sequence).items()
    ]


def _read_boxes(path: Path) -> list[tuple[ObjectBox, ...]]:
    """Read the boxes of all frames of a sequence, in order."""
    remedy = "unpack the data set's file again, or delete it"
    try:
        frames = read_matlab(path)["bboxes"].ravel()
        return [_boxes_of(frame) for frame in frames]
    except DataError:
        raise
    # What a damaged file makes of the reader is not foreseeable.
    except Exception as error:
        found = f"cannot be read as boxes in MATLAB's form ({error or type(error).__name__})"
        raise DataError(path, found, remedy) from error


def _boxes_of(frame: npt.NDArray[Any]) -> tuple[ObjectBox, ...]:
    if frame.dtype.names is None:  # an empty cell has no fields
        return ()
    return tuple(_box(row) for row in frame.ravel())


def _box(row: Any) -> ObjectBox:
    top, bottom, left, right, instance = (
        int(np.asarray(row[field]).item())
        for field in ("top", "bottom", "left", "right", "instance")
    )
    category = str(np.asarray(row["category"]).item())
    return ObjectBox(category, instance, (left - 1, top - 1, right - left + 1, bottom - top + 1))
