#!/usr/bin/env bash
# pointcloudkit 0.1.0, seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: PointCloud.read(path, drop_nan=False) keeps all points of an organised
#   PCD cloud ("keep raw values as-is", says its docstring), and rgb is read.
# Happens: the PCD reader drops every NaN point first, so the flag does nothing and
#   point i is no longer pixel i. And a packed colour with alpha 255 kept in a float
#   (TYPE F, as PCL writes rgb) is a NaN bit pattern once red >= 128: such points
#   come back black (0, 0, 0). The same bits as TYPE U are right. No warning.
# Meets: who reads clouds of depth cameras saved as PCD and needs the pixel grid.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pointcloudkit==0.1.0 numpy==2.3.4
cd "$work"
env/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from pointcloudkit import PointCloud

print("pointcloudkit", version("pointcloudkit"))
width, height = 4, 3
points = np.zeros(width * height, [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<u4")])
points["x"] = np.tile(np.arange(width), height)
points["y"] = np.repeat(np.arange(height), width)
points["z"] = 1.5
for axis in "xyz":
    points[axis][[0, 5]] = np.nan
red, green, blue = np.uint32(200), np.uint32(60), np.uint32(30)
points["rgb"] = np.uint32(255) << 24 | red << 16 | green << 8 | blue
points["rgb"][1] = np.uint32(255) << 24 | np.uint32(100) << 16 | green << 8 | blue


def write(path, colour_type):
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
        f"SIZE 4 4 4 4\nTYPE F F F {colour_type}\nCOUNT 1 1 1 1\nWIDTH {width}\n"
        f"HEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {width * height}\nDATA binary\n"
    )
    with open(path, "wb") as file:
        file.write(header.encode() + points.tobytes())


write("float.pcd", "F")
write("whole.pcd", "U")
kept = PointCloud.read("float.pcd", drop_nan=False)
whole = PointCloud.read("whole.pcd", drop_nan=False)
print("written", width * height, "points, read with drop_nan=False:", len(kept))
print("colours of pixels 1 and 2, TYPE F:", kept.rgb[:2].tolist(), "TYPE U:", whole.rgb[:2].tolist())
assert len(kept) == len(whole) == 10
assert whole.rgb[:2].tolist() == [[100, 60, 30], [200, 60, 30]]
assert kept.rgb[:2].tolist() == [[100, 60, 30], [0, 0, 0]]
PY
