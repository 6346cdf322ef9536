"""Write the views of a room or home as a recording, in a layout that others read too."""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from curiosight.datasets import KnowsPlaces
from curiosight.datasets.depth_files import MILLIMETRES
from curiosight.datasets.layouts import seven_scenes, tum_rgbd
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Camera, Depth, Frame, Pose
from curiosight.frame.rotations import quaternion_of
from curiosight.rooms.drawn_views import CAMERA, DrawnViews

Layout = Literal["7scenes", "tum", "plain"]
LAYOUTS: tuple[Layout, ...] = ("7scenes", "tum", "plain")

# Any time.
FIRST_STAMP_S = 1_700_000_000


def render_room(views: DrawnViews, layout: Layout, out: OutputFolder) -> Generator[Frame]:
    """Write every view with pose and ground truth; yield each when it is on disk.

    Of a home places.txt tells the room of each frame: truth for scoring.

    Closed early, it leaves a recording of the views so far.
    """
    if layout not in LAYOUTS:
        raise ValueError(f"layout: expected {' or '.join(LAYOUTS)}, got {layout!r}")
    if views.settings.sensor == "lidar" and layout != "plain":
        raise ValueError(
            f"layout: expected plain for sensor=lidar, got {layout!r}, which has no place for "
            "confidence and small depth"
        )
    write = {"7scenes": _as_seven_scenes, "tum": _as_tum, "plain": _as_plain}[layout]
    return write(views, out)


def usual_layout(views: DrawnViews) -> Layout:
    """Return the layout for all that the room's sensor gives."""
    return "plain" if views.settings.sensor == "lidar" else "tum"


def _as_seven_scenes(views: DrawnViews, out: OutputFolder) -> Generator[Frame]:
    """Write colour and depth as that Kinect gives them: from two places, not registered."""
    out.write_text("room.txt", f"{views.path}\n")
    T_colour_depth = np.eye(4)
    T_colour_depth[:3, 3] = seven_scenes.COLOUR_FROM_DEPTH_METRES
    ids: list[str] = []
    try:
        for index, T_room_colour in enumerate(views.poses):
            id = f"frame-{index:06d}"
            T_room_depth = T_room_colour @ T_colour_depth
            rng = views.looks_stream(index)
            colour, depth = (
                views.look_from(pose, id, rng, camera=camera, n_looks=index)
                for pose, camera in (
                    (T_room_colour, seven_scenes.COLOUR_CAMERA),
                    (T_room_depth, seven_scenes.DEPTH_CAMERA),
                )
            )
            assert depth.frame.depth is not None
            out.write_image(f"seq-01/{id}.color.png", colour.frame.rgb)
            in_mm = _in_units(depth.frame.depth, MILLIMETRES.scale)
            out.write_image(f"seq-01/{id}.depth.png", in_mm)
            rows = ("\t".join(f"{value:.9e}" for value in row) for row in T_room_depth)
            out.write_text(f"seq-01/{id}.pose.txt", "\n".join(rows) + "\n")
            out.write_image(f"ground_truth/{id}.png", colour.truth)
            ids.append(id)
            yield colour.frame
    finally:
        _write_places(ids, views, out)


def _as_tum(views: DrawnViews, out: OutputFolder) -> Generator[Frame]:
    """Write registered depth, and at the end the lists of files by stamp and the trajectory."""
    out.write_text("room.txt", f"{views.path}\n")
    out.write_text("camera.json", _camera_file(CAMERA, tum_rgbd.UNIT.scale))
    stamps: list[str] = []
    try:
        for index in range(len(views)):
            stamp, look = _stamp(views, index), views.look(index)
            assert look.frame.depth is not None
            out.write_image(f"rgb/{stamp}.png", look.frame.rgb)
            out.write_image(f"depth/{stamp}.png", _in_units(look.frame.depth, tum_rgbd.UNIT.scale))
            out.write_image(f"ground_truth/{stamp}.png", look.truth)
            stamps.append(stamp)
            yield look.frame
    finally:
        _write_lists(stamps, views.poses, out)
        _write_places(stamps, views, out)


def _as_plain(views: DrawnViews, out: OutputFolder) -> Generator[Frame]:
    """Write depth in millimetres as the sensor gives it, with how sure it is where it tells."""
    out.write_text("room.txt", f"{views.path}\n")
    out.write_text("camera.json", _camera_file(CAMERA, MILLIMETRES.scale))
    stamps: list[str] = []
    try:
        for index in range(len(views)):
            stamp, look = _stamp(views, index), views.look(index)
            out.write_image(f"rgb/{stamp}.png", look.frame.rgb)
            readings = look.readings
            out.write_image(f"depth/{stamp}.png", _in_units(readings.depth, MILLIMETRES.scale))
            if readings.confidence is not None:
                out.write_image(f"confidence/{stamp}.png", readings.confidence)
            out.write_image(f"ground_truth/{stamp}.png", look.truth)
            stamps.append(stamp)
            yield look.frame
    finally:
        out.write_text("poses.txt", _trajectory(stamps, views.poses))
        _write_places(stamps, views, out)


def _write_lists(stamps: Sequence[str], poses: Sequence[Pose], out: OutputFolder) -> None:
    """List the images that were written, and their poses."""
    for kind in ("rgb", "depth"):
        lines = [f"{stamp} {kind}/{stamp}.png" for stamp in stamps]
        out.write_text(f"{kind}.txt", "\n".join(["# timestamp filename", *lines]) + "\n")
    out.write_text("groundtruth.txt", _trajectory(stamps, poses))


def _write_places(ids: Sequence[str], views: DrawnViews, out: OutputFolder) -> None:
    """Write in which room of a home each of the first frames was taken."""
    if isinstance(views, KnowsPlaces):
        lines = [f"{id} {views.place(index)}" for index, id in enumerate(ids)]
        out.write_text("places.txt", "\n".join(lines) + "\n")


def _stamp(views: DrawnViews, index: int) -> str:
    """Return the seconds of a frame as files are named by them."""
    return f"{FIRST_STAMP_S + views.seconds_of(index):.6f}"


def _trajectory(stamps: Sequence[str], poses: Sequence[Pose]) -> str:
    """Return the lines of the first poses, those of the stamps."""
    lines = [_pose_line(*posed) for posed in zip(stamps, poses, strict=False)]
    return "\n".join(["# timestamp tx ty tz qx qy qz qw", *lines]) + "\n"


def _in_units(depth: Depth, scale: float) -> npt.NDArray[np.uint16]:
    """Return 16-bit depth, 0 = no reading or too far to be written."""
    units = np.rint(depth / scale)
    return np.where(units < 65535, units, 0).astype(np.uint16)


def _camera_file(camera: Camera, depth_scale: float) -> str:
    numbers = {key: getattr(camera, key) for key in ("width", "height", "fx", "fy", "cx", "cy")}
    return json.dumps({**numbers, "depth_scale": depth_scale}, indent=1) + "\n"


def _pose_line(stamp: str, pose: Pose) -> str:
    numbers = (*pose[:3, 3], *quaternion_of(pose[:3, :3]))
    return " ".join([stamp, *(f"{number:.9f}" for number in numbers)])
