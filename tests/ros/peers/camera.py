"""A camera: colour, depth, CameraInfo, tf, and a map of the floor, by one of three DDS stacks.

    camera.py SCENE --domain N [--stack NAME] [--rate HZ] [--faults NAME,…] [--seconds S]

It shows the frames of the scene forwards and backwards. Faults: no-depth, no-color, no-info, no-tf,
no-static, apart (depth is stamped 0.42 s early), volatile-static, own-camera (depth is of a
camera 5 cm beside, with a CameraInfo of its own), still (one frame only).
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scene import R_BODY_CAMERA, quaternion
from stacks import Advertised, open_stack

T_BASE_CAMERA = np.eye(4)
T_BASE_CAMERA[:3, :3] = R_BODY_CAMERA


def header(stamp_ns: int, frame: str) -> dict:
    return {
        "stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9},
        "frame_id": frame,
    }


def image(pixels: np.ndarray, encoding: str, stamp_ns: int, frame: str) -> dict:
    return {
        "header": header(stamp_ns, frame),
        "height": pixels.shape[0],
        "width": pixels.shape[1],
        "encoding": encoding,
        "is_bigendian": 0,
        "step": pixels.strides[0],
        "data": pixels.tobytes(),
    }


def info(K: np.ndarray, stamp_ns: int, frame: str) -> dict:
    P = np.zeros((3, 4))
    P[:, :3] = K.reshape(3, 3)
    return {
        "header": header(stamp_ns, frame),
        "height": 480,
        "width": 640,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": K.tolist(),
        "r": np.eye(3).ravel().tolist(),
        "p": P.ravel().tolist(),
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }


def transform(T: np.ndarray, parent: str, child: str, stamp_ns: int) -> dict:
    x, y, z = T[:3, 3].tolist()
    qx, qy, qz, qw = quaternion(T[:3, :3])
    return {
        "header": header(stamp_ns, parent),
        "child_frame_id": child,
        "transform": {
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
        },
    }


def floor(stamp_ns: int) -> dict:
    """Return a free floor of 6 x 6 m behind walls."""
    cells = np.zeros((120, 120), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    pose = {
        "position": {"x": 0.0, "y": 0.0, "z": 0.0},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    }
    stamp = header(stamp_ns, "map")["stamp"]
    about = {"map_load_time": stamp, "resolution": 0.05, "width": 120, "height": 120}
    return {
        "header": header(stamp_ns, "map"),
        "info": about | {"origin": pose},
        "data": cells.ravel().tolist(),
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("--stack", default="rosless")
    parser.add_argument("--rate", type=float, default=30.0)
    parser.add_argument("--faults", default="")
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--reliability", default="reliable")
    parser.add_argument("--domain", type=int, required=True)
    given = parser.parse_args()
    faults = set(given.faults.split(",")) - {""}
    scene = np.load(given.scene)
    rgb, depth, poses, K = (scene[name] for name in ("rgb", "depth", "poses", "K"))
    stack = open_stack(given.stack, given.domain)

    def advertise(topic: str, kind: str, quality: str, durability: str, depth: int) -> Advertised:
        return stack.advertise(topic, kind, reliability=quality, durability=durability, depth=depth)

    def images(topic: str, kind: str) -> Advertised:
        return advertise(topic, f"sensor_msgs/msg/{kind}", given.reliability, "volatile", 2)

    tf = "tf2_msgs/msg/TFMessage"
    colour = depths = infos = depth_infos = moving = fixed = None
    if "no-color" not in faults:
        colour = images("/camera/camera/color/image_raw", "Image")
    if "no-info" not in faults:
        infos = images("/camera/camera/color/camera_info", "CameraInfo")
    place = "/camera/camera/aligned_depth_to_color"
    if "no-depth" not in faults:
        depths = images(f"{place}/image_raw", "Image")
        depth_infos = images(f"{place}/camera_info", "CameraInfo")
    if "no-tf" not in faults:
        moving = advertise("/tf", tf, "reliable", "volatile", 100)
    if "no-static" not in faults:
        durability = "volatile" if "volatile-static" in faults else "transient_local"
        fixed = advertise("/tf_static", tf, "reliable", durability, 1)
    grid = advertise("/map", "nav_msgs/msg/OccupancyGrid", "reliable", "transient_local", 1)
    now = time.time_ns()
    grid.send(floor(now))
    links = [transform(T_BASE_CAMERA, "base_link", "camera_color_optical_frame", now)]
    beside = np.eye(4)
    beside[0, 3] = 0.05
    links.append(transform(beside, "camera_color_optical_frame", "camera_depth_frame", now))
    if fixed is not None:
        fixed.send({"transforms": links})
    order = [*range(len(rgb)), *range(len(rgb) - 2, 0, -1)]
    frame, of_depth = "camera_color_optical_frame", "camera_color_optical_frame"
    if "own-camera" in faults:
        of_depth = "camera_depth_frame"
    began = time.monotonic()
    n = 0
    while time.monotonic() - began < given.seconds:
        number = 0 if "still" in faults else order[n % len(order)]
        now = time.time_ns()
        if moving is not None:
            T_map_base = poses[number] @ np.linalg.inv(T_BASE_CAMERA)
            moving.send({"transforms": [transform(T_map_base, "map", "base_link", now)]})
        if infos is not None:
            infos.send(info(K, now, frame))
        if depths is not None:
            stamp = now - (420_000_000 if "apart" in faults else 0)
            depths.send(image(depth[number], "16UC1", stamp, of_depth))
            depth_infos.send(info(K, stamp, of_depth))
        if colour is not None:
            colour.send(image(rgb[number], "rgb8", time.time_ns() if not depths else now, frame))
        n += 1
        time.sleep(max(0.0, began + n / given.rate - time.monotonic()))


if __name__ == "__main__":
    main()
