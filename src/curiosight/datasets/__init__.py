"""Recordings in: one class a layout, told apart by what lies in the folder."""

from __future__ import annotations

import os
from pathlib import Path

from curiosight.datasets.bop import Bop
from curiosight.datasets.check import check_dataset
from curiosight.datasets.folder import Folder
from curiosight.datasets.images import Images
from curiosight.datasets.osd import Osd
from curiosight.datasets.prefetch import Prefetch
from curiosight.datasets.recording import (
    Dataset,
    Entry,
    KnowsDistances,
    KnowsInstances,
    Recording,
)
from curiosight.datasets.rgbd_scenes import ObjectBox, RgbdScenes
from curiosight.datasets.rgbd_scenes_v2 import RgbdScenesV2
from curiosight.datasets.rl_iac import RlIac
from curiosight.datasets.rl_iac_tables import GraphNode
from curiosight.datasets.rl_iac_writer import RlIacWriter, write_rl_iac
from curiosight.datasets.seven_scenes import SevenScenes
from curiosight.datasets.tum_rgbd import TumRgbd
from curiosight.datasets.video import Video
from curiosight.errors import DataError

__all__ = [
    "SOURCES",
    "Bop",
    "Dataset",
    "Entry",
    "Folder",
    "GraphNode",
    "Images",
    "KnowsDistances",
    "KnowsInstances",
    "ObjectBox",
    "Osd",
    "Prefetch",
    "Recording",
    "RgbdScenes",
    "RgbdScenesV2",
    "RlIac",
    "RlIacWriter",
    "SevenScenes",
    "TumRgbd",
    "Video",
    "check_dataset",
    "open_dataset",
    "write_rl_iac",
]

# Tried in this order: a layout stands before those whose folders it would pass for.
SOURCES = (
    TumRgbd,
    SevenScenes,
    RgbdScenes,
    RgbdScenesV2,
    Bop,
    Osd,
    Folder,
    RlIac,
    Images,
    Video,
)

LOOKED_FOR = (
    "looked for frame-*.color.* with frame-*.depth.png (7-Scenes), rgb.txt with depth.txt "
    "(TUM RGB-D), image_color/ with depth/ (OSD), desk_1/desk_1_1_depth.png (RGB-D Scenes v1), "
    "imgs/scene_* (RGB-D Scenes v2), scene_camera.json (BOP), x.png with x_depth.png (RL-IAC), "
    "rgb/ with depth/ and camera.json (plain folder), and images"
)


def open_dataset(path: Path | str, *, ground_truth: Path | str | None = None) -> Recording | Video:
    """Open a recording; its layout is guessed from the folder, and its `name` tells the guess.

    ground_truth: folder of `<id>.png` (255 salient, 0 not salient, else ignored) to use
    instead of the recording's own. Raises `DataError` for what cannot be opened.
    """
    path = Path(path)
    try:
        dataset = _open(path)
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "check its rights") from error
    if ground_truth is None:
        if isinstance(dataset, Recording) and dataset.mask_fault is not None:
            raise dataset.mask_fault
        return dataset
    if isinstance(dataset, Video):
        raise DataError(path, "is a video", "ground truth needs a folder of images")
    return dataset.with_ground_truth(Path(ground_truth))


def _open(path: Path) -> Recording | Video:
    if not path.exists():
        raise DataError(path, "does not exist", "check the path")
    for source in SOURCES:
        if source.recognises(path):
            return source(path)
    if path.is_file():
        raise DataError(path, "is a file, and no video", "give the folder of a recording")
    if not os.listdir(path):
        raise DataError(path, "is an empty folder", "give the folder of a recording")
    inside = [child for child in sorted(path.iterdir()) if _has_depth(child)]
    remedy = f"did you mean {inside[0]}?" if inside else LOOKED_FOR
    raise DataError(path, "is no recording of a known layout", remedy)


def _has_depth(path: Path) -> bool:
    with_depth = (source for source in SOURCES if source not in (Images, Video))
    return any(source.recognises(path) for source in with_depth)
