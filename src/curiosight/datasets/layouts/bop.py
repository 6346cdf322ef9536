"""Read scenes of BOP, the benchmark for object poses: rgb/, depth/, mask_visib/."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np

from curiosight.datasets.dataset import GroundTruth, InstanceTruth
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DEPTH_ENDINGS, DepthForm, read_depth
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.bop_camera import FILE_NAME, BopView, read_scene_camera
from curiosight.datasets.listing import (
    IMAGE_ENDINGS,
    find_ground_truth,
    find_sequences,
    list_images,
    natural_key,
    subfolder,
)
from curiosight.datasets.reading import Reading
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError
from curiosight.frame import Camera, Depth, Label

COLOUR_FOLDERS = ("rgb", "gray")
# ITODD has TIFF.
COLOUR_ENDINGS = IMAGE_ENDINGS | {".tif", ".tiff"}
# More than this apart, in any of fx, fy, cx, cy, two images are of different cameras.
SAME_CAMERA_PX = 1.0


class Bop(Recording):
    """A scene of a BOP data set, or the scenes of one of its folders such as `test`.

    The visible masks are of the objects that the data set has models of. Whatever else is in
    view may be an object too, so pixels outside all masks are ignored, not negative. Each scene
    has a world of its own, so that frames have poses where one scene is opened.
    """

    name = "BOP"
    evidence = "scene_camera.json with rgb/"
    masks_may_be_labelled = False

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one in it, has `scene_camera.json` and images."""
        return bool(_scenes(path))

    def __init__(self, path: Path) -> None:
        scenes = _scenes(path)
        has_depth = any((scene / "depth").is_dir() for scene in scenes.values())
        entries: list[Entry] = []
        views: list[BopView | None] = []
        self._masks: list[tuple[Path, ...]] = []
        for prefix, scene in scenes.items():
            listed, seen, masks = _list_scene(path, scene, prefix, has_depth=has_depth)
            entries += listed
            views += seen
            self._masks += masks
        remarks = []
        if len(scenes) > 1 and any(entry.T_world_camera is not None for entry in entries):
            remarks.append("each scene has a world of its own: open a single one to have poses")
            entries = [replace(entry, T_world_camera=None) for entry in entries]
        if any(self._masks):
            remarks.append(
                "outside the masks all is ignored: recall can be measured, precision cannot"
            )
        camera: Camera | None = None
        if has_depth:
            size = image_size(path, [entry.rgb for entry in entries])
            intrinsics = _common_intrinsics(path, views)
            camera = Camera(*size, *intrinsics)
            entries = _told_of_other_cameras(entries, views, intrinsics)
        self._depth_scales = {
            entry.depth: view.depth_scale
            for entry, view in zip(entries, views, strict=True)
            if view is not None
        }
        super().__init__(path, entries, camera, remarks=remarks)

    def read_depth(self, path: Path) -> Depth:
        """Read depth in the unit that `scene_camera.json` gives for this very image."""
        scale = self._depth_scales.get(path)
        if scale is None:
            raise UnreadableFile(f"{FILE_NAME} gives no depth_scale for it")
        return read_depth(path, DepthForm(scale))

    def read_as(self, reading: Reading) -> Self:
        """Return the same recording, read as its owner says."""
        other = super().read_as(reading)
        if reading.depth_scale:
            other._depth_scales = dict.fromkeys(self._depth_scales, reading.depth_scale)
        return other

    def has_ground_truth(self, index: int) -> bool:
        """Tell whether there are visible masks for the frame, or a file that replaces them."""
        return bool(self._masks[index]) or super().has_ground_truth(index)

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return (H, W) uint8: 255 in a visible mask, 125 ignored; None if there are no masks.

        A file `ground_truth/<id>.png` replaces the masks. Raises `DataError` for damaged files.
        """
        if super().has_ground_truth(index):
            return super().ground_truth(index)
        instances = self.instance_truth(index)
        if instances is None:
            return None
        return np.where(instances > 0, Label.SALIENT, Label.UNKNOWN).astype(np.uint8)

    def instance_truth(self, index: int) -> InstanceTruth | None:
        """Return (H, W) int32: a number an object, -1 = ignored; None if there are no masks.

        Where masks overlap, the later one counts. Raises `DataError` for a damaged mask.
        """
        if not self._masks[index]:
            return None
        instances = np.full(self.size[::-1], -1, np.int32)
        for number, mask in enumerate(self._masks[index], start=1):
            instances[self.read_truth(mask) > 0] = number
        return instances

    def with_ground_truth(self, folder: Path) -> Self:
        """Return the same recording with its ground truth read from `folder/<id>.png`.

        Those masks do not tell objects apart.
        """
        other = super().with_ground_truth(folder)
        other._masks = [()] * len(self)
        return other


def _scenes(path: Path) -> dict[str, Path]:
    return find_sequences(path, _is_scene, levels=1)


def _is_scene(folder: Path) -> bool:
    return (folder / FILE_NAME).is_file() and subfolder(folder, COLOUR_FOLDERS) is not None


def _list_scene(
    root: Path, scene: Path, prefix: str, *, has_depth: bool
) -> tuple[list[Entry], list[BopView | None], list[tuple[Path, ...]]]:
    """Return the frames of a scene, what `scene_camera.json` says of each, and its masks."""
    colour = subfolder(scene, COLOUR_FOLDERS)
    assert colour is not None
    view_of_image = read_scene_camera(scene / FILE_NAME)
    masks_of_image = _masks(scene / "mask_visib")
    depth = _depth_files(scene / "depth")
    ground_truth = find_ground_truth(root, scene, prefix)
    entries, views, masks = [], [], []
    for id, rgb in list_images(colour, COLOUR_ENDINGS).items():
        number = int(rgb.stem) if rgb.stem.isdecimal() else -1
        view = view_of_image.get(number)
        missing = scene / "depth" / f"{rgb.stem}.png"
        entries.append(
            Entry(
                id=prefix + id,
                rgb=rgb,
                depth=depth.get(rgb.stem, missing) if has_depth else None,
                T_world_camera=view.T_world_camera if view else None,
                ground_truth=ground_truth.get(id),
                problem=view.problem if view else f"{FILE_NAME} says nothing of it",
            )
        )
        views.append(view)
        masks.append(tuple(masks_of_image.get(number, ())))
    return entries, views, masks


def _depth_files(folder: Path) -> dict[str, Path]:
    """Map stems to the depth files of a folder; of two of the same stem the likelier ending."""
    return {
        path.stem: path for ending in reversed(DEPTH_ENDINGS) for path in folder.glob(f"*{ending}")
    }


def _masks(folder: Path) -> dict[int, list[Path]]:
    """Map image numbers to their masks, `IIIIII_OOOOOO.png`, in order of the objects."""
    masks: dict[int, list[Path]] = defaultdict(list)
    for path in sorted(folder.glob("*_*.png"), key=lambda path: natural_key(path.name)):
        image, _, _ = path.stem.partition("_")
        if image.isdecimal():
            masks[int(image)].append(path)
    return masks


def _common_intrinsics(
    path: Path, views: Sequence[BopView | None]
) -> tuple[float, float, float, float]:
    """Return the intrinsics of most images; `DataError` where no camera took most of them."""
    counts = Counter(view.intrinsics for view in views if view is not None)
    if not counts:
        raise DataError(path, f"{FILE_NAME} says nothing of its images", "copy the scene again")
    (intrinsics, _) = counts.most_common(1)[0]
    n_same = sum(n for other, n in counts.items() if _is_same(other, intrinsics))
    if 2 * n_same < counts.total():
        found = f"cam_K differs from image to image, by more than {SAME_CAMERA_PX:g} px"
        raise DataError(path, found, "open scenes that one camera took")
    return intrinsics


def _told_of_other_cameras(
    entries: list[Entry],
    views: Sequence[BopView | None],
    intrinsics: tuple[float, float, float, float],
) -> list[Entry]:
    """Return the entries, those of images with other intrinsics with a problem."""
    told = []
    for entry, view in zip(entries, views, strict=True):
        if view is not None and not _is_same(view.intrinsics, intrinsics):
            problems = (entry.problem, "its cam_K is not that of most images")
            entry = replace(entry, problem="; ".join(filter(None, problems)))
        told.append(entry)
    return told


def _is_same(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return bool(np.abs(np.subtract(a, b)).max() <= SAME_CAMERA_PX)
