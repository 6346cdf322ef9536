#!/usr/bin/env bash
# opencv-python-headless 5.0.0.93 and imageio-ffmpeg 0.8.1 against av 18.1.0, seen
# 2026-11-29. A video of 90 numbered frames, 30 per second and then 10, as phones
# record in low light (variable frame rate).
# Expected: frame i by number is frame i; as many frames come out as there are.
# Happens: OpenCV read in order gives 90 right frames and says 90, but after
#   set(CAP_PROP_POS_FRAMES, i) 69 of 90 are others than frame i; read() is True and
#   for 61 of these the position before reading is i, as if all were well.
#   imageio-ffmpeg hands out 178 frames, doubles among them, while its own
#   count_frames_and_secs says 90. PyAV's frames in order are right.
# Meets: who pairs colour frames of a phone's video with numbered depth images.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 av==18.1.0 imageio-ffmpeg==0.8.1 \
  opencv-python-headless==5.0.0.93
cd "$work"
# PyAV and OpenCV each bring an FFmpeg; a process for each.
env/bin/python - <<'PY'
from fractions import Fraction
from importlib.metadata import version

import av
import numpy as np

print("av", version("av"))


def number(rgb):
    row = rgb[32].astype(int).mean(-1)
    return sum(1 << bit for bit in range(8) if row[bit * 12 + 6] > 125)


with av.open("phone.mp4", "w") as container:
    stream = container.add_stream("libx264", rate=30)
    stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
    stream.codec_context.time_base = stream.time_base = Fraction(1, 90000)
    stream.gop_size, stream.options = 12, {"bf": "0"}
    for index in range(90):
        image = np.full((64, 96, 3), 30, np.uint8)
        for bit in range(8):
            if index >> bit & 1:
                image[:, bit * 12 : bit * 12 + 12] = 220
        frame = av.VideoFrame.from_ndarray(image, format="rgb24")
        frame.pts = 3000 * (index if index < 45 else 45 + 3 * (index - 45))
        frame.time_base = Fraction(1, 90000)
        container.mux(stream.encode(frame))
    container.mux(stream.encode())
with av.open("phone.mp4") as container:
    decoded = [number(f.to_ndarray(format="rgb24")) for f in container.decode(video=0)]
print("PyAV in order:", len(decoded), "frames, right:", decoded == list(range(90)))
assert decoded == list(range(90))
PY
env/bin/python - <<'PY'
from importlib.metadata import version

import cv2
import imageio_ffmpeg
import numpy as np


def number(image):
    row = image[32].astype(int).mean(-1)
    return sum(1 << bit for bit in range(8) if row[bit * 12 + 6] > 125)


print("opencv-python-headless", version("opencv-python-headless"))
print("imageio-ffmpeg", version("imageio-ffmpeg"))
capture = cv2.VideoCapture("phone.mp4")
counted = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
in_order = []
while True:
    good, image = capture.read()
    if not good:
        break
    in_order.append(number(image))
sought, claimed = [], []
for index in range(90):
    capture.set(cv2.CAP_PROP_POS_FRAMES, index)
    claimed.append(int(capture.get(cv2.CAP_PROP_POS_FRAMES)))
    good, image = capture.read()
    sought.append(number(image) if good else None)
wrong = [(index, got) for index, got in enumerate(sought) if index != got]
print("OpenCV counts", counted, "in order right:", in_order == list(range(90)))
print("OpenCV by number:", len(wrong), "wrong, first (asked, got):", wrong[:4])
pretended = [index for index, _ in wrong if claimed[index] == index]
print("wrong though the position is the one asked for:", len(pretended))

reader = imageio_ffmpeg.read_frames("phone.mp4")
next(reader)
frames = [number(np.frombuffer(data, np.uint8).reshape(64, 96, 3)) for data in reader]
said = imageio_ffmpeg.count_frames_and_secs("phone.mp4")
print("imageio-ffmpeg:", len(frames), "frames,", len(set(frames)), "distinct, counted:", said)
assert counted == 90 and in_order == list(range(90))
assert len(wrong) > 45 and len(pretended) > 30
assert len(frames) > 150 and len(set(frames)) == 90 and said[0] == 90
PY
