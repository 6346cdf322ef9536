"""Read recordings of Record3D (iPhone, iPad): a .r3d file, or the folder that it unpacks to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.cameras.intrinsics import pixels_of_numbers
from curiosight.datasets.decoding import UnreadableFile, decode_content
from curiosight.datasets.depth_files import DepthForm, Raw
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.scans import remark_on_poses
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import Size, fit_camera, has_shape_of, image_size
from curiosight.datasets.zip_files import ZipMembers
from curiosight.errors import DataError
from curiosight.errors.inputs import read_bytes
from curiosight.frame import Camera, Pose, Rgb, is_rigid
from curiosight.frame.rotations import matrix_of

ENDING, METADATA, FRAMES = ".r3d", "metadata", "rgbd"
# The camera axes of its poses are right, up, backward; y is up in its world.
AXES = np.diag([1.0, -1.0, -1.0, 1.0])
METRES = DepthForm(float_scale=1.0)
LZFSE_START, LZFSE_END = b"bvx", b"bvx$"
NS_PER_SECOND = 1e9
MAX_SECONDS = 1e10


class Record3d(Recording):
    """A recording of Record3D: JPEG, depth and confidence packed with LZFSE, and metadata.

    Depth is smaller than colour and registered to it by the phone. Raises `DataError` where there
    is no metadata, no depth, or nothing that unpacks LZFSE is installed.
    """

    name = "Record3D"
    evidence = f"{FRAMES}/N.jpg with N.depth and {METADATA}"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the path is a .r3d file, or what one unpacks to."""
        if path.is_file():
            return path.suffix.lower() == ENDING
        return (path / METADATA).is_file() and any((path / FRAMES).glob("*.depth"))

    def __init__(self, path: Path) -> None:
        _unpacker(path)
        self._zip = ZipMembers(path) if path.is_file() else None
        self._prefix = "" if self._zip is None else _prefix(self._zip)
        told = self._metadata(path)
        remarks: list[str] = []
        if self._zip is not None and self._zip.is_cut:
            remarks.append("it was cut short: what is whole is read")
        numbers = self._numbers(path, remarks)
        colours = {n: path / FRAMES / f"{n}.jpg" for n in numbers}
        size = image_size(path, list(colours.values()), self.read_rgb)
        cameras = [_camera(path, told, number, size) for number in numbers]
        usual = next((camera for camera in cameras if camera is not None), None)
        if usual is None:
            raise DataError(path, f"{METADATA} holds no intrinsics (K)", "export it again")
        self._told_shape = told.get("dh"), told.get("dw")
        self._colour_size = size
        entries = [
            Entry(
                f"{number:06d}",
                colours[number],
                path / FRAMES / f"{number}.depth",
                _pose(told, number),
                _stamp_ns(told, number),
                confidence=self._confidence(path / FRAMES / f"{number}.conf"),
                camera=camera or usual,
            )
            for number, camera in zip(numbers, cameras, strict=True)
        ]
        remark_on_poses(entries, remarks)
        super().__init__(path, entries, usual, depth_form=METRES, remarks=remarks)

    def read_rgb(self, path: Path) -> Rgb:
        """Decode a colour image; raises `UnreadableFile`. path: as an entry has it."""
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        bgr = decode_content(path.name, self._content(path), flags)
        return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)  # type: ignore[no-any-return]

    def read_raw(self, path: Path) -> Raw:
        """Unpack depth, (h, w) float32 metres; raises `UnreadableFile`."""
        content = self._unpacked(path)
        if len(content) % 4:
            raise UnreadableFile(f"{path.name} holds no floats")
        return self._shaped(path, np.frombuffer(content, "<f4"))

    def read_confidence(self, path: Path) -> npt.NDArray[Any]:
        """Unpack confidence, (h, w) uint8 0 to 2; raises `UnreadableFile`."""
        return self._shaped(path, np.frombuffer(self._unpacked(path), np.uint8))

    def _metadata(self, path: Path) -> dict[str, Any]:
        try:
            told = json.loads(self._content(path / METADATA))
        except UnreadableFile as fault:
            found = f"its {fault}, which tells the camera"
            raise DataError(path, found, "export it again, whole") from None
        except (ValueError, RecursionError):
            told = None
        if not isinstance(told, dict):
            raise DataError(path, f"its {METADATA} is no JSON object", "export it again")
        return told

    def _numbers(self, path: Path, remarks: list[str]) -> list[int]:
        """Return the numbers of the frames that have colour and depth."""
        if self._zip is not None:
            inside = f"{self._prefix}{FRAMES}/"
            names = {n.removeprefix(inside) for n in self._zip.members if n.startswith(inside)}
        else:
            names = {file.name for file in (path / FRAMES).iterdir()}
        of_kind = {
            ending: {int(n.removesuffix(ending)) for n in names if _is_number(n, ending)}
            for ending in (".jpg", ".depth")
        }
        both = of_kind[".jpg"] & of_kind[".depth"]
        if not both:
            found = (
                f"holds {len(of_kind['.jpg'])} colour images and {len(of_kind['.depth'])} depths"
            )
            raise DataError(path, f"{found}, no pair", "export it again, with depth")
        n_lost = len(of_kind[".jpg"] | of_kind[".depth"]) - len(both)
        if n_lost:
            remarks.append(f"{n_lost} frames lack colour or depth: left out")
        return sorted(both)

    def _confidence(self, path: Path) -> Path | None:
        if self._zip is None:
            return path if path.is_file() else None
        return path if self._member(path) in self._zip.members else None

    def _member(self, path: Path) -> str:
        is_frame = path.parent.name == FRAMES
        return self._prefix + (f"{FRAMES}/{path.name}" if is_frame else path.name)

    def _content(self, path: Path) -> bytes:
        if self._zip is not None:
            return self._zip.read(self._member(path))
        try:
            return read_bytes(path)
        except OSError as error:
            raise UnreadableFile(f"{path.name} cannot be read ({error.strerror})") from error

    def _unpacked(self, path: Path) -> bytes:
        content = self._content(path)
        # Only what is whole is given to the decoder, which is not ours.
        if not (content.startswith(LZFSE_START) and content.endswith(LZFSE_END)):
            raise UnreadableFile(f"{path.name} is not whole: no LZFSE")
        try:
            return bytes(_unpacker(self.path).decompress(content))
        except Exception as error:  # each decoder has one of its own
            raise UnreadableFile(f"{path.name} cannot be unpacked") from error

    def _shaped(self, path: Path, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        told = [side for side in self._told_shape if isinstance(side, int) and side > 0]
        shape = _shape(len(values), told, self._colour_size)
        if shape is None:
            raise UnreadableFile(f"{path.name} holds {len(values)} readings, no image like colour")
        return values.reshape(shape)


def _unpacker(path: Path) -> Any:
    """Return the module that unpacks LZFSE; raises `DataError` where there is none."""
    for name in ("lzfse", "liblzfse"):
        try:
            return __import__(name)
        except ImportError:
            continue
    found = "is a recording of Record3D; its depth needs lzfse, which is missing"
    raise DataError(path, found, "pip install 'curiosight[record3d]'")


def _prefix(members: ZipMembers) -> str:
    """Return the folder in the file that it lies in, with a slash; "" = in none."""
    found = [name for name in members.members if Path(name).name == METADATA]
    return min(found, key=len, default="").removesuffix(METADATA)


def _is_number(name: str, ending: str) -> bool:
    return name.endswith(ending) and name.removesuffix(ending).isdecimal()


def _shape(n: int, told: list[int], size: Size) -> tuple[int, int] | None:
    """Return (height, width) of n readings: as told, or of colour's shape."""
    if len(told) == 2 and told[0] * told[1] == n:
        height, width = told
        is_turned = not has_shape_of((width, height), size) and has_shape_of((height, width), size)
        return (width, height) if is_turned else (height, width)
    width = round((n * size[0] / size[1]) ** 0.5)
    return (n // width, width) if width and n % width == 0 else None


def _camera(path: Path, told: dict[str, Any], number: int, size: Size) -> Camera | None:
    """Return the intrinsics of a frame, for colour of (width, height); None where none are told.

    Its own stand before K, which is a matrix column after column.
    """
    pixels = pixels_of_numbers(_numbers(_at(told, "perFrameIntrinsicCoeffs", number)))
    pixels = pixels or pixels_of_numbers(_numbers(told.get("K")))
    if pixels is None:
        return None
    sides = _numbers([told.get("w"), told.get("h")])
    of_size = (int(sides[0]), int(sides[1])) if len(sides) == 2 and min(sides) >= 1 else size
    return fit_camera(path, Camera(*of_size, *pixels), size)


def _pose(told: dict[str, Any], number: int) -> Pose | None:
    """Return camera to world of qx qy qz qw x y z; None where these are no pose."""
    numbers = _numbers(_at(told, "poses", number))
    if len(numbers) != 7 or not 0.9 < np.linalg.norm(numbers[:4]) < 1.1:
        return None
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(numbers[:4])
    pose[:3, 3] = numbers[4:]
    pose = pose @ AXES
    return pose if is_rigid(pose) else None


def _stamp_ns(told: dict[str, Any], number: int) -> int | None:
    seconds = _numbers([_at(told, "frameTimestamps", number)])
    if not seconds and (rate := _numbers([told.get("fps")])) and rate[0] > 0:
        seconds = [number / rate[0]]
    is_time = bool(seconds) and 0 <= seconds[0] < MAX_SECONDS
    return round(seconds[0] * NS_PER_SECOND) if is_time else None


def _at(told: dict[str, Any], key: str, number: int) -> Any:
    """Return what a list in the metadata says of a frame; None where it says nothing."""
    values = told.get(key)
    return values[number] if isinstance(values, list) and number < len(values) else None


def _numbers(values: Any) -> list[float]:
    """Return finite numbers of a list; empty where these are none."""
    try:
        numbers = np.asarray(values, np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        return []
    return numbers.tolist() if np.isfinite(numbers).all() else []
