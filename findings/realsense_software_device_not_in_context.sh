#!/usr/bin/env bash
# pyrealsense2 2.59.1.11053, seen 2026-11-30.
# Expected: `software_device.add_to(context)` puts a device made of software into a context, as its
#   own text says; queries and pipelines on that context then find it.
# Happens: the context lists no device, and a pipeline on it says "No device connected", though the
#   device works: its sensor, opened by itself, delivers the frame that is put in.
# Meets: who tests a program for a RealSense without one by a pipeline, as with a real camera.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pyrealsense2==2.59.1.11053 numpy==2.3.5
cd "$work"
env/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
import pyrealsense2 as rs

print("pyrealsense2", version("pyrealsense2"))
device = rs.software_device()
sensor = device.add_sensor("Depth")
stream = rs.video_stream()
stream.type, stream.index, stream.uid, stream.fmt = rs.stream.depth, 0, 1, rs.format.z16
stream.width, stream.height, stream.fps, stream.bpp = 64, 48, 30, 2
lens = rs.intrinsics()
lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy = 64, 48, 60, 60, 32, 24
lens.model = rs.distortion.none
stream.intrinsics = lens
sensor.add_video_stream(stream)
device.register_info(rs.camera_info.serial_number, "42")

context = rs.context()
device.add_to(context)
n_devices = len(context.query_devices())
print("devices that the context lists:", n_devices)
config = rs.config()
config.enable_device("42")
try:
    rs.pipeline(context).start(config)
    said = "started"
except RuntimeError as error:
    said = str(error)
print("a pipeline on that context:", said)

queue = rs.frame_queue(5)
sensor.open(sensor.profiles[0])
sensor.start(queue)
frame = rs.software_video_frame()
frame.stride, frame.bpp, frame.timestamp, frame.frame_number = 128, 2, 1.0, 1
frame.domain = rs.timestamp_domain.hardware_clock
frame.profile = sensor.profiles[0].as_video_stream_profile()
frame.pixels = np.full((48, 64), 1000, np.uint16)
sensor.on_video_frame(frame)
seen = np.asanyarray(queue.wait_for_frame(5000).as_video_frame().get_data())
print("the sensor by itself:", seen.shape, int(seen[0, 0]))
assert (n_devices, said, seen.shape) == (0, "No device connected", (48, 64))
PY
