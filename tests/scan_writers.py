"""Write tiny scans of the room as phones and scanners publish them."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.frame import Camera, Pose
from recordings import write_depth, write_image
from room import View, kinect, poses_around, render

COLOUR, LOW = (128, 96), (64, 48)
AXES_ARKIT = np.diag([1.0, -1.0, -1.0, 1.0])
CAMERA = kinect(*COLOUR)


def matrix(camera: Camera, size: int = 3) -> npt.NDArray[np.float64]:
    """Return the matrix of intrinsics, in 3 or 4 rows."""
    numbers = np.eye(size)
    numbers[:2, :3] = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy]]
    return numbers


def low(pose: Pose) -> npt.NDArray[np.float32]:
    """Return depth as the small sensor of a phone sees it."""
    return render(scaled_camera(CAMERA, LOW), pose).depth


def write_confidence(path: Path) -> None:
    """Write 0 in the left quarter, else 2."""
    confidence = np.full(LOW[::-1], 2, np.uint8)
    confidence[:, : LOW[0] // 4] = 0
    write_image(path, confidence)


def write_scanner_app(
    root: Path, numbers: Sequence[int] = (0, 3, 60), *, ending: str = "jpg"
) -> list[View]:
    views = []
    for number, pose in zip(numbers, poses_around(len(numbers)), strict=True):
        view = render(CAMERA, pose)
        write_image(root / f"frame_{number:05d}.{ending}", view.rgb)
        write_depth(root / f"depth_{number:05d}.png", low(pose))
        write_confidence(root / f"conf_{number:05d}.png")
        K = matrix(CAMERA)
        K[[0, 1], [0, 1]] += 0.01 * number
        content = {
            "frame_index": number,
            "time": 100.5 + number,
            "cameraPoseARFrame": (pose @ AXES_ARKIT).ravel().tolist(),
            "intrinsics": K.ravel().tolist(),
        }
        (root / f"frame_{number:05d}.json").write_text(json.dumps(content))
        views.append(view)
    return views


def write_video(path: Path, pictures: Sequence[npt.NDArray[np.uint8]], *, turned: int = 0) -> None:
    """Write an mp4, MPEG-4 part 2; `turned` by 90 degrees as phones say it, in its metadata."""
    path.parent.mkdir(parents=True, exist_ok=True)
    size = pictures[0].shape[1::-1]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 30, size)
    for picture in pictures:
        writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    writer.release()
    if turned:
        content = bytearray(path.read_bytes())
        at = content.index(b"tkhd") + 4 + 40
        one = 1 << 16
        quarter = (0, one, 0, -one, 0, 0, size[1] * one, 0, 1 << 30)
        struct.pack_into(">9i", content, at, *quarter)
        path.write_bytes(content)


def write_stray(root: Path, *, form: str = "new", n_frames: int = 3, turned: int = 0) -> list[View]:
    """Write a recording of Stray Scanner; form: "old", "middle" or "new" tables of poses."""
    poses = poses_around(n_frames)
    views = [render(CAMERA, pose) for pose in poses]
    write_video(root / "rgb.mp4", [view.rgb for view in views], turned=turned)
    names = ["x", "y", "z", "qx", "qy", "qz", "qw"]
    if form != "old":
        names = ["timestamp", "frame", *names]
    if form == "new":
        names += ["fx", "fy", "cx", "cy", "distortion_center_x", "distortion_center_y"]
    lines = [", ".join(names)]
    for index, pose in enumerate(poses):
        numbers = [*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
        cells = [f"{number:.9f}" for number in numbers]
        if form != "old":
            cells = [f"{10 + index / 60:.6f}", f"{index:06d}", *cells]
        if form == "new":
            K = (CAMERA.fx + index / 10, CAMERA.fy + index / 10, CAMERA.cx, CAMERA.cy)
            cells += [*(f"{number:.6f}" for number in K), "", ""]
        lines.append(", ".join(cells))
        depth = root / f"depth/{index:06d}.png"
        write_depth(depth, low(pose))
        if form == "old":
            np.save(depth.with_suffix(".npy"), cv2.imread(str(depth), cv2.IMREAD_UNCHANGED))
            depth.unlink()
        write_confidence(root / f"confidence/{index:06d}.png")
    (root / "odometry.csv").write_text("\n".join(lines))
    np.savetxt(root / "camera_matrix.csv", matrix(CAMERA), delimiter=", ")
    (root / "imu.csv").write_text("timestamp, a_x\n1, 2\n")
    return views


def write_scannet(
    root: Path, *, depth_camera: Camera | None = None, ids: Sequence[str] = ("0", "1", "2")
) -> list[View]:
    """Write SensReader's export; depth of half the size, or of a camera of its own."""
    seen_by = depth_camera or scaled_camera(CAMERA, LOW)
    views = []
    for id, pose in zip(ids, poses_around(len(ids)), strict=True):
        view = render(CAMERA, pose)
        write_image(root / f"color/{id}.jpg", view.rgb)
        write_depth(root / f"depth/{id}.png", render(seen_by, pose).depth)
        (root / "pose").mkdir(exist_ok=True)
        np.savetxt(root / f"pose/{id}.txt", pose)
        views.append(view)
    (root / "intrinsic").mkdir(exist_ok=True)
    for kind, camera in (("color", CAMERA), ("depth", seen_by)):
        np.savetxt(root / f"intrinsic/intrinsic_{kind}.txt", matrix(camera, 4))
        np.savetxt(root / f"intrinsic/extrinsic_{kind}.txt", np.eye(4))
    return views


def write_arkit(root: Path, id: str = "41069021") -> list[View]:
    """Write a video of ARKitScenes at 10 Hz, depth a millisecond later, poses 50 ms apart."""
    camera = scaled_camera(CAMERA, LOW)
    views, lines = [], []
    (root / "lowres_wide_intrinsics").mkdir(parents=True)
    for index, pose in enumerate(poses_around(3)):
        moment = 305.377 + 0.1 * index
        view = render(camera, pose)
        name = f"{id}_{moment:.3f}"
        write_image(root / f"lowres_wide/{name}.png", view.rgb)
        write_depth(root / f"lowres_depth/{id}_{moment + 0.001:.3f}.png", view.depth)
        write_confidence(root / f"confidence/{id}_{moment + 0.001:.3f}.png")
        numbers = (*LOW, camera.fx + 0.01 * index, camera.fy, camera.cx, camera.cy)
        line = " ".join(f"{number:g}" for number in numbers)
        (root / f"lowres_wide_intrinsics/{name}.pincam").write_text(line)
        turned = np.linalg.inv(pose)
        rotation = Rotation.from_matrix(turned[:3, :3]).as_rotvec()
        for offset in (-0.02, 0.02):
            row = (moment + offset, *rotation, *turned[:3, 3])
            lines.append(" ".join(f"{number:.9f}" for number in row))
        views.append(view)
    (root / "lowres_wide.traj").write_text("\n".join(lines))
    return views


def write_replica(root: Path, *, depth_scale: float = 1 / 6553.5) -> list[View]:
    poses = poses_around(3)
    views = [render(CAMERA, pose) for pose in poses]
    for index, view in enumerate(views):
        write_image(root / f"results/frame{index:06d}.jpg", view.rgb)
        write_depth(root / f"results/depth{index:06d}.png", np.minimum(view.depth, 9), depth_scale)
    lines = [" ".join(f"{number:.9e}" for number in pose.ravel()) for pose in poses]
    (root / "traj.txt").write_text("\n".join(lines) + "\n")
    camera = {"w": COLOUR[0], "h": COLOUR[1], "scale": 1 / depth_scale}
    camera |= {key: getattr(CAMERA, key) for key in ("fx", "fy", "cx", "cy")}
    (root.parent / "cam_params.json").write_text(json.dumps({"camera": camera}))
    return views
