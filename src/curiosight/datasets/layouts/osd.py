"""Read recordings laid out as OSD or OCID: colour, depth and annotated images by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np

from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.cameras.camera_file import (
    GROUND_TRUTH_VALUES,
    LabelValues,
    scaled_camera,
)
from curiosight.datasets.depth_files import ASSUMED
from curiosight.datasets.listing import (
    find_ground_truth,
    find_sequences,
    list_images,
    subfolder,
)
from curiosight.datasets.recording import Entry, InstanceTruth, Recording
from curiosight.datasets.sizes import image_size
from curiosight.frame import Camera, Label

COLOUR_FOLDERS = ("image_color", "rgb")
DEPTH_FOLDERS = ("depth", "disparity")
LABEL_FOLDERS = ("annotation", "label")
OSD_VALUES = LabelValues(support=frozenset({0}), objects_from=1)
# OSD comes without intrinsics: these are the usual ones of its Kinect. The window is where
# registered depth ends on the right and at the bottom in OSD's 45 learning scenes; on the
# other two sides its makers cut depth to the table, so that nothing can be said.
CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5, depth_window=(0, 0, 567, 476))


class Osd(Recording):
    """The Object Segmentation Database, or OCID down to any of its folders."""

    name = "OSD / OCID"
    evidence = "image_color/ with depth/, or rgb/, depth/ and label/"

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
        self._annotated_values = calibration.labels or OSD_VALUES
        label_values = GROUND_TRUTH_VALUES
        if not any(entry.ground_truth for entry in entries):
            entries = [
                replace(entry, ground_truth=file)
                for entry, file in zip(entries, self._annotations, strict=True)
            ]
            label_values = self._annotated_values
            if calibration.labels is None and any(entry.ground_truth for entry in entries):
                remarks.append(
                    "annotation is read as 0 background, 1 and more objects; "
                    'a key "labels" in camera.json can say otherwise'
                )
        super().__init__(
            path,
            entries,
            _with_window(path, calibration.camera),
            depth_form=calibration.depth_form(ASSUMED),
            label_values=label_values,
            remarks=remarks,
        )

    def instance_truth(self, index: int) -> InstanceTruth | None:
        """Return (H, W) int32: a number an object, 0 = none, -1 = ignored; None if unknown.

        Raises `DataError` where the annotated image is no good.
        """
        path = self._annotations[index]
        if path is None:
            return None
        values = self.read_truth(path)
        truth = self._annotated_values.to_ground_truth(values)
        instances = np.where(truth == Label.SALIENT, values, 0).astype(np.int32)
        instances[truth == Label.UNKNOWN] = -1
        return instances

    def with_ground_truth(self, folder: Path) -> Self:
        """Return the same recording with its ground truth read from `folder/<id>.png`.

        Those masks do not tell objects apart.
        """
        other = super().with_ground_truth(folder)
        other._annotations = [None] * len(self)
        return other


def _sequences(path: Path) -> dict[str, Path]:
    return {"": path} if _is_osd(path) else find_sequences(path, _is_ocid, levels=4)


def _is_osd(folder: Path) -> bool:
    colour, depth = subfolder(folder, COLOUR_FOLDERS), subfolder(folder, DEPTH_FOLDERS)
    # Plain rgb/ and depth/ alone are a plain folder.
    is_named = (folder / "image_color").is_dir() or (folder / "disparity").is_dir()
    return bool(colour and depth and (is_named or subfolder(folder, LABEL_FOLDERS)))


def _is_ocid(folder: Path) -> bool:
    return all((folder / name).is_dir() for name in ("rgb", "depth", "label"))


def _list_sequence(root: Path, sequence: Path, prefix: str) -> list[Entry]:
    colour, depth = subfolder(sequence, COLOUR_FOLDERS), subfolder(sequence, DEPTH_FOLDERS)
    assert colour is not None
    assert depth is not None
    ground_truth = find_ground_truth(root, sequence, prefix)
    return [
        Entry(
            id=prefix + id,
            rgb=rgb,
            depth=depth / f"{rgb.stem}.png",
            ground_truth=ground_truth.get(id),
        )
        for id, rgb in list_images(colour).items()
    ]


def _annotations(sequences: dict[str, Path]) -> list[Path | None]:
    """Return the annotated image of every frame, in order; None for a frame without one."""
    files: list[Path | None] = []
    for sequence in sequences.values():
        colour, labels = subfolder(sequence, COLOUR_FOLDERS), subfolder(sequence, LABEL_FOLDERS)
        assert colour is not None
        for rgb in list_images(colour).values():
            file = labels / f"{rgb.stem}.png" if labels else None
            files.append(file if file and file.is_file() else None)
    return files


def _with_window(path: Path, camera: Camera) -> Camera:
    """Add OSD's depth window, which its `image_color` tells it by, unless one is given."""
    if camera.depth_window is not None or not (path / "image_color").is_dir():
        return camera
    default = scaled_camera(CAMERA, (camera.width, camera.height))
    return replace(camera, depth_window=default.depth_window)
