"""Read recordings laid out as OSD or OCID: colour, depth and annotated images by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np

from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.cameras.camera_file import (
    LabelValues,
    scaled_camera,
)
from curiosight.datasets.dataset import GroundTruth, InstanceTruth
from curiosight.datasets.depth_files import ASSUMED
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import (
    find_ground_truth,
    find_sequences,
    list_images,
    places_of,
    subfolder,
)
from curiosight.datasets.masks import check_greys, find_masks
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError
from curiosight.frame import Camera, Label

COLOUR_FOLDERS = ("image_color", "rgb")
DEPTH_FOLDERS = ("depth", "disparity")
LABEL_FOLDERS = ("annotation", "label")
OSD_VALUES = LabelValues(support=frozenset({0}), objects_from=1)
# OCID's floor is 1 everywhere, and where there is a table it is 2.
OCID_VALUES = {
    "floor": LabelValues(frozenset({1}), objects_from=2, ignore=frozenset({0})),
    "table": LabelValues(frozenset({1, 2}), objects_from=3, ignore=frozenset({0})),
}
OTHERWISE = 'a key "labels" in camera.json can say otherwise'
REMARKS = {
    OSD_VALUES: f"annotation is read as 0 background, 1 and more objects; {OTHERWISE}",
    OCID_VALUES["floor"]: f"label is read as OCID's floor, objects from 2; {OTHERWISE}",
    OCID_VALUES["table"]: f"label is read as OCID's floor and table, objects from 3; {OTHERWISE}",
}
# OSD comes without intrinsics: these are the usual ones of its Kinect. The window is where
# registered depth ends on the right and at the bottom in OSD's 45 learning scenes; on the
# other two sides its makers cut depth to the table, so that nothing can be said.
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5, depth_window=(0, 0, 567, 476))


class Osd(Recording):
    """The Object Segmentation Database, or OCID down to any of its folders."""

    name = "OSD / OCID"
    evidence = "image_color/ with depth/, or rgb/, depth/ and label/"
    masks_may_be_labelled = False

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one a few levels below, is laid out this way."""
        return bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        sequences = _sequences(path)
        entries = [
            entry
            for prefix, sequence in sequences.items()
            for entry in _list_sequence(path, sequence, prefix)
        ]
        remarks: list[str] = []
        size = image_size(path, [entry.rgb for entry in entries])
        calibration = find_calibration(path, size, remarks, CAMERA)
        self._annotations = _annotations(sequences)
        values = [calibration.labels or _label_values(folder) for folder in sequences.values()]
        self._annotated_values = [
            of_sequence
            for of_sequence, sequence in zip(values, sequences.values(), strict=True)
            for _ in _list_colour(sequence)
        ]
        self._has_masks = any(entry.ground_truth for entry in entries)
        if not self._has_masks:
            entries = [
                replace(entry, ground_truth=file)
                for entry, file in zip(entries, self._annotations, strict=True)
            ]
            if calibration.labels is None and any(self._annotations):
                remarks += [REMARKS[of_sequence] for of_sequence in dict.fromkeys(values)]
        super().__init__(
            path,
            entries,
            _with_window(path, calibration.camera),
            depth_form=calibration.depth_form(ASSUMED),
            label_values=None if self._has_masks else values[0],
            remarks=remarks,
        )
        if not self._has_masks:
            self._check_annotations()

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return (H, W) uint8: 255 salient, 0 not salient, 125 ignored; None if there is none.

        Raises `DataError` as `Recording.ground_truth`.
        """
        path = self._annotations[index]
        if self._has_masks or path is None:
            return super().ground_truth(index)
        if self.mask_fault is not None:
            raise self.mask_fault
        return self._annotated_values[index].to_ground_truth(self.read_truth(path))

    def instance_truth(self, index: int) -> InstanceTruth | None:
        """Return (H, W) int32: a number an object, 0 = none, -1 = ignored; None if unknown.

        Raises `DataError` where the annotated image is no good.
        """
        path = self._annotations[index]
        if path is None:
            return None
        values = self.read_truth(path)
        truth = self._annotated_values[index].to_ground_truth(values)
        instances = np.where(truth == Label.SALIENT, values, 0).astype(np.int32)
        instances[truth == Label.UNKNOWN] = -1
        return instances

    def with_ground_truth(self, folder: Path) -> Self:
        """Return the same recording with its ground truth read from `folder/<id>.png`.

        Those masks do not tell objects apart.
        """
        other = super().with_ground_truth(folder)
        other._annotations = [None] * len(self)
        other._has_masks = True
        return other

    def _check_annotations(self) -> None:
        try:
            check_greys([file for file in self._annotations if file])
        except DataError as fault:
            self.mask_fault = fault


def _sequences(path: Path) -> dict[str, Path]:
    return {"": path} if _is_osd(path) else find_sequences(path, _is_ocid, levels=4)


def _is_osd(folder: Path) -> bool:
    colour, depth = subfolder(folder, COLOUR_FOLDERS), subfolder(folder, DEPTH_FOLDERS)
    # Plain rgb/ and depth/ alone are a plain folder.
    is_named = (folder / "image_color").is_dir() or (folder / "disparity").is_dir()
    return bool(colour and depth and (is_named or subfolder(folder, LABEL_FOLDERS)))


def _is_ocid(folder: Path) -> bool:
    return all((folder / name).is_dir() for name in ("rgb", "depth", "label"))


def _label_values(sequence: Path) -> LabelValues:
    """Return what the values of a sequence's `label` mean: OCID tells it by its folders' names."""
    if not _is_ocid(sequence) or (sequence / "image_color").is_dir():
        return OSD_VALUES
    # The folder nearest to the sequence tells, as it is called before where it really lies.
    parts = (part for place in places_of(sequence) for part in reversed(place.parts))
    place = next((part for part in parts if part in OCID_VALUES), None)
    if place is None and (sequence / "pcd").is_dir():
        place = "floor"
    return OSD_VALUES if place is None else OCID_VALUES[place]


def _list_colour(sequence: Path) -> dict[str, Path]:
    colour = subfolder(sequence, COLOUR_FOLDERS)
    assert colour is not None
    return list_images(colour)


def _list_sequence(root: Path, sequence: Path, prefix: str) -> list[Entry]:
    depth = subfolder(sequence, DEPTH_FOLDERS)
    assert depth is not None
    ground_truth = find_ground_truth(root, sequence, prefix)
    return [
        Entry(
            id=prefix + id,
            rgb=rgb,
            depth=depth / f"{rgb.stem}.png",
            ground_truth=ground_truth.get(id),
        )
        for id, rgb in _list_colour(sequence).items()
    ]


def _annotations(sequences: dict[str, Path]) -> list[Path | None]:
    """Return the annotated image of every frame, in order; None for a frame without one."""
    files: list[Path | None] = []
    for sequence in sequences.values():
        labels = subfolder(sequence, LABEL_FOLDERS)
        annotated = find_masks(labels) if labels else {}
        files += [annotated.get(rgb.stem) for rgb in _list_colour(sequence).values()]
    return files


def _with_window(path: Path, camera: Camera) -> Camera:
    """Add OSD's depth window, which its `image_color` tells it by, unless one is given."""
    if camera.depth_window is not None or not (path / "image_color").is_dir():
        return camera
    default = scaled_camera(CAMERA, (camera.width, camera.height))
    return replace(camera, depth_window=default.depth_window)
