"""Read SUN RGB-D (Princeton): one folder an image, with image/, depth/, intrinsics.txt."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from curiosight.datasets.cameras.camera_file import read_camera_file
from curiosight.datasets.cameras.intrinsics import read_intrinsics
from curiosight.datasets.depth_bits import rotated_bits
from curiosight.datasets.depth_files import DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import (
    find_ground_truth,
    find_sequences,
    list_images,
    subfolder,
)
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import Size, image_size
from curiosight.errors import DataError
from curiosight.frame import Depth

# Raw depth first: in the other one holes are filled with what nobody measured.
DEPTH_FOLDERS = ("depth", "depth_bfx")
INTRINSICS = "intrinsics.txt"
# What only this data set has beside an image.
BESIDE = (
    *("depth_bfx", "extrinsics", "annotation2Dfinal", "annotation3Dfinal", "annotation3Dlayout"),
    *("annotation", "fullres", "scene.txt", "seg.mat"),
)
# The data set's toolbox sets everything farther to this, so that it is no reading.
CLAMP_METRES = 8.0
MILLIMETRE = 0.001
LEVELS = 6  # from the whole data set to an image: xtion/sun3ddata/room/scan/image
MAX_LOOKED_AT = 4  # folders a level, to tell the layout


class SunRgbd(Recording):
    """An image of SUN RGB-D, or the many below one of its folders; every one is a world."""

    name = "SUN RGB-D"
    evidence = "image/ and depth/ with intrinsics.txt and depth_bfx/, extrinsics/ or annotation*/"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one of the first ones below, is that of an image."""
        return path.is_dir() and next(_some_images(path, LEVELS), None) is not None

    def __init__(self, path: Path) -> None:
        folders = find_sequences(path, _is_image_folder, levels=LEVELS)
        entries = [_entry(path, folder, prefix) for prefix, folder in folders.items()]
        size = image_size(path, [entry.rgb for entry in entries])
        own = read_camera_file(path)
        if own is None:
            entries = _with_cameras(entries, size)
        camera = own.camera if own else next((e.camera for e in entries if e.camera), None)
        if camera is None:
            raise DataError(path, f"no {INTRINSICS} holds a camera", "copy the folder again")
        depth_files = [entry.depth for entry in entries if entry.depth is not None]
        bits = rotated_bits(depth_files)
        scale = (own and own.depth_scale) or MILLIMETRE
        super().__init__(
            path,
            entries,
            camera,
            depth_form=DepthForm(scale, rotated_bits=bits),
            remarks=_remarks(depth_files, bits),
        )
        self.mount = own.mount if own else None

    def read_depth(self, path: Path) -> Depth:
        """Read depth as recorded, metres; what was set to 8 m is no reading."""
        depth = super().read_depth(path)
        depth[depth >= CLAMP_METRES - MILLIMETRE / 2] = np.nan
        return depth


def _is_image_folder(folder: Path) -> bool:
    is_whole = (folder / INTRINSICS).is_file() and (folder / "image").is_dir()
    if not is_whole or subfolder(folder, DEPTH_FOLDERS) is None:
        return False
    # SUN3D has many images a folder, and poses of them in extrinsics/.
    is_one = len(list((folder / "image").iterdir())) == 1
    return is_one and any((folder / name).exists() for name in BESIDE)


def _some_images(folder: Path, levels: int) -> Iterator[Path]:
    """Yield image folders among the first few on each level."""
    if _is_image_folder(folder):
        yield folder
    elif levels:
        below = sorted(child for child in folder.iterdir() if child.is_dir())
        for child in below[:MAX_LOOKED_AT]:
            yield from _some_images(child, levels - 1)


def _entry(root: Path, folder: Path, prefix: str) -> Entry:
    id, rgb = next(iter(list_images(folder / "image").items()), ("", folder / "image"))
    depth = subfolder(folder, DEPTH_FOLDERS)
    assert depth is not None
    # Colour and depth of some of its cameras are called after two times.
    files = sorted(depth.glob("*.png"))
    return Entry(
        id=prefix + (id or folder.name),
        rgb=rgb,
        depth=files[0] if files else depth / f"{rgb.stem}.png",
        ground_truth=find_ground_truth(root, folder, prefix).get(id),
    )


def _with_cameras(entries: Sequence[Entry], size: Size) -> list[Entry]:
    """Return the entries with the intrinsics beside each image; or with a problem."""
    told = []
    for entry in entries:
        found = read_intrinsics(entry.rgb.parent.parent / INTRINSICS)
        if found is None:
            told.append(replace(entry, problem=f"its {INTRINSICS} holds no camera"))
        else:
            told.append(replace(entry, camera=found.camera(size)))
    return told


def _remarks(depth_files: Sequence[Path], bits: int) -> list[str]:
    remarks = [f"depth of {CLAMP_METRES:g} m and more is no reading: it was set to that"]
    if not bits:
        remarks.append("bits of depth are not rotated here: read as plain numbers")
    n_filled = sum(file.parent.name == DEPTH_FOLDERS[1] for file in depth_files)
    if n_filled:
        remarks.append(f"{n_filled} images have no raw depth/: holes are filled in depth_bfx/")
    return remarks
