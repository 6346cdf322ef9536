"""Read frames as Dex-Net's tools write them: color_N.png, depth_N.npy, segmask_N.png."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from curiosight.datasets.cameras.camera_file import LabelValues
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.named import Named
from curiosight.datasets.pairs import Pairing

# A mask tells what lies on the table from everything else.
MASK_VALUES = LabelValues(support=frozenset({0}), objects_from=1)


class DexNet(Named):
    """A folder of an overhead camera's frames, or several; depth is in metres."""

    name = "Dex-Net"
    has_any_unit = False
    read_too = ("segmask",)
    evidence = "color_N.png with depth_N.npy and segmask_N.png"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether there are arrays of depth with masks beside them."""
        folders = [path, *path.glob("*/")] if path.is_dir() else []
        return any(
            any(folder.glob("depth_*.npy")) and any(folder.glob("segmask_*.png"))
            for folder in folders
        )

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        if not any(
            entry.ground_truth and "segmask" not in entry.ground_truth.name
            for entry in self.entries
        ):
            self.label_values = MASK_VALUES

    def list_entries(self, root: Path, folder: Path, prefix: str, pairing: Pairing) -> list[Entry]:
        """Return the frames of one folder, with their masks as ground truth."""
        entries = super().list_entries(root, folder, prefix, pairing)
        return [
            replace(entry, ground_truth=entry.ground_truth or _mask(folder, pair.id))
            for entry, pair in zip(entries, pairing.pairs, strict=True)
        ]


def _mask(folder: Path, id: str) -> Path | None:
    path = folder / f"segmask_{id}.png"
    return path if path.is_file() else None
