"""Read a folder of pictures: colour only, so only a model that has learned can use them."""

from __future__ import annotations

from pathlib import Path

from curiosight.datasets.listing import find_ground_truth, list_images
from curiosight.datasets.recording import Entry, Recording


class Images(Recording):
    """A folder of images, or of one layout's colour images, without depth.

    Images and masks are turned as their EXIF orientation asks: as viewers show them.
    """

    name = "folder of images"
    masks_may_be_labelled = False
    is_turned = True

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder itself holds an image."""
        return path.is_dir() and bool(list_images(path))

    def __init__(self, path: Path) -> None:
        ground_truth = find_ground_truth(path)
        entries = [
            Entry(id, rgb, ground_truth=ground_truth.get(id))
            for id, rgb in list_images(path).items()
        ]
        super().__init__(path, entries)
