"""Read any folder whose names tell colour from depth: color_7.png, depth_7.npy, and their like."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.cameras.camera_file import CameraFile
from curiosight.datasets.depth_files import assumed_form
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.listing import find_ground_truth, find_sequences
from curiosight.datasets.pairs import Pairing, pair_folder
from curiosight.datasets.poses_of_entries import with_found_poses
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError

# Folders below the one that was opened in which frames are looked for.
N_LEVELS = 2


class Named(Calibrated):
    """Colour and depth that go together by name, in one folder or in two, or sequences of these.

    Depth in whole numbers is in millimetres, in floats in metres, unless a camera file says
    otherwise.
    """

    name = "colour and depth by name"
    has_any_unit = True
    # Words in the names of images that are no colour and yet read.
    read_too: tuple[str, ...] = ()
    evidence = "names such as color_N.png with depth_N.npy, or N.png with N_depth.png"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the names in the folder itself tell colour from depth."""
        return path.is_dir() and pair_folder(path) is not None

    @classmethod
    def recognises_below(cls, path: Path) -> bool:
        """Tell whether the names in folders below tell colour from depth."""
        return path.is_dir() and bool(_sequences(path))

    def __init__(self, path: Path) -> None:
        entries: list[Entry] = []
        remarks: list[str] = []
        reasons: list[str] = []
        sequences = _sequences(path)
        for prefix, folder in sequences.items():
            pairing = pair_folder(folder)
            assert pairing is not None
            listed = self.list_entries(path, folder, prefix, pairing)
            # Several sequences may have as many worlds.
            entries += listed if len(sequences) > 1 else with_found_poses(folder, listed, remarks)
            reasons.append(f"{prefix}{pairing.how}")
            remarks += self._remarks(prefix, pairing)
        if len(sequences) > 1:
            entries = _with_own_cameras(path, sequences, entries, remarks)
        assumed = assumed_form(entry.depth for entry in entries if entry.depth)
        reasons = list(dict.fromkeys(reasons))
        super().__init__(path, entries, remarks, reasons=reasons, usual_form=assumed)

    def _remarks(self, prefix: str, pairing: Pairing) -> Iterator[str]:
        if pairing.n_without_depth:
            yield f"{prefix}{pairing.n_without_depth} colour images have no depth: left out"
        left_out = [n for n in pairing.left_out if not any(word in n for word in self.read_too)]
        if left_out:
            yield f"{prefix}left out, for their names: {', '.join(left_out)}"

    def list_entries(self, root: Path, folder: Path, prefix: str, pairing: Pairing) -> list[Entry]:
        """Return the frames of one folder; what else belongs to a frame is found here."""
        ground_truth = find_ground_truth(root, folder, prefix)
        return [
            Entry(
                id=prefix + pair.id,
                rgb=pair.rgb,
                depth=pair.depth,
                confidence=pair.confidence,
                ground_truth=ground_truth.get(pair.id),
            )
            for pair in pairing.pairs
        ]


def _with_own_cameras(
    path: Path, sequences: dict[str, Path], entries: list[Entry], remarks: list[str]
) -> list[Entry]:
    """Give the frames of each folder that folder's camera, where not all have the same.

    Raises `DataError` where their units of depth differ.
    """
    files: dict[str, CameraFile] = {}
    for prefix, folder in sequences.items():
        images = [entry.rgb for entry in entries if entry.id.startswith(prefix)]
        files[prefix] = find_calibration(folder, image_size(folder, images), [])
    known = {prefix: file for prefix, file in files.items() if not file.is_assumed}
    if len({file.depth_scale for file in known.values()}) > 1:
        raise DataError(path, "its folders have different units of depth", "open them one by one")
    if len({file.camera for file in known.values()}) < 2:
        return entries
    remarks.append("each folder has a camera of its own")
    of_folder = {sequences[prefix]: file.camera for prefix, file in known.items()}
    return [
        replace(
            entry, camera=next((c for f, c in of_folder.items() if f in entry.rgb.parents), None)
        )
        for entry in entries
    ]


def _sequences(path: Path) -> dict[str, Path]:
    return find_sequences(path, lambda folder: pair_folder(folder) is not None, levels=N_LEVELS)
