#!/usr/bin/env bash
# pillow 13.0.0, imageio 2.38.1 against opencv-python-headless 5.0.0.93, seen 2026-11-29.
# Expected: a 16-bit PGM depth image in millimetres reads alike everywhere.
# Happens: when its MAXVAL is not 65535 (10000 for a 10 m range, 4095 for 12 bits)
#   Pillow, and imageio through it, stretch the values to 0..65535 as int32: 1300 mm
#   becomes 8520 or 20805. OpenCV gives 1300 as uint16. With MAXVAL 65535 all agree.
#   (MAXVAL is the value of white, so stretching is a reading of it; but units go.)
# Meets: who reads raw depth in PGM form (Kinect recordings, laser range images).
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 pillow==13.0.0 imageio==2.38.1 \
  opencv-python-headless==5.0.0.93
cd "$work"
env/bin/python - <<'PY'
from importlib.metadata import version

import cv2
import imageio.v3 as iio
import numpy as np
from PIL import Image

for name in ("pillow", "imageio", "opencv-python-headless"):
    print(name, version(name))
depth = np.array([[1300, 2300, 0], [400, 4000, 3300]], np.uint16)
seen = {}
for maxval in (65535, 10000, 4095):
    path = f"depth{maxval}.pgm"
    with open(path, "wb") as file:
        file.write(f"P5\n3 2\n{maxval}\n".encode() + depth.astype(">u2").tobytes())
    readings = {
        "OpenCV": cv2.imread(path, cv2.IMREAD_UNCHANGED),
        "Pillow": np.asarray(Image.open(path)),
        "imageio": np.asarray(iio.imread(path)),
    }
    for name, image in readings.items():
        print(f"MAXVAL {maxval}: {name} {image.dtype} {image.ravel().tolist()}")
        seen[maxval, name] = int(image[0, 0])
assert all(seen[maxval, "OpenCV"] == 1300 for maxval in (65535, 10000, 4095))
for name in ("Pillow", "imageio"):
    assert [seen[m, name] for m in (65535, 10000, 4095)] == [1300, 8520, 20805]
PY
