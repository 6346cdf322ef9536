"""Write Matroska files as an Azure Kinect does, element by element."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from curiosight.frame import Camera, Pose

SCALE_NS = 1000
CLUSTER, SEGMENT = 0x1F43B675, 0x18538067


@dataclass(frozen=True)
class KinectTrack:
    """A track: its name, four letters, size, and its (nanoseconds, bytes)."""

    name: str
    four: str
    size: tuple[int, int]
    blocks: Sequence[tuple[int, bytes]]


def element(id: int, content: bytes | int | str) -> bytes:
    if isinstance(content, int):
        content = content.to_bytes(max(1, (content.bit_length() + 7) // 8), "big")
    content = content.encode() if isinstance(content, str) else content
    n_bytes = (id.bit_length() + 7) // 8
    return id.to_bytes(n_bytes, "big") + struct.pack(">Q", len(content) | 1 << 56) + content


def write_kinect(
    tracks: Sequence[KinectTrack],
    calibration: bytes | None,
    *,
    tagged: bool = True,
    is_open: bool = False,
) -> bytes:
    """Return a file; tagged: tags tell the tracks; is_open: no lengths, as while it runs."""
    head = element(0x1A45DFA3, element(0x4282, "matroska"))
    body = element(0x1549A966, element(0x2AD7B1, SCALE_NS))
    body += element(
        0x1654AE6B,
        b"".join(element(0xAE, _entry(n, track)) for n, track in enumerate(tracks, 1)),
    )
    if calibration is not None:
        named = element(0x466E, "calibration.json") + element(0x4660, "application/octet-stream")
        body += element(0x1941A469, element(0x61A7, named + element(0x465C, calibration)))
    if tagged:
        body += element(0x1254C367, b"".join(_tags(tracks)))
    times = sorted({time for track in tracks for time, _ in track.blocks})
    for time in times:
        blocks = element(0xE7, time // SCALE_NS)
        for number, track in enumerate(tracks, 1):
            for at, content in track.blocks:
                if at == time:
                    blocks += element(0xA3, struct.pack(">BhB", 0x80 | number, 0, 0x80) + content)
        body += _open(CLUSTER, blocks) if is_open else element(CLUSTER, blocks)
    return head + (_open(SEGMENT, body) if is_open else element(SEGMENT, body))


def _open(id: int, content: bytes) -> bytes:
    return id.to_bytes(4, "big") + b"\x01" + b"\xff" * 7 + content


def _entry(number: int, track: KinectTrack) -> bytes:
    width, height = track.size
    header = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 24, track.four.encode(), *[0] * 5)
    return (
        element(0xD7, number)
        + element(0x73C5, 1000 + number)
        + element(0x83, 1)
        + element(0x536E, track.name)
        + element(0x86, "V_MS/VFW/FOURCC")
        + element(0x63A2, header)
        + element(0xE0, element(0xB0, width) + element(0xBA, height))
    )


def _tags(tracks: Sequence[KinectTrack]) -> list[bytes]:
    tags = []
    for number, track in enumerate(tracks, 1):
        target = element(0x63C0, element(0x63C5, 1000 + number))
        told = element(0x45A3, f"K4A_{track.name}_TRACK") + element(0x4487, str(1000 + number))
        tags.append(element(0x7373, target + element(0x67C8, told)))
    named = element(0x45A3, "K4A_CALIBRATION_FILE") + element(0x4487, "calibration.json")
    tags.append(element(0x7373, element(0x63C0, b"") + element(0x67C8, named)))
    return tags


def calibration_of(
    colour: Camera,
    depth: Camera,
    T_colour_depth: Pose,
    *,
    depth_sensor: tuple[int, int] | None = None,
    corner: tuple[int, int] = (0, 0),
    bend: Sequence[float] = (0.0,) * 8,
) -> bytes:
    """Return calibration.json; depth_sensor, corner: what depth's image is cut out of.

    bend: k1 to k6, p2, p1 of the depth lens.
    """

    def lens(
        camera: Camera, sensor: tuple[int, int], cut: tuple[int, int], bent: Sequence[float]
    ) -> list[float]:
        return [
            (camera.cx + 0.5 + cut[0]) / sensor[0],
            (camera.cy + 0.5 + cut[1]) / sensor[1],
            camera.fx / sensor[0],
            camera.fy / sensor[1],
            *bent[:6],
            *(0.0, 0.0),
            *bent[6:],
        ]

    def one(place: str, numbers: list[float], pose: Pose) -> dict[str, Any]:
        return {
            "Intrinsics": {"ModelParameterCount": 14, "ModelParameters": numbers},
            "Location": f"CALIBRATION_CameraLocation{place}",
            "Rt": {
                "Rotation": pose[:3, :3].ravel().tolist(),
                "Translation": pose[:3, 3].tolist(),
            },
        }

    whole = colour.width, round(colour.width * 3 / 4)
    cut = (0, (whole[1] - colour.height) // 2)
    of_depth = lens(depth, depth_sensor or (depth.width, depth.height), corner, bend)
    cameras = [
        one("D0", of_depth, np.eye(4)),
        one("PV0", lens(colour, whole, cut, (0.0,) * 8), T_colour_depth),
    ]
    told = {"CalibrationInformation": {"Cameras": cameras, "InertialSensors": []}}
    return json.dumps(told).encode() + b"\0"
