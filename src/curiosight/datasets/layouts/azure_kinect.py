"""Read recordings of Azure Kinect and Femto: Matroska files of colour, depth, and calibration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

from curiosight.datasets.association import MAX_OFFSET_NS, associate
from curiosight.datasets.cameras.azure_kinect import Lens, read_calibration
from curiosight.datasets.cameras.camera_file import read_camera_file
from curiosight.datasets.cameras.depth_camera import DepthCamera, with_window
from curiosight.datasets.coded_video import CodedVideo
from curiosight.datasets.decoding import UnreadableFile, decode_content
from curiosight.datasets.depth_files import MILLIMETRES, Raw
from curiosight.datasets.entries import Entry
from curiosight.datasets.matroska import Matroska, Track
from curiosight.datasets.recording import Recording
from curiosight.errors import DataError
from curiosight.frame import Camera, Rgb

ENDING = ".mkv"
DEPTH_FOURS = ("b16g",)
JPEGS = ("MJPG",)
# Pixels as the sensor gives them: rows of bytes for each row of pixels, and how they are read.
RAW = {
    "NV12": (1.5, 1, cv2.COLOR_YUV2RGB_NV12),
    "YUY2": (1.0, 2, cv2.COLOR_YUV2RGB_YUY2),
    "BGRA": (1.0, 4, cv2.COLOR_BGRA2RGB),
}


class AzureKinect(Recording):
    """A recording of an Azure Kinect, or what writes as it does; its lenses are straightened.

    Raises `DataError` where colour, depth or calibration is missing, or no colour image has depth.
    """

    name = "Azure Kinect"
    evidence = "Matroska with a track of depth"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the path is a Matroska file with a track of depth."""
        if path.suffix.lower() != ENDING or not path.is_file():
            return False
        return _find(Matroska(path, with_blocks=False), "DEPTH") is not None

    def __init__(self, path: Path) -> None:
        self._file = Matroska(path)
        self._track_of = {role: _find(self._file, role) for role in ("COLOR", "DEPTH")}
        self._coded: dict[str, CodedVideo] = {}
        self._lenses: dict[str, Lens] = {}
        self._numbers: dict[Path, int] = {}
        remarks = ["it was cut short: what is whole is read"] if self._file.is_cut else []
        entries = self._list_frames(path, remarks)
        camera, depth_camera = self._cameras(path, remarks)
        super().__init__(
            path,
            entries,
            camera,
            depth_form=MILLIMETRES,
            depth_camera=depth_camera,
            remarks=remarks,
        )

    def read_rgb(self, path: Path) -> Rgb:
        """Decode a colour image; raises `UnreadableFile`. path: as an entry has it."""
        rgb = self._read("COLOR", path, self._decode_colour)
        return self._lenses["COLOR"].straightened(rgb) if "COLOR" in self._lenses else rgb

    def read_raw(self, path: Path) -> Raw:
        """Decode depth, (h, w) millimetres; raises `UnreadableFile`. path: as an entry has it."""
        raw = self._read("DEPTH", path, self._decode_depth)
        return self._lenses["DEPTH"].straightened(raw) if "DEPTH" in self._lenses else raw

    def _list_frames(self, path: Path, remarks: list[str]) -> list[Entry]:
        """Pair colour with depth by their times."""
        listed: dict[str, list[tuple[int, Path]]] = {}
        for role, track in self._track_of.items():
            if track is None or not track.blocks:
                found = f"has no track of {role.lower()}" if track is None else "has no images of"
                found += "" if track is None else f" {role.lower()}"
                raise DataError(path, found, "record it again, with colour and depth")
            track.blocks.sort()
            listed[role] = []
            for number, block in enumerate(track.blocks):
                file = path / f"{role.lower()} {number:06d}"
                self._numbers[file] = number
                listed[role].append((block.time_ns, file))
        pairs = associate(listed["COLOR"], listed["DEPTH"])
        if not pairs:
            found = f"no colour image has depth within {MAX_OFFSET_NS // 1_000_000} ms"
            raise DataError(path, found, "record colour and depth at once")
        n_left = len(listed["COLOR"]) - len(pairs)
        if n_left:
            remarks.append(f"{n_left} colour images have no depth at their time: left out")
        return [
            Entry(f"{self._numbers[rgb]:06d}", rgb, depth, stamp_ns=stamp)
            for stamp, rgb, depth in pairs
        ]

    def _cameras(self, path: Path, remarks: list[str]) -> tuple[Camera, DepthCamera | None]:
        """Return the camera of colour, and that of depth; by its calibration, else camera.json."""
        sizes = [(track.width, track.height) for track in self._track_of.values() if track]
        named = self._file.tags.get("K4A_CALIBRATION_FILE", "calibration.json")
        content = self._file.attachments.get(named, b"")
        lenses = read_calibration(content, *sizes)
        if lenses is None:
            own = read_camera_file(path.parent)
            if own is None:
                found = "holds no calibration of an Azure Kinect"
                remedy = (
                    "put a camera.json beside it, and say where depth's is: --depth-camera FILE"
                )
                raise DataError(path, found, remedy)
            remarks.append("camera of camera.json")
            return own.camera, None
        colour, depth = lenses
        self._lenses = {"COLOR": colour, "DEPTH": depth}
        if colour.distortion is not None or depth.distortion is not None:
            remarks.append("its lenses are straightened by its calibration")
        T_colour_depth = colour.T_camera_rig @ np.linalg.inv(depth.T_camera_rig)
        beside = DepthCamera(depth.camera, T_colour_depth)
        remarks.append("depth is registered to colour by its calibration")
        return with_window(path, colour.camera, beside), beside

    def _read(self, role: str, path: Path, decode: Callable[[Track, bytes, str], Raw]) -> Raw:
        track = self._track_of[role]
        assert track is not None
        number = self._numbers[path]
        if _is_plain(track):
            return decode(track, self._file.read(track.blocks[number]), path.name)
        if role not in self._coded:
            self._coded[role] = CodedVideo(self._file.path, self._file.tracks.index(track))
        times = [block.time_ns for block in track.blocks]
        gap_ns = int(np.median(np.diff(times))) if len(times) > 1 else MAX_OFFSET_NS
        return self._coded[role].read(times[number], gap_ns, is_depth=role == "DEPTH")

    @staticmethod
    def _decode_colour(track: Track, content: bytes, name: str) -> Raw:
        if track.four not in RAW:
            flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
            bgr = decode_content(name, content, flags)
            return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB))
        rows, n_channels, code = RAW[track.four]
        shape = (round(track.height * rows), track.width, n_channels)
        return np.asarray(cv2.cvtColor(_shaped(content, np.dtype(np.uint8), shape, name), code))

    @staticmethod
    def _decode_depth(track: Track, content: bytes, name: str) -> Raw:
        shape = (track.height, track.width)
        return _shaped(content, np.dtype(">u2"), shape, name).astype(np.uint16)


def _shaped(content: bytes, dtype: np.dtype, shape: Sequence[int], name: str) -> Raw:
    if len(content) != dtype.itemsize * int(np.prod(shape)):
        raise UnreadableFile(f"{name} has {len(content)} bytes, no image of its track")
    return np.frombuffer(content, dtype).reshape(shape)


def _is_plain(track: Track) -> bool:
    """Tell whether each block is an image by itself, of a kind that needs no decoder."""
    return track.four in (*DEPTH_FOURS, *JPEGS, *RAW) or track.codec == "V_MJPEG"


def _find(file: Matroska, role: str) -> Track | None:
    """Return the track of COLOR or DEPTH: by its tag, by its name, or of depth by its form."""
    tag = f"K4A_{role}_TRACK"
    for track in file.tracks:
        if tag in track.tags or file.tags.get(tag) == str(track.uid):
            return track
    for track in file.tracks:
        if track.name.upper() == role:
            return track
    pictures = [track for track in file.tracks if track.width and not _is_infrared(track)]
    fits = [track for track in pictures if _is_deep(track) == (role == "DEPTH")]
    is_kinects = any(_is_deep(track) for track in pictures)
    return fits[0] if fits and is_kinects else None


def _is_infrared(track: Track) -> bool:
    return track.name.upper() == "IR" or "K4A_IR_TRACK" in track.tags


def _is_deep(track: Track) -> bool:
    return track.four in DEPTH_FOURS
