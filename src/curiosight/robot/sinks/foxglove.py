"""Messages as Foxglove's schemas have them, in JSON, and these schemas.

Names and fields are those of https://docs.foxglove.dev/docs/sdk/schemas; bytes are base64.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

from curiosight.frame import Camera, Pose
from curiosight.frame.rotations import quaternion_of

INFO = 2
Message = dict[str, Any]
Schema = dict[str, Any]
Colour = tuple[float, float, float]
Place = tuple[float, float, float]
NS = 1_000_000_000


def _object(title: str, **properties: Schema) -> Schema:
    return {
        "type": "object",
        "title": title,
        "properties": properties,
        "required": list(properties),
    }


def _list_of(items: Schema) -> Schema:
    return {"type": "array", "items": items}


TEXT, NUMBER, WHOLE = {"type": "string"}, {"type": "number"}, {"type": "integer"}
FLAG = {"type": "boolean"}
BYTES = {"type": "string", "contentEncoding": "base64"}
TIME = _object("time", sec=WHOLE, nsec=WHOLE)
DURATION = _object("duration", sec=WHOLE, nsec=WHOLE)
VECTOR3 = _object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = _object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _object("foxglove.Pose", position=VECTOR3, orientation=QUATERNION)
COLOR = _object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
PAIR = _object("foxglove.KeyValuePair", key=TEXT, value=TEXT)
SPHERE = _object("foxglove.SpherePrimitive", pose=POSE, size=VECTOR3, color=COLOR)
WORDS = _object(
    "foxglove.TextPrimitive",
    pose=POSE,
    billboard=FLAG,
    font_size=NUMBER,
    scale_invariant=FLAG,
    color=COLOR,
    text=TEXT,
)
# Of a scene's primitives two are used; lists of the others are empty.
UNUSED = ("arrows", "cubes", "cylinders", "lines", "triangles", "models")
ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=_list_of(PAIR),
    spheres=_list_of(SPHERE),
    texts=_list_of(WORDS),
    **{name: _list_of({"type": "object"}) for name in UNUSED},
)
DELETION = _object("foxglove.SceneEntityDeletion", timestamp=TIME, type=WHOLE, id=TEXT)
SCHEMAS = {
    schema["title"]: schema
    for schema in (
        _object("foxglove.CompressedImage", timestamp=TIME, frame_id=TEXT, data=BYTES, format=TEXT),
        _object(
            "foxglove.CameraCalibration",
            timestamp=TIME,
            frame_id=TEXT,
            width=WHOLE,
            height=WHOLE,
            distortion_model=TEXT,
            **{name: _list_of(NUMBER) for name in "DKRP"},
        ),
        _object(
            "foxglove.FrameTransform",
            timestamp=TIME,
            parent_frame_id=TEXT,
            child_frame_id=TEXT,
            translation=VECTOR3,
            rotation=QUATERNION,
        ),
        _object("foxglove.SceneUpdate", deletions=_list_of(DELETION), entities=_list_of(ENTITY)),
        _object(
            "foxglove.Log",
            timestamp=TIME,
            level=WHOLE,
            message=TEXT,
            name=TEXT,
            file=TEXT,
            line=WHOLE,
        ),
    )
}


def compressed_image(stamp_ns: int, frame_id: str, content: bytes, kind: str) -> Message:
    """Return a CompressedImage; kind: jpeg or png."""
    data = b64encode(content).decode()
    return {"timestamp": time(stamp_ns), "frame_id": frame_id, "data": data, "format": kind}


def camera_calibration(stamp_ns: int, frame_id: str, camera: Camera) -> Message:
    """Return the CameraCalibration of images without distortion."""
    K = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
    return {
        "timestamp": time(stamp_ns),
        "frame_id": frame_id,
        "width": camera.width,
        "height": camera.height,
        "distortion_model": "plumb_bob",
        "D": [0.0] * 5,
        "K": K,
        "R": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "P": [*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0],
    }


def frame_transform(stamp_ns: int, parent: str, child: str, T_parent_child: Pose) -> Message:
    """Return a FrameTransform."""
    x, y, z, w = quaternion_of(T_parent_child[:3, :3]).tolist()
    return {
        "timestamp": time(stamp_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": _vector(T_parent_child[:3, 3].tolist()),
        "rotation": {"x": x, "y": y, "z": z, "w": w},
    }


def log(stamp_ns: int, text: str, name: str) -> Message:
    """Return a Log of level INFO; name: who says it."""
    told = {"level": INFO, "message": text, "name": name, "file": "", "line": 0}
    return {"timestamp": time(stamp_ns), **told}


def ball(
    stamp_ns: int, frame_id: str, id: str, place: Place, *, metres: float, colour: Colour, text: str
) -> Message:
    """Return a SceneEntity: a sphere with a text above it. metres: how wide; colour: 0 to 1."""
    x, y, z = place
    above = {"position": _vector((x, y, z + metres)), "orientation": _UPRIGHT}
    rgba = dict(zip("rgba", (*colour, 1.0), strict=True))
    sphere = {
        "pose": {"position": _vector(place), "orientation": _UPRIGHT},
        "size": _vector((metres, metres, metres)),
        "color": rgba,
    }
    words = {"pose": above, "billboard": True, "font_size": 14.0, "scale_invariant": True}
    return {
        "timestamp": time(stamp_ns),
        "frame_id": frame_id,
        "id": id,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        "spheres": [sphere],
        "texts": [{**words, "color": rgba, "text": text}],
        **{name: [] for name in UNUSED},
    }


def scene_update(entities: Sequence[Message]) -> Message:
    """Return a SceneUpdate: each entity in the place of the one of its id."""
    return {"deletions": [], "entities": list(entities)}


def time(stamp_ns: int) -> Message:
    """Return a time of the wall."""
    return {"sec": stamp_ns // NS, "nsec": stamp_ns % NS}


_UPRIGHT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def _vector(xyz: Sequence[float]) -> Message:
    return dict(zip("xyz", map(float, xyz), strict=True))
