"""Teachers that read what something else has labelled: a person, or a detector.

Any other one is an object with `segment(frame)`, or a function, see `CallTeacher`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Sized
from pathlib import Path, PurePosixPath

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.coco_boxes import read_coco
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.frame_names import frame_of_file, match_names
from curiosight.datasets.masks import (
    MASK_ENDINGS,
    by_ending,
    check_masks,
    find_all_masks,
    read_mask,
)
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

    Greys are codes of `Label`; any other one is unknown. A frame whose mask is missing or bad
    teaches nothing.

    ids: of the frames there will be; None = any. is_turned: see `read_rgb`. Raises `DataError`
    where the folder holds no mask, or none of a frame, or masks that are not of such codes.
    """

    def __init__(
        self, folder: Path, ids: Sequence[str] | None = None, *, is_turned: bool = False
    ) -> None:
        self.folder = folder
        self._is_turned = is_turned
        self._ids = ids
        self._file_of = find_mask_files(folder, ids)
        check_masks(list(self._file_of.values()), is_turned=is_turned)

    def segment(self, frame: Frame) -> Segmentation:
        """Return the mask of a frame."""
        if frame.problem is not None:
            return _nothing(frame, frame.problem)
        path = self._file_of.get(frame.id)
        if path is None:
            missing = f"{PurePosixPath(frame.id).name}.png is missing"
            return _nothing(frame, f"mask: {missing}" + _of_all(self._file_of, self._ids))
        try:
            mask = read_mask(path, is_turned=self._is_turned)
        except UnreadableFile as error:
            return _nothing(frame, f"mask: {error}")
        height, width = frame.rgb.shape[:2]
        if mask.shape != (height, width):
            found = f"is {mask.shape[1]}x{mask.shape[0]}, not the image's size, {width}x{height}"
            return _nothing(frame, f"mask: {path.name} {found}")
        known = [Label.SALIENT, Label.NOT_SALIENT, Label.UNAVAILABLE]
        labels = np.where(np.isin(mask, known), mask, Label.UNKNOWN)
        return Segmentation.of_labels(labels.astype(np.uint8))


class BoxTeacher:
    """Teach with a detector's boxes, a COCO JSON file.

    The ellipse in a box is salient, the rest of the box unknown, everything else is not: in the
    corners of a box there is often background. Frames that the file does not name teach nothing.

    path: images with file names and annotations with `bbox` [x, y, width, height] in pixels; or a
    list of results whose `image_id` is the frame's id, or the number in it.
    ids: of the frames there will be, which file names are matched with; None = any.
    min_score: of a box that counts, where boxes have a score.
    Raises `DataError` for any other file, and where it names no frame.
    """

    def __init__(
        self, path: Path, ids: Sequence[str] | None = None, *, min_score: float = 0.5
    ) -> None:
        self.path = path
        self._ids = ids
        boxes = read_coco(path, min_score)
        if ids is None:
            self._boxes = {frame_of_file(name): found for name, found in boxes.items()}
        else:
            name_of = _matched(path, list(boxes), ids, "images")
            self._boxes = {id: boxes[name] for id, name in name_of.items()}

    def segment(self, frame: Frame) -> Segmentation:
        """Draw the boxes of a frame."""
        if frame.problem is not None:
            return _nothing(frame, frame.problem)
        boxes = self._boxes.get(frame.id)
        if boxes is None:
            found = f"{self.path.name} does not name this frame" + _of_all(self._boxes, self._ids)
            return _nothing(frame, found)
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


def open_teacher(
    source: str, ids: Sequence[str] | None = None, *, is_turned: bool = False
) -> MaskTeacher | BoxTeacher:
    """Open `masks:FOLDER` or `boxes:FILE`; raise `DataError` or, for another kind, `ValueError`.

    ids: of the frames that it is to teach; None = any. is_turned: of masks, see `read_rgb`.
    """
    kind, _, path = source.partition(":")
    if kind not in KINDS or not path:
        expected = "depth, depth+masks:FOLDER, masks:FOLDER or boxes:FILE"
        raise ValueError(f"teacher: expected {expected}, got {source!r}")
    if kind == "masks":
        return MaskTeacher(Path(path), ids, is_turned=is_turned)
    return BoxTeacher(Path(path), ids)


def _nothing(frame: Frame, problem: str) -> Segmentation:
    labels = np.full(frame.rgb.shape[:2], Label.UNKNOWN, np.uint8)
    return Segmentation.of_labels(labels, problem)


def _of_all(known: Sized, ids: Sequence[str] | None) -> str:
    """Say how many frames are named, where it is known of how many."""
    return "" if ids is None else f" (of {len(ids)} frames {len(known)} are named)"


def find_mask_files(folder: Path, ids: Sequence[str] | None) -> dict[str, Path]:
    """Return the mask of each frame, by id, of two endings the better one.

    ids: of the frames there will be; None = any. Raises `DataError` where the folder holds no
    mask, or none of a frame.
    """
    files = list(find_all_masks(folder))
    if not files:
        endings = ", ".join(MASK_ENDINGS)
        found = f"has no mask <id>.png (nor {endings})" if folder.is_dir() else "is no folder"
        raise DataError(folder, found, "name the folder of the masks")
    file_of_name = {
        file.relative_to(folder).with_suffix("").as_posix(): file for file in by_ending(files)
    }
    if ids is None:
        return file_of_name
    name_of_id = _matched(folder, list(file_of_name), ids, "masks")
    return {id: file_of_name[name] for id, name in name_of_id.items()}


def _matched(path: Path, names: Sequence[str], ids: Sequence[str], what: str) -> dict[str, str]:
    """Return the name of each frame that has one; `DataError` where none has."""
    matches = match_names(names, ids)
    if matches.name_of or not ids:
        return matches.name_of
    if matches.doubtful:
        one, other = matches.doubtful
        found = f"'{one}' fits two frames" if one == other else f"'{one}' and '{other}' fit one"
        raise DataError(path, f"names no frame for sure: {found}", f"call {what} by the frame's id")
    found = f"names '{names[0]}'" if names else f"names no {what}"
    raise DataError(
        path,
        f"names no frame of the recording: it {found}, a frame is '{ids[0]}'",
        f"call its {what} by the frame's id",
    )
