"""Masks of another program's instances, which tell the teacher of depth where objects end."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.masks import CODES, check_greys, read_mask
from curiosight.frame import Frame, Label
from curiosight.teacher.given import find_mask_files

Regions = npt.NDArray[np.int32]


class InstanceMasks:
    """Masks on disk of whatever some segmenter tells apart, `<id>.png` a frame.

    Their values are numbers of instances, 0 = none. Where there is but one, or they are 255, 0
    and the other codes of `Label`, each piece in one of what is marked is an instance.

    ids: of the frames there will be; None = any. is_turned: see `read_rgb`. Raises `DataError`
    where the folder holds no mask, or none of a frame, or masks painted in colours.
    """

    def __init__(
        self, folder: Path, ids: Sequence[str] | None = None, *, is_turned: bool = False
    ) -> None:
        self.folder = folder
        self._is_turned = is_turned
        self._file_of = find_mask_files(folder, ids)
        check_greys(list(self._file_of.values()))

    def __call__(self, frame: Frame) -> Regions | str:
        """(H, W) int32 number of the instance in each pixel, 0 = none; or why there are none."""
        path = self._file_of.get(frame.id)
        if path is None:
            return "there is no mask"
        try:
            mask = read_mask(path, is_turned=self._is_turned)
        except UnreadableFile:
            return "the mask cannot be read"
        if mask.shape != frame.rgb.shape[:2]:
            return "the mask is not of the image's size"
        return regions_of(mask)


def regions_of(mask: npt.NDArray[Any]) -> Regions:
    """(H, W) int32: numbers of the instances in a mask of any whole numbers, from 1 on."""
    values, number = np.unique(mask, return_inverse=True)
    marked = set(values.tolist()) - {0}
    if len(marked) == 1 or (Label.SALIENT in marked and marked <= set(CODES)):
        one = Label.SALIENT if Label.SALIENT in marked else marked.pop()
        pieces: Regions = cv2.connectedComponents((mask == one).astype(np.uint8))[1]
        return pieces
    numbers: Regions = (number.reshape(mask.shape) + (values[0] != 0)).astype(np.int32)
    return numbers
