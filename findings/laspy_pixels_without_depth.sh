#!/usr/bin/env bash
# laspy 2.7.0, seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: a cloud of a depth camera with NaN for pixels without depth is refused or
#   the NaN kept; metres keep their millimetres.
# Happens: NaN becomes the least 32-bit number: a point at -2147483.648 m with a scale
#   of 0.001, which is also the header's minimum; only NumPy's RuntimeWarning tells.
#   Infinity in the same place raises OverflowError. The default scale is 0.01, so
#   1.234 m is stored as 1.23 and 4 mm as 0, without any word.
# Meets: who exports depth frames as LAS.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 laspy==2.7.0
cd "$work"
env/bin/python - <<'PY'
from importlib.metadata import version

import laspy
import numpy as np

print("laspy", version("laspy"))


def round_trip(x, scale=None):
    header = laspy.LasHeader(point_format=3, version="1.2")
    if scale is not None:
        header.scales = [scale] * 3
    cloud = laspy.LasData(header)
    cloud.x = np.array(x)
    cloud.y = cloud.z = np.zeros(len(x))
    cloud.write("cloud.las")
    return laspy.read("cloud.las")


with_hole = round_trip([1.0, np.nan, 2.0], 0.001)
print("1, NaN, 2 ->", np.array(with_hole.x).tolist(), "header minimum", with_hole.header.mins[0])
assert abs(with_hole.x[1] + 2147483.648) < 1e-3
assert with_hole.header.mins[0] < -2e6
try:
    round_trip([1.0, np.inf, 2.0], 0.001)
    raise SystemExit("infinity was taken")
except OverflowError as problem:
    print("1, inf, 2 ->", type(problem).__name__)
coarse = np.array(round_trip([1.234, 0.004]).x).tolist()
print("default scale: 1.234, 0.004 ->", coarse)
assert np.allclose(coarse, [1.23, 0.0])
PY
