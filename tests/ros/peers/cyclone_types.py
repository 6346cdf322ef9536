"""The messages that Cyclone DDS sends and hears, as its IDL structures."""

# Its structures read their annotations, so these are no strings.

from dataclasses import dataclass
from typing import Any, get_type_hints

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, sequence, uint8, uint32


def _name(package: str, message: str) -> str:
    return f"{package}::msg::dds_::{message}_"


@dataclass
class Time(IdlStruct, typename=_name("builtin_interfaces", "Time")):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename=_name("std_msgs", "Header")):
    stamp: Time
    frame_id: str


@dataclass
class Image(IdlStruct, typename=_name("sensor_msgs", "Image")):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class RegionOfInterest(IdlStruct, typename=_name("sensor_msgs", "RegionOfInterest")):
    x_offset: uint32
    y_offset: uint32
    height: uint32
    width: uint32
    do_rectify: bool


@dataclass
class CameraInfo(IdlStruct, typename=_name("sensor_msgs", "CameraInfo")):
    header: Header
    height: uint32
    width: uint32
    distortion_model: str
    d: sequence[float64]
    k: array[float64, 9]
    r: array[float64, 9]
    p: array[float64, 12]
    binning_x: uint32
    binning_y: uint32
    roi: RegionOfInterest


@dataclass
class Vector3(IdlStruct, typename=_name("geometry_msgs", "Vector3")):
    x: float64
    y: float64
    z: float64


@dataclass
class Point(IdlStruct, typename=_name("geometry_msgs", "Point")):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename=_name("geometry_msgs", "Quaternion")):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct, typename=_name("geometry_msgs", "Transform")):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename=_name("geometry_msgs", "TransformStamped")):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename=_name("tf2_msgs", "TFMessage")):
    transforms: sequence[TransformStamped]


@dataclass
class Pose(IdlStruct, typename=_name("geometry_msgs", "Pose")):
    position: Point
    orientation: Quaternion


@dataclass
class MapMetaData(IdlStruct, typename=_name("nav_msgs", "MapMetaData")):
    map_load_time: Time
    resolution: float32
    width: uint32
    height: uint32
    origin: Pose


@dataclass
class OccupancyGrid(IdlStruct, typename=_name("nav_msgs", "OccupancyGrid")):
    header: Header
    info: MapMetaData
    data: sequence[int8]


TYPES: dict[str, Any] = {
    "sensor_msgs/msg/Image": Image,
    "sensor_msgs/msg/CameraInfo": CameraInfo,
    "tf2_msgs/msg/TFMessage": TFMessage,
    "nav_msgs/msg/OccupancyGrid": OccupancyGrid,
}


def filled(kind: Any, values: dict[str, Any]) -> Any:
    """Return a structure of a dictionary's values."""
    hints = get_type_hints(kind)
    made = {}
    for name, value in values.items():
        if isinstance(value, dict):
            value = filled(hints[name], value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            value = [filled(TransformStamped, one) for one in value]
        made[name] = value
    return kind(**made)
