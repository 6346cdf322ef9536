"""Teachers that read what something else has labelled: a person, or a detector.

Any other one is an object with `segment(frame)`, or a function, see `CallTeacher`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path, PurePosixPath
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.decoding import UnreadableFile, read_grey
from curiosight.errors import DataError
from curiosight.frame import Frame, Label
from curiosight.teacher.segmented import Segmentation

Labels = npt.NDArray[np.uint8]

KINDS = ("masks", "boxes")


class CallTeacher:
    """Teach what a function says of a frame.

    label: returns the (H, W) uint8 codes of `Label`, 255 salient, 0 not, 125 unknown.
    """

    def __init__(self, label: Callable[[Frame], Labels]) -> None:
        self._label = label

    def segment(self, frame: Frame) -> Segmentation:
        """Label every pixel; raises `ValueError` where the labels are not of the frame's size."""
        if frame.problem is not None:
            return _nothing(frame, frame.problem)
        labels = np.asarray(self._label(frame))
        if labels.shape != frame.rgb.shape[:2] or labels.dtype != np.uint8:
            raise ValueError(
                f"label: expected {frame.rgb.shape[:2]} uint8 for frame {frame.id}, "
                f"got {labels.shape} {labels.dtype}"
            )
        return Segmentation.of_labels(labels)


class MaskTeacher:
    """Teach with masks on disk, `<id>.png` a frame, such as `curiosight segment` writes.

    Greys are codes of `Label`; any other one is unknown. Raises `DataError` where the folder
    holds no mask. A frame whose mask is missing or bad teaches nothing.
    """

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir() or not any(folder.rglob("*.png")):
            raise DataError(folder, "has no mask <id>.png", "name the folder of the masks")
        self.folder = folder

    def segment(self, frame: Frame) -> Segmentation:
        """Return the mask of a frame."""
        if frame.problem is not None:
            return _nothing(frame, frame.problem)
        path = self.folder / f"{frame.id}.png"
        try:
            mask = read_grey(path)
        except UnreadableFile as error:
            return _nothing(frame, f"mask: {error}")
        if mask.shape != frame.rgb.shape[:2]:
            return _nothing(frame, f"mask: {path.name} is {mask.shape}, not the image's size")
        known = [Label.SALIENT, Label.NOT_SALIENT, Label.UNAVAILABLE]
        labels = np.where(np.isin(mask, known), mask, Label.UNKNOWN)
        return Segmentation.of_labels(labels.astype(np.uint8))


class BoxTeacher:
    """Teach with a detector's boxes, a COCO JSON file.

    The ellipse in a box is salient, the rest of the box unknown, everything else is not: in the
    corners of a box there is often background. Frames that the file does not name teach nothing.

    path: images with file names and annotations with `bbox` [x, y, width, height] in pixels; or a
    list of results whose `image_id` is the frame's id.
    min_score: of a box that counts, where boxes have a score.
    """

    def __init__(self, path: Path, *, min_score: float = 0.5) -> None:
        self.path = path
        self._boxes = _read_coco(path, min_score)

    def segment(self, frame: Frame) -> Segmentation:
        """Draw the boxes of a frame."""
        if frame.problem is not None:
            return _nothing(frame, frame.problem)
        boxes = self._boxes.get(frame.id)
        if boxes is None:
            return _nothing(frame, f"{self.path.name} does not name this frame")
        labels = np.full(frame.rgb.shape[:2], Label.NOT_SALIENT, np.uint8)
        for x, y, width, height in boxes:
            rows = slice(max(0, round(y)), max(0, round(y + height)))
            labels[rows, max(0, round(x)) : max(0, round(x + width))] = Label.UNKNOWN
        for x, y, width, height in boxes:
            # Centres of pixels are whole numbers.
            centre = (x + width / 2 - 0.5, y + height / 2 - 0.5)
            ellipse = (centre, (max(1.0, width - 1), max(1.0, height - 1)), 0.0)
            cv2.ellipse(labels, ellipse, int(Label.SALIENT), cv2.FILLED)
        return Segmentation.of_labels(labels)


def open_teacher(source: str) -> MaskTeacher | BoxTeacher:
    """Open `masks:FOLDER` or `boxes:FILE`; raise `DataError` or, for another kind, `ValueError`."""
    kind, _, path = source.partition(":")
    if kind not in KINDS or not path:
        raise ValueError(f"teacher: expected depth, masks:FOLDER or boxes:FILE, got {source!r}")
    return MaskTeacher(Path(path)) if kind == "masks" else BoxTeacher(Path(path))


def _nothing(frame: Frame, problem: str) -> Segmentation:
    labels = np.full(frame.rgb.shape[:2], Label.UNKNOWN, np.uint8)
    return Segmentation.of_labels(labels, problem)


def _read_coco(path: Path, min_score: float) -> dict[str, list[tuple[float, ...]]]:
    """Return the boxes of each frame that a file names, by the frame's id."""
    try:
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "name a COCO file") from error
    except ValueError as error:
        raise DataError(path, f"is not JSON ({error})", "name a COCO file") from error
    try:
        return _boxes_by_frame(content, min_score)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        found = f"is not COCO: {type(error).__name__} {error}"
        raise DataError(path, found, "give images and annotations, or a list of results") from error


def _boxes_by_frame(content: Any, min_score: float) -> dict[str, list[tuple[float, ...]]]:
    annotations: Iterable[Any]
    if isinstance(content, list):
        annotations, name_of = content, {a["image_id"]: str(a["image_id"]) for a in content}
    else:
        annotations = content["annotations"]
        name_of = {image["id"]: _frame_id(image["file_name"]) for image in content["images"]}
    boxes: dict[str, list[tuple[float, ...]]] = {name: [] for name in name_of.values()}
    for annotation in annotations:
        if annotation.get("score", 1.0) >= min_score:
            x, y, width, height = (float(number) for number in annotation["bbox"])
            if not (np.isfinite([x, y]).all() and 0 < width < np.inf and 0 < height < np.inf):
                raise ValueError(f"bbox {annotation['bbox']}")
            boxes[name_of[annotation["image_id"]]].append((x, y, width, height))
    return boxes


def _frame_id(file_name: str) -> str:
    """Return the frame that an image's file shows: `seq-01/frame-000001.color.png`, say."""
    path = PurePosixPath(file_name)
    stem = path.stem.removesuffix(".color").removesuffix("-color")
    return path.with_name(stem).as_posix()
