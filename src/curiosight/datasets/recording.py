"""What a dataset is, and the class that all loaders of image files build on."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, Self, TypeVar, runtime_checkable

import numpy as np
import numpy.typing as npt

from curiosight.datasets.camera_file import (
    GROUND_TRUTH_VALUES,
    CameraFile,
    LabelValues,
    scaled_camera,
)
from curiosight.datasets.decoding import (
    EightBitDepth,
    UnreadableFile,
    read_depth,
    read_rgb,
)
from curiosight.datasets.masks import (
    MASK_ENDINGS,
    find_masks,
    judge_masks,
    read_mask,
    read_numbers,
)
from curiosight.errors import DataError
from curiosight.frame import Camera, Depth, Frame, Pose, Rgb

GroundTruth = npt.NDArray[np.uint8]
InstanceTruth = npt.NDArray[np.int32]
Image = TypeVar("Image", Rgb, Depth)


class Dataset(Protocol):
    """A recording to look at, frame by frame; `check_dataset` tells whether it keeps its word.

    name: the layout, such as "7-Scenes".
    ids: one unique name a frame, usable as a relative file name; outputs are named by it.
    poses: (4, 4) camera-to-world of the colour camera or None, known without decoding.
    camera: intrinsics of the colour image; None only where `has_depth` is False.
    remarks: sentences on how the source was read that its owner should know.
    """

    @property
    def name(self) -> str: ...
    @property
    def ids(self) -> Sequence[str]: ...
    @property
    def poses(self) -> Sequence[Pose | None]: ...
    @property
    def camera(self) -> Camera | None: ...
    @property
    def has_depth(self) -> bool: ...
    @property
    def remarks(self) -> Sequence[str]: ...

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> Frame:
        """Decode a frame; what is wrong with it stands in `Frame.problem`, nothing is raised."""
        ...

    def has_ground_truth(self, index: int) -> bool:
        """Tell whether `ground_truth` has an answer, without decoding it."""
        ...

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return (H, W) uint8: 255 salient, 0 not salient, 125 ignored; None if there is none."""
        ...


@runtime_checkable
class KnowsDistances(Protocol):
    """A dataset that knows more than its depth sensor sees, such as a drawn room."""

    def true_depth(self, index: int) -> Depth:
        """Return (H, W) float32 metres along z, without noise, holes or limit of range."""
        ...


@runtime_checkable
class KnowsInstances(Protocol):
    """A dataset whose ground truth may tell one object from another."""

    def instance_truth(self, index: int) -> InstanceTruth | None:
        """Return (H, W) int32: a number an object, 0 = none, -1 = ignored; None if unknown."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """The files of one frame, before any of them is opened.

    depth: where the file should be; None only in recordings without depth.
    problem: what listing the recording already found wrong with the frame.
    """

    id: str
    rgb: Path
    depth: Path | None = None
    T_world_camera: Pose | None = None
    stamp_ns: int | None = None
    ground_truth: Path | None = None
    problem: str | None = None


class Recording:
    """A dataset made of image files, decoded when asked for.

    Depth is taken as registered to the colour image; a layout where it is not overrides
    `read_depth`. Raises `DataError` for a recording of which no frame can be used.

    label_values: of the ground-truth files; None = 255 salient, 0 not salient, else ignored.
    labels: what they mean where no such values are in them.
    mask_fault: why the masks, or the label images, can all not be read; None = they can.
    """

    name = "recording"
    # Depth has no mark of which way up it is, so colour and masks stay as they are stored.
    is_turned = False
    # By "labels" in camera.json, where that does not speak of other images.
    masks_may_be_labelled = True

    def __init__(
        self,
        path: Path,
        entries: Sequence[Entry],
        camera: Camera | None = None,
        *,
        depth_scale: float = 0.001,
        label_values: LabelValues | None = None,
        labels: LabelValues | None = None,
        remarks: Sequence[str] = (),
    ) -> None:
        check_unique_ids(path, entries)
        self.path = path
        self.entries = tuple(entries)
        self.camera = camera
        self.depth_scale = depth_scale
        self.labels = labels
        self.label_values = label_values or GROUND_TRUTH_VALUES
        self.mask_fault: DataError | None = None
        self.remarks = tuple(remarks)
        self.ids = tuple(entry.id for entry in self.entries)
        self.poses = tuple(entry.T_world_camera for entry in self.entries)
        self.size = image_size(path, [entry.rgb for entry in self.entries], self.read_rgb)
        if camera is not None:
            check_image_size(path, camera, self.size)
            check_depth_bits([entry.depth for entry in self.entries if entry.depth])
        if label_values is None:
            self._judge_masks()

    @property
    def has_depth(self) -> bool:
        """Tell whether frames carry depth."""
        return self.camera is not None

    def __len__(self) -> int:
        return len(self.entries)

    def __getitem__(self, index: int) -> Frame:
        entry = self.entries[index]
        problems = [entry.problem] if entry.problem else []
        rgb = self._attempt(lambda: self._read_rgb(entry.rgb), problems)
        depth = None
        if self.camera is not None:
            depth = self._attempt(lambda: self._read_depth(entry.depth), problems)
            if depth is None:
                depth = np.full(self.size[::-1], np.nan, np.float32)
        return Frame(
            id=entry.id,
            rgb=np.zeros((*self.size[::-1], 3), np.uint8) if rgb is None else rgb,
            depth=depth,
            camera=self.camera,
            T_world_camera=entry.T_world_camera,
            stamp_ns=entry.stamp_ns,
            problem="; ".join(problems) or None,
        )

    def has_ground_truth(self, index: int) -> bool:
        """Tell whether there is a ground-truth file for the frame."""
        return self.entries[index].ground_truth is not None

    def ground_truth(self, index: int) -> GroundTruth | None:
        """Return (H, W) uint8: 255 salient, 0 not salient, 125 ignored; None if there is none.

        Raises `DataError` where the file is damaged or not of the colour image's size, and where
        the masks together have no meaning (`mask_fault`).
        """
        path = self.entries[index].ground_truth
        if path is None:
            return None
        if self.mask_fault is not None:
            raise self.mask_fault
        read = read_mask if self.label_values == GROUND_TRUTH_VALUES else read_numbers
        return self.label_values.to_ground_truth(self.read_truth(path, read))

    def with_ground_truth(self, folder: Path) -> Self:
        """Return the same recording with its ground truth read from `folder/<id>.png`."""
        if not folder.is_dir():
            raise DataError(folder, "is not a folder", "give a folder of <frame id>.png")
        files = [_mask_of(folder, id) for id in self.ids]
        if not any(files):
            held = next(iter(find_masks(folder).values()), None)
            found = "holds ground truth for no frame" + (f", but {held.name}" if held else "")
            raise DataError(folder, found, f"name files such as {self.ids[0]}.png")
        other = copy.copy(self)
        other.entries = tuple(
            replace(entry, ground_truth=file)
            for entry, file in zip(self.entries, files, strict=True)
        )
        other._judge_masks()
        if other.mask_fault is not None:
            raise other.mask_fault
        return other

    def read_depth(self, path: Path) -> Depth:
        """Read depth registered to the colour image, (H, W) float32 metres; `UnreadableFile`."""
        return read_depth(path, self.depth_scale)

    def read_rgb(self, path: Path) -> Rgb:
        """Read a colour image, (H, W, 3) uint8; raises `UnreadableFile`."""
        return read_rgb(path, is_turned=self.is_turned)

    def read_truth(
        self, path: Path, read: Callable[..., npt.NDArray[Any]] = read_numbers
    ) -> npt.NDArray[Any]:
        """Read an annotated image, (H, W) as `read` does; `DataError` where it is no good."""
        try:
            values = read(path, is_turned=self.is_turned)
        except UnreadableFile as fault:
            raise DataError(path, str(fault), "replace or delete it") from None
        width, height = self.size
        if values.shape != (height, width):
            found = f"is {values.shape[1]}x{values.shape[0]}, not {width}x{height}"
            raise DataError(path, found, f"make it {width}x{height} like the colour images")
        return values

    def _judge_masks(self) -> None:
        """Find out what the values of the masks mean; see `mask_fault`."""
        files = [entry.ground_truth for entry in self.entries if entry.ground_truth]
        remarks: list[str] = []
        self.label_values, self.mask_fault = GROUND_TRUTH_VALUES, None
        try:
            self.label_values = judge_masks(
                files,
                self.labels,
                remarks,
                is_turned=self.is_turned,
                may_be_labelled=self.masks_may_be_labelled,
            )
        except DataError as fault:
            self.mask_fault = fault
        self.remarks = (*self.remarks, *remarks)

    def _read_rgb(self, path: Path) -> Rgb:
        rgb = self.read_rgb(path)
        if self.camera is not None:
            check_frame_size(path, rgb.shape, self.size)
        return rgb

    def _read_depth(self, path: Path | None) -> Depth:
        if path is None:
            raise UnreadableFile("there is no depth image")
        depth = self.read_depth(path)
        check_frame_size(path, depth.shape, self.size)
        return depth

    @staticmethod
    def _attempt(read: Callable[[], Image], problems: list[str]) -> Image | None:
        try:
            return read()
        except UnreadableFile as fault:
            problems.append(str(fault))
            return None


def _mask_of(folder: Path, id: str) -> Path | None:
    files = (folder / f"{id}{ending}" for ending in MASK_ENDINGS)
    return next((file for file in files if file.is_file()), None)


def check_unique_ids(path: Path, entries: Iterable[Entry]) -> None:
    """Raise `DataError` where two frames have the same id: their outputs would be one file."""
    rgb_of_id: dict[str, Path] = {}
    for entry in entries:
        if entry.id in rgb_of_id:
            found = f"two frames are called '{entry.id}', {rgb_of_id[entry.id]} and {entry.rgb}"
            raise DataError(path, found, "give every colour image a name of its own")
        rgb_of_id[entry.id] = entry.rgb


def assume_camera(
    path: Path,
    entries: Sequence[Entry],
    camera: Camera,
    depth_scale: float,
    remarks: list[str],
    remark: str = "the usual intrinsics of a Kinect are assumed",
) -> CameraFile:
    """Return what a data set is known for, where it has no `camera.json`, and remark on it.

    camera: is scaled to the size of the images. depth_scale: metres per unit.
    """
    remarks.append(f"no camera.json: {remark}")
    size = image_size(path, [entry.rgb for entry in entries])
    return CameraFile(scaled_camera(camera, size), depth_scale)


def image_size(
    path: Path, images: Sequence[Path], read: Callable[[Path], Rgb] = read_rgb
) -> tuple[int, int]:
    """Return (width, height) of the first colour image that can be read; `DataError` if none."""
    if not images:
        raise DataError(path, "holds no colour images", "check that the recording is complete")
    size = first_size(images, read)
    if size is None:
        found = f"none of the {len(images)} colour images can be read"
        raise DataError(path, found, "copy the recording again")
    return size


def first_size(
    paths: Iterable[Path], read: Callable[[Path], Rgb | Depth]
) -> tuple[int, int] | None:
    """Return (width, height) of the first image that can be read; None if none can."""
    for path in paths:
        try:
            shape = read(path).shape
        except UnreadableFile:
            continue
        return shape[1], shape[0]
    return None


def check_image_size(path: Path, camera: Camera, size: tuple[int, int]) -> None:
    """Raise `DataError` where the intrinsics are for another size than the images have."""
    if (camera.width, camera.height) != size:
        raise DataError(
            path,
            f"its intrinsics are for {camera.width}x{camera.height} images, "
            f"but the images are {size[0]}x{size[1]}",
            "correct camera.json",
        )


def check_depth_bits(images: Iterable[Path]) -> None:
    """Raise `DataError` where depth has 8 bits a pixel and no image has the 16 it needs."""
    eight_bit = None
    for path in images:
        try:
            read_depth(path, 1.0)
        except EightBitDepth:
            eight_bit = eight_bit or path
        except UnreadableFile:
            continue
        else:
            return
    if eight_bit:
        remedy = "export 16-bit PNG: distances cannot be recovered from 8 bits"
        raise DataError(eight_bit, "is depth of 8 bits a pixel, like all of it here", remedy)


def check_frame_size(path: Path, shape: Sequence[int], size: tuple[int, int]) -> None:
    """Raise `UnreadableFile` where an image is not (width, height) as the others are."""
    if (shape[1], shape[0]) != size:
        raise UnreadableFile(
            f"{path.name} is {shape[1]}x{shape[0]}, not {size[0]}x{size[1]} as the recording"
        )
