"""Recordings in: one class a layout, told apart by what lies in the folder."""

from __future__ import annotations

import os
from pathlib import Path

from curiosight.datasets.bags.bag import bag_files
from curiosight.datasets.bags.writer import BAG_LAYOUTS, BagWriter
from curiosight.datasets.check import check_dataset
from curiosight.datasets.dataset import Dataset, KnowsDistances, KnowsInstances, KnowsPlaces
from curiosight.datasets.doubts import Doubt, find_doubts
from curiosight.datasets.entries import Entry
from curiosight.datasets.fixing import fix_units
from curiosight.datasets.layouts.arkit_scenes import ArkitScenes
from curiosight.datasets.layouts.azure_kinect import AzureKinect
from curiosight.datasets.layouts.bop import Bop
from curiosight.datasets.layouts.dex_net import DexNet
from curiosight.datasets.layouts.folder import Folder
from curiosight.datasets.layouts.foreign import is_foreign, refusal
from curiosight.datasets.layouts.icl_nuim import IclNuim
from curiosight.datasets.layouts.images import Images
from curiosight.datasets.layouts.lerobot import LeRobot
from curiosight.datasets.layouts.named import Named
from curiosight.datasets.layouts.open3d import Open3d
from curiosight.datasets.layouts.osd import Osd
from curiosight.datasets.layouts.record3d import Record3d
from curiosight.datasets.layouts.refused import REFUSED
from curiosight.datasets.layouts.replica import Replica
from curiosight.datasets.layouts.rgbd_scenes import ObjectBox, RgbdScenes
from curiosight.datasets.layouts.rgbd_scenes_v2 import RgbdScenesV2
from curiosight.datasets.layouts.rl_iac import RlIac
from curiosight.datasets.layouts.rl_iac_tables import GraphNode
from curiosight.datasets.layouts.rl_iac_writer import RlIacWriter, write_rl_iac
from curiosight.datasets.layouts.ros_bag import RosBag
from curiosight.datasets.layouts.scanner_app import ScannerApp
from curiosight.datasets.layouts.scannet import ScanNet
from curiosight.datasets.layouts.seven_scenes import SevenScenes
from curiosight.datasets.layouts.stray_scanner import StrayScanner
from curiosight.datasets.layouts.sun3d import Sun3d
from curiosight.datasets.layouts.sun_rgbd import SunRgbd
from curiosight.datasets.layouts.three_d_match import ThreeDMatch
from curiosight.datasets.layouts.tum_associations import TumAssociations
from curiosight.datasets.layouts.tum_one_list import TumOneList
from curiosight.datasets.layouts.tum_rgbd import TumRgbd
from curiosight.datasets.layouts.video import Video
from curiosight.datasets.places import known_places
from curiosight.datasets.prefetch import Prefetch
from curiosight.datasets.reading import AS_RECORDED, Reading
from curiosight.datasets.recording import Recording
from curiosight.errors import DataError

__all__ = [
    "AS_RECORDED",
    "BAG_LAYOUTS",
    "SOURCES",
    "ArkitScenes",
    "AzureKinect",
    "BagWriter",
    "Bop",
    "Dataset",
    "DexNet",
    "Doubt",
    "Entry",
    "Folder",
    "GraphNode",
    "IclNuim",
    "Images",
    "KnowsDistances",
    "KnowsInstances",
    "KnowsPlaces",
    "LeRobot",
    "Named",
    "ObjectBox",
    "Open3d",
    "Osd",
    "Prefetch",
    "Reading",
    "Record3d",
    "Recording",
    "Replica",
    "RgbdScenes",
    "RgbdScenesV2",
    "RlIac",
    "RlIacWriter",
    "RosBag",
    "ScanNet",
    "ScannerApp",
    "SevenScenes",
    "StrayScanner",
    "Sun3d",
    "SunRgbd",
    "ThreeDMatch",
    "TumAssociations",
    "TumOneList",
    "TumRgbd",
    "Video",
    "check_dataset",
    "find_doubts",
    "known_places",
    "open_dataset",
    "write_rl_iac",
]

# Tried in this order: a layout stands before those whose folders it would pass for.
SOURCES = (
    RosBag,
    Record3d,
    AzureKinect,
    LeRobot,
    IclNuim,
    TumRgbd,
    TumAssociations,
    TumOneList,
    ThreeDMatch,
    SevenScenes,
    RgbdScenes,
    RgbdScenesV2,
    Bop,
    SunRgbd,
    Sun3d,
    ScannerApp,
    StrayScanner,
    ScanNet,
    ArkitScenes,
    Replica,
    Osd,
    Open3d,
    Folder,
    RlIac,
    DexNet,
    Named,
    Images,
    Video,
)

LOOKED_FOR = (
    "put colour into rgb/ and depth, as 16-bit PNG in millimetres or .npy in metres, into depth/, "
    "under the same names, with a camera.json; read as they are: "
    + ", ".join(source.name for source in SOURCES)
)


def open_dataset(
    path: Path | str,
    *,
    ground_truth: Path | str | None = None,
    reading: Reading = AS_RECORDED,
) -> Recording | Video:
    """Open a recording; its layout is guessed from the folder, and its `name` tells the guess.

    ground_truth: folder of `<id>.png` (255 salient, 0 not salient, else ignored) to use
    instead of the recording's own. reading: what overrules the recording's own unit, poses and
    cameras. Raises `DataError` for what cannot be opened.
    """
    path = Path(path)
    try:
        dataset = _open(path, reading.topics)
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "check its rights") from error
    if isinstance(dataset, Video):
        if ground_truth is not None or reading != AS_RECORDED:
            raise DataError(path, "is a video", "ground truth and depth need a folder of images")
        return dataset
    if reading != AS_RECORDED:
        dataset = dataset.read_as(reading)
    if dataset.has_depth and (reading.fix_units or dataset.is_unit_open):
        dataset = fix_units(dataset, depth_alone=not reading.fix_units)
    if ground_truth is not None:
        return dataset.with_ground_truth(Path(ground_truth))
    if dataset.mask_fault is not None:
        raise dataset.mask_fault
    return dataset


def _open(path: Path, topics: str) -> Recording | Video:
    if not path.exists():
        raise DataError(path, "does not exist", "check the path")
    if is_foreign(path):
        raise refusal(path)
    if RosBag.recognises(path):
        return RosBag(path, topics)
    if topics:
        raise DataError(path, "is no bag, and has no topics", "leave --topics away")
    for source in (*REFUSED, *SOURCES):
        if source.recognises(path):
            return source(path)
    if not path.is_dir():
        raise DataError(path, "is a file, and no video", "give the folder of a recording")
    if not os.listdir(path):
        raise DataError(path, "is an empty folder", "give the folder of a recording")
    if bags := bag_files(path):
        found = f"holds {len(bags)} bags"
        raise DataError(path, found, f"give one of them, {bags[0].name} say")
    if inside := [child for child in sorted(path.iterdir()) if _is_one_file(child)]:
        found = f"holds {len(inside)} recordings of one file each"
        raise DataError(path, found, f"give one of them, {inside[0].name} say")
    for child in sorted(path.iterdir()):
        if is_foreign(child):
            raise refusal(child)
        for source in REFUSED:
            if child.is_file() and source.recognises(child):
                return source(child)
    inside = [child for child in sorted(path.iterdir()) if _has_depth(child)]
    if not inside and Named.recognises_below(path):
        return Named(path)
    remedy = f"did you mean {inside[0]}?" if inside else LOOKED_FOR
    raise DataError(path, "is no recording of a known layout", remedy)


def _is_one_file(path: Path) -> bool:
    return path.is_file() and (Record3d.recognises(path) or AzureKinect.recognises(path))


def _has_depth(path: Path) -> bool:
    with_depth = (source for source in SOURCES if source not in (Named, Images, Video))
    return any(source.recognises(path) for source in with_depth)
