"""The class that all layouts of image files build on."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
import numpy.typing as npt

from curiosight.datasets.cameras.camera_file import (
    GROUND_TRUTH_VALUES,
    LabelValues,
    scaled_camera,
)
from curiosight.datasets.cameras.depth_camera import DepthCamera, read_depth_camera, with_window
from curiosight.datasets.dataset import GroundTruth
from curiosight.datasets.decoding import UnreadableFile, read_grey, read_rgb
from curiosight.datasets.depth_files import MILLIMETRES, DepthForm, Raw, read_raw_depth
from curiosight.datasets.entries import Entry, check_unique_ids
from curiosight.datasets.masks import (
    MASK_ENDINGS,
    find_masks,
    judge_masks,
    read_mask,
    read_numbers,
)
from curiosight.datasets.poses_of_entries import inverted, moved_out, turned, with_changed_poses
from curiosight.datasets.reading import Reading, axes_of
from curiosight.datasets.sizes import (
    Size,
    check_frame_size,
    first_depth,
    fit_camera,
    fit_to,
    has_shape_of,
    image_size,
)
from curiosight.errors import DataError
from curiosight.frame import Camera, Depth, Frame, Mount, Pose, Rgb

Image = TypeVar("Image", Rgb, Depth)

UNITS = {1.0: "a metre", 0.001: "a millimetre"}
# What the makers of phones call medium; below it are edges and what is too far.
USUAL_CONFIDENCE = 1


class Recording:
    """A dataset made of image files, decoded when asked for.

    Raises `DataError` for a recording of which no frame can be used.

    camera: of the colour images; of another size than they have, it is scaled where the shape
        is the same. An `Entry` may have its own, as cameras that focus do.
    depth_form: what the numbers of depth files mean.
    depth_camera: where depth is not registered to colour; None = it is. Registered depth of
        another size is brought to colour's.
    label_values: of the ground-truth files; None = 255 salient, 0 not salient, else ignored.
    labels: what they mean where no such values are in them.
    mask_fault: why the masks, or the label images, can all not be read; None = they can.
    reasons: what the layout was told by beside `evidence`, in words.
    has_lost_all_poses: there should be some, and none of them is one: then none is missed.
    """

    name = "recording"
    evidence = ""
    # Whether what is called so comes in any unit: then readings decide where no file says it.
    has_any_unit = False
    # Depth has no mark of which way up it is, so colour and masks stay as they are stored.
    is_turned = False
    # By "labels" in camera.json, where that does not speak of other images.
    masks_may_be_labelled = True
    # How the camera is held, by "mount" in camera.json; None = not said.
    mount: Mount | None = None

    def __init__(
        self,
        path: Path,
        entries: Sequence[Entry],
        camera: Camera | None = None,
        *,
        depth_form: DepthForm = MILLIMETRES,
        depth_camera: DepthCamera | None = None,
        label_values: LabelValues | None = None,
        labels: LabelValues | None = None,
        remarks: Sequence[str] = (),
        reasons: Sequence[str] = (),
    ) -> None:
        check_unique_ids(path, entries)
        self.path = path
        self.entries = tuple(entries)
        self.depth_form = depth_form
        self.depth_camera = depth_camera
        self.min_confidence = USUAL_CONFIDENCE
        self.labels = labels
        self.label_values = label_values or GROUND_TRUTH_VALUES
        self.mask_fault: DataError | None = None
        self.reasons = tuple(filter(None, (self.evidence, *reasons)))
        self.ids = tuple(entry.id for entry in self.entries)
        self.poses = self._colour_poses()
        has_problems = any(entry.pose_problem for entry in self.entries)
        self.has_lost_all_poses = has_problems and not any(p is not None for p in self.poses)
        self.size = self.colour_size()
        self.camera = None if camera is None else fit_camera(path, camera, self.size)
        self._intrinsics_size = self.size if camera is None else (camera.width, camera.height)
        self.depth_size: tuple[int, int] | None = None
        self._has_floats = False
        if camera is not None:
            depth_files = [entry.depth for entry in self.entries if entry.depth]
            raw = first_depth(depth_files, self.read_raw)
            if raw is not None:
                self.depth_size = raw.shape[1], raw.shape[0]
                self._has_floats = raw.dtype.kind == "f"
        self.remarks_on_files = tuple(remarks)
        if label_values is None:
            self._judge_masks()

    @property
    def has_depth(self) -> bool:
        """Tell whether frames carry depth."""
        return self.camera is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Say how the files were read, as far as their owner should know."""
        lost = ("none of its poses is one: read without",) if self.has_lost_all_poses else ()
        return (*self.remarks_on_files, *lost, *self._remarks_on_depth())

    @property
    def is_unit_open(self) -> bool:
        """Tell whether neither a file nor the layout says the unit of depth."""
        return self.has_any_unit and self.depth_form.is_assumed

    @property
    def depth_scale(self) -> float:
        """Return metres per unit of depth."""
        return self.depth_form.float_scale if self._has_floats else self.depth_form.scale

    def __len__(self) -> int:
        return len(self.entries)

    def __getitem__(self, index: int) -> Frame:
        entry = self.entries[index]
        pose_problem = None if self.has_lost_all_poses else entry.pose_problem
        problems = [problem for problem in (entry.problem, pose_problem) if problem]
        rgb = self._attempt(lambda: self._read_rgb(entry), problems)
        depth = None
        if self.camera is not None:
            depth = self._attempt(lambda: self._read_depth(entry), problems)
            if depth is None:
                depth = np.full(self.size[::-1], np.nan, np.float32)
        return Frame(
            id=entry.id,
            rgb=np.zeros((*self.size[::-1], 3), np.uint8) if rgb is None else rgb,
            depth=depth,
            camera=self.camera_of(entry),
            T_world_camera=self.poses[index],
            stamp_ns=entry.stamp_ns,
            problem="; ".join(problems) or None,
        )

    def camera_of(self, entry: Entry) -> Camera | None:
        """Return the intrinsics of a frame's colour image."""
        if self.camera is None or entry.camera is None:
            return self.camera
        return scaled_camera(entry.camera, self.size)

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

    def read_as(self, reading: Reading) -> Self:
        """Return the same recording, read as its owner says; `fix_units` is not done here."""
        other = copy.copy(self)
        if reading.depth_scale:
            other.depth_form = replace(
                self.depth_form,
                scale=reading.depth_scale,
                float_scale=reading.depth_scale,
                is_assumed=False,
            )
        if reading.min_confidence >= 0:
            other.min_confidence = reading.min_confidence
        if reading.invert_poses:
            other.entries = with_changed_poses(other.entries, inverted)
        if reading.pose_axes:
            axes = axes_of(reading.pose_axes)
            other.entries = with_changed_poses(other.entries, lambda pose: turned(pose, axes))
        if reading.depth_camera and self.camera is not None:
            other.depth_camera = read_depth_camera(Path(reading.depth_camera), self.depth_size)
            other.entries = tuple(replace(entry, depth_camera=None) for entry in other.entries)
            other.camera = with_window(self.path, self.camera, other.depth_camera)
        other.poses = other._colour_poses()
        return other

    def colour_size(self) -> Size:
        """Return (width, height) of the colour images; `DataError` where none can be read."""
        return image_size(self.path, [entry.rgb for entry in self.entries], self.read_rgb)

    def decode_rgb(self, entry: Entry) -> Rgb:
        """Decode a frame's colour, (H, W, 3) uint8; raises `UnreadableFile`.

        With `colour_size`, what a recording has of its own whose colour is no image files.
        """
        return self.read_rgb(entry.rgb)

    def with_bits_rotated_by(self, n_bits: int) -> Self:
        """Return the same recording whose bits of depth were stored rotated to the left."""
        other = copy.copy(self)
        other.depth_form = replace(self.depth_form, rotated_bits=n_bits)
        return other

    def with_positions_times(self, factor: float) -> Self:
        """Return the same recording with the positions of its poses in another unit."""
        other = copy.copy(self)
        other.entries = with_changed_poses(self.entries, lambda pose: moved_out(pose, factor))
        other.poses = other._colour_poses()
        return other

    def read_depth(self, path: Path) -> Depth:
        """Read depth as it was recorded, (h, w) float32 metres; raises `UnreadableFile`."""
        return self.depth_form.to_metres(self.read_raw(path))

    def read_raw(self, path: Path) -> Raw:
        """Read the (h, w) numbers of a depth image as they are; raises `UnreadableFile`."""
        return read_raw_depth(path)

    def read_confidence(self, path: Path) -> npt.NDArray[Any]:
        """Read how sure depth is, (h, w) whole numbers; raises `UnreadableFile`."""
        return read_grey(path)

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

    def _colour_poses(self) -> tuple[Pose | None, ...]:
        """Return (4, 4) camera-to-world of the colour camera for each frame, None = unknown."""
        poses = tuple(entry.T_world_camera for entry in self.entries)
        if self.depth_camera is None or not self.depth_camera.has_the_poses:
            return poses
        T_depth_colour = np.linalg.inv(self.depth_camera.T_colour_depth)
        return tuple(None if pose is None else pose @ T_depth_colour for pose in poses)

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
        self.remarks_on_files = (*self.remarks_on_files, *remarks)

    def _read_rgb(self, entry: Entry) -> Rgb:
        rgb = self.decode_rgb(entry)
        if self.camera is not None:
            check_frame_size(entry.rgb, rgb.shape, self.size)
        return rgb

    def _read_depth(self, entry: Entry) -> Depth:
        """Read a frame's depth as the colour camera sees it."""
        if entry.depth is None:
            raise UnreadableFile("there is no depth image")
        depth = self.read_depth(entry.depth)
        if self.depth_size is not None:
            check_frame_size(entry.depth, depth.shape, self.depth_size)
        if entry.confidence is not None and self.min_confidence > 0:
            confidence = fit_to(self.read_confidence(entry.confidence), depth.shape[1::-1])
            depth[confidence < self.min_confidence] = np.nan
        depth_camera = entry.depth_camera or self.depth_camera
        if depth_camera is not None:
            camera = self.camera_of(entry)
            assert camera is not None
            return depth_camera.registered(depth, camera)
        if not has_shape_of(depth.shape[1::-1], self.size):
            size, colour = f"{depth.shape[1]}x{depth.shape[0]}", f"{self.size[0]}x{self.size[1]}"
            raise UnreadableFile(
                f"{entry.depth.name} is {size} where colour is {colour}, another shape: depth is "
                "not registered to colour (--depth-camera FILE can say how it is)"
            )
        return fit_to(depth, self.size)

    def _remarks_on_depth(self) -> Iterator[str]:
        """Say in what unit depth is taken to be, and where sizes are brought together."""
        if self.camera is None:
            return
        colour = f"{self.size[0]}x{self.size[1]}"
        if self._intrinsics_size != self.size:
            width, height = self._intrinsics_size
            yield f"its intrinsics are for {width}x{height}: scaled to {colour}"
        if self.depth_form.is_assumed:
            unit = UNITS.get(self.depth_scale, f"{self.depth_scale:.6g} m")
            yield f"no file says the unit of depth: {unit} is taken"
        if self.depth_size is None or self.depth_camera is not None:
            return
        if self.depth_size != self.size and has_shape_of(self.depth_size, self.size):
            width, height = self.depth_size
            yield f"depth is {width}x{height}: brought to {colour} like colour, nearest reading"

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
