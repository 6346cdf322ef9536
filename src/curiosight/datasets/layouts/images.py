"""Read a folder of pictures: colour only, so only a model that has learned can use them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from curiosight.datasets.decoding import UnreadableFile, decode_unchanged
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.recording import Recording
from curiosight.datasets.roles import Role, find_groups, frame_key
from curiosight.errors import DataError

# Images that are tried until one can be read.
N_TRIED = 3


class Images(Recording):
    """A folder of images, or of one layout's colour images, without depth.

    Images and masks are turned as their EXIF orientation asks: as viewers show them.
    """

    name = "folder of images"
    masks_may_be_labelled = False
    is_turned = True
    evidence = "images without depth"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder itself holds an image."""
        return path.is_dir() and bool(list_images(path))

    def __init__(self, path: Path) -> None:
        ground_truth = find_ground_truth(path)
        images, left_out = list_images(path), _no_colour(path)
        if len(left_out) < len(images):
            images = {id: rgb for id, rgb in images.items() if rgb not in left_out}
        else:
            left_out = {}
        _reject_depth(path, list(images.values()))
        entries = [Entry(id, rgb, ground_truth=ground_truth.get(id)) for id, rgb in images.items()]
        kinds = sorted({f"{path.name} ({role.value})" for path, role in _first_of_each(left_out)})
        remarks = [f"left out, for their names: {', '.join(kinds)}"] if kinds else []
        super().__init__(path, entries, remarks=remarks)


def _no_colour(folder: Path) -> dict[Path, Role]:
    """Return the files whose names say that they are depth, or a mask of another image here."""
    groups = [group for group in find_groups(folder) if group.folder == folder]
    images = [group for group in groups if group.role in (Role.COLOUR, Role.UNSAID)]
    keys = {frame_key(path.stem) for group in images for path in group.files}
    return {
        path: group.role
        for group in groups
        if group not in images
        for path in group.files
        if group.role is not Role.OTHER or frame_key(path.stem) in keys
    }


def _reject_depth(folder: Path, images: Sequence[Path]) -> None:
    """Raise `DataError` for a folder of depth: shown as grey pictures it would be nonsense."""
    for path in images[:N_TRIED]:
        try:
            picture = decode_unchanged(path)
        except UnreadableFile:
            continue
        if picture.dtype == np.uint16 and picture.ndim == 2:
            found = f"holds {path.name} of 16 bits in one channel: depth, not colour"
            raise DataError(folder, found, "give the folder that holds colour and depth")
        return


def _first_of_each(left_out: dict[Path, Role]) -> list[tuple[Path, Role]]:
    """Return one file of each role."""
    return list({role: (path, role) for path, role in reversed(left_out.items())}.values())
