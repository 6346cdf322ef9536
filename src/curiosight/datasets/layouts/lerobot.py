"""Read data sets of LeRobot, v3, with depth: videos of colour, and of depth in 12 bits."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.datasets.cameras.calibration import KINECT, KINECTS, usual_camera
from curiosight.datasets.cameras.camera_file import read_camera_file
from curiosight.datasets.coded_video import CodedVideo, count_frames, require_av
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DepthForm, Raw
from curiosight.datasets.entries import Entry
from curiosight.datasets.listing import natural_key
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError
from curiosight.errors.inputs import read_json_object
from curiosight.frame import Depth, Rgb

INFO = "meta/info.json"
N_CODES = 4096
NOT_TOLD = (
    "it does not say whether depth is registered to colour: taken so (--depth-camera FILE says "
    "otherwise)"
)
METRES = DepthForm(float_scale=1.0)


@dataclass(frozen=True, slots=True)
class Quantiser:
    """How metres became codes of 12 bits: 0 is `depth_min` and less, the last `depth_max` and more.

    Lengths are metres; shift is added before the logarithm, where one is taken.
    """

    depth_min: float = 0.01
    depth_max: float = 10.0
    shift: float = 3.5
    use_log: bool = True

    def to_metres(self, codes: Raw) -> Depth:
        """Return (H, W) float32 metres, NaN where a code is of no reading, or beyond the ends."""
        ends = np.array([self.depth_min, self.depth_max])
        low, high = np.log(ends + self.shift) if self.use_log else ends
        values = low + codes.astype(np.float32) * (high - low) / (N_CODES - 1)
        metres = np.exp(values) - self.shift if self.use_log else values
        metres[(codes <= 0) | (codes >= N_CODES - 1)] = np.nan
        return np.asarray(metres, np.float32)


class LeRobot(Recording):
    """A data set of LeRobot with a video of depth. Its episodes follow each other.

    Raises `DataError` where no video of depth is in it, or PyAV is not installed.
    """

    name = "LeRobot"
    evidence = f"{INFO} with codebase_version"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder says of itself that it is such a data set."""
        return path.is_dir() and "codebase_version" in read_json_object(path / INFO)

    def __init__(self, path: Path) -> None:
        told = read_json_object(path / INFO)
        features = told.get("features")
        features = features if isinstance(features, dict) else {}
        colour, depth = _keys(path, features)
        require_av(path)
        self._quantiser = _quantiser(path, features[depth])
        fps = told.get("fps")
        self._fps = float(fps) if isinstance(fps, int | float) and fps > 0 else 30.0
        self._videos = {"color": _Videos(path, colour), "depth": _Videos(path, depth)}
        counts = {role: len(videos) for role, videos in self._videos.items()}
        remarks = [f"colour {colour}, depth {depth}", NOT_TOLD]
        if counts["color"] != counts["depth"]:
            remarks.append(f"{counts['color']} colour images, {counts['depth']} of depth")
        n_frames = min(counts.values())
        entries = [
            Entry(
                f"{number:06d}",
                path / f"color {number:06d}",
                path / f"depth {number:06d}",
                stamp_ns=round(number / self._fps * 1e9),
            )
            for number in range(n_frames)
        ]
        own = read_camera_file(path)
        size = image_size(path, [entry.rgb for entry in entries], self.read_rgb)
        if own is None:
            remarks.append(f"LeRobot stores no intrinsics: {KINECTS}")
        camera = usual_camera(KINECT, size) if own is None else own.camera
        super().__init__(path, entries, camera, depth_form=METRES, remarks=remarks)

    def read_rgb(self, path: Path) -> Rgb:
        """Decode a colour image; raises `UnreadableFile`. path: as an entry has it."""
        return self._frame(path, is_depth=False)

    def read_raw(self, path: Path) -> Raw:
        """Decode depth, (h, w) metres; raises `UnreadableFile`. path: as an entry has it."""
        codes = self._frame(path, is_depth=True)
        if int(codes.max(initial=0)) >= N_CODES:
            raise UnreadableFile(f"{path.name} has more than 12 bits")
        return self._quantiser.to_metres(codes)

    def _frame(self, path: Path, *, is_depth: bool) -> Raw:
        role, number = path.name.split()
        return self._videos[role].read(int(number), self._fps, is_depth=is_depth)


class _Videos:
    """The videos of a camera, one after the other; one is open at a time."""

    def __init__(self, path: Path, key: str) -> None:
        files = (path / "videos" / key).glob("chunk-*/file-*.mp4")
        self._files = sorted(files, key=lambda file: natural_key(str(file)))
        if not self._files:
            raise DataError(path, f"has no videos of {key}", "copy it again, with videos/")
        self._ends = list(accumulate(count_frames(file) for file in self._files))
        self._open: tuple[int, CodedVideo] | None = None

    def __len__(self) -> int:
        return self._ends[-1]

    def read(self, number: int, fps: float, *, is_depth: bool) -> Raw:
        place = bisect_right(self._ends, number)
        within = number - (self._ends[place - 1] if place else 0)
        if self._open is None or self._open[0] != place:
            self._open = place, CodedVideo(self._files[place], 0)
        step_ns = round(1e9 / fps)
        return self._open[1].read(round(within / fps * 1e9), step_ns, is_depth=is_depth)


def _info(feature: Any) -> dict[str, Any]:
    """Return what is said of a feature's video; what is said twice as the newer key has it."""
    told: dict[str, Any] = {}
    for key in ("video_info", "info"):
        part = feature.get(key) if isinstance(feature, dict) else None
        told |= part if isinstance(part, dict) else {}
    return told


def _keys(path: Path, features: dict[str, Any]) -> tuple[str, str]:
    """Return the colour and the depth to read: of those called alike, the first."""
    videos = {key: _info(value) for key, value in features.items() if _is_video(value)}
    depths = [key for key, told in videos.items() if _is_depth(told)]
    colours = [key for key in videos if key not in depths]
    if not depths or not colours:
        found = f"is a data set of LeRobot without a video of {'depth' if colours else 'colour'}"
        remedy = "for colour alone give a video in videos/; depth in images/ or data/ is not read"
        raise DataError(path, found, remedy)
    pairs = [(colour, depth) for depth in depths for colour in colours]
    return max(pairs, key=lambda pair: (_n_alike(*pair), -len(pair[0])))


def _n_alike(one: str, other: str) -> int:
    """Count the letters that two names begin with alike."""
    return sum(1 for _ in takewhile(lambda ab: ab[0] == ab[1], zip(one, other, strict=False)))


def _is_video(feature: Any) -> bool:
    return isinstance(feature, dict) and feature.get("dtype") == "video"


def _is_depth(told: dict[str, Any]) -> bool:
    return bool(told.get("is_depth_map") or told.get("video.is_depth_map"))


def _quantiser(path: Path, feature: Any) -> Quantiser:
    told = _info(feature)
    given = {name: told.get(f"video.{name}") for name in Quantiser.__dataclass_fields__}
    known: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    try:
        quantiser = Quantiser(**known)
        ends = quantiser.depth_min, quantiser.depth_max
        is_sound = ends[0] < ends[1] < np.inf
        is_sound &= not quantiser.use_log or ends[0] + quantiser.shift > 0
    except TypeError:
        is_sound = False
    if not is_sound:
        raise DataError(path, f"tells no range of depth, but {known}", f"correct {INFO}")
    return quantiser
