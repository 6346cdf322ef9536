#!/usr/bin/env bash
# imageio 2.38.1 with pillow 13.0.0, without and with opencv-python-headless 5.0.0.93,
# seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: imageio.v3.imread of a PFM file (float32 disparity or depth) gives float32.
# Happens: that depends on what else is installed. With OpenCV beside it imageio takes
#   that plugin for .pfm, and its default flags turn floats into uint8: 1.3 m is 1,
#   0.25 m and NaN are 0. cv2.imread with IMREAD_UNCHANGED is right, and so is
#   imageio with plugin="pillow". No warning.
# Meets: who reads stereo benchmarks' disparities, or adds OpenCV to an environment.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 pillow==13.0.0 imageio==2.38.1
cd "$work"
cat > look.py <<'PY'
import sys
from importlib.metadata import version

import imageio.v3 as iio
import numpy as np

depth = np.array([[0.25, 1.3, 2.4], [3.7, 4.2, np.nan]], "<f4")
with open("depth.pfm", "wb") as file:
    file.write(b"Pf\n3 2\n-1.0\n" + depth[::-1].tobytes())
print("imageio", version("imageio"), "pillow", version("pillow"))
try:
    image = iio.imread("depth.pfm")
    print("default:", image.dtype, image.tolist())
except OSError as problem:
    image = None
    print("default:", type(problem).__name__)
by_pillow = iio.imread("depth.pfm", plugin="pillow")
print("pillow: ", by_pillow.dtype, by_pillow.tolist())
assert by_pillow.dtype == np.float32 and np.array_equal(by_pillow, depth, equal_nan=True)
if sys.argv[1] == "with":
    import cv2

    print("opencv-python-headless", version("opencv-python-headless"))
    unchanged = cv2.imread("depth.pfm", cv2.IMREAD_UNCHANGED)
    assert np.array_equal(unchanged, depth, equal_nan=True)
    assert image is not None and image.dtype == np.uint8
    assert image[0].tolist() == [0, 1, 2]
else:
    assert image is not None and image.dtype == np.float32
PY
env/bin/python look.py without
env/bin/pip install --quiet --disable-pip-version-check opencv-python-headless==5.0.0.93
env/bin/python look.py with
