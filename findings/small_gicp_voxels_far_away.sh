#!/usr/bin/env bash
# small_gicp 1.0.1, seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: voxelgrid_sampling gives about the same number of points wherever the
#   cloud lies, or raises.
# Happens: beyond about a million voxels from the origin (52 km at 5 cm: map
#   coordinates; or a scene in micrometre voxels) all points are made into ONE. Each
#   adds a warning line on standard error; the return value looks normal.
# Meets: who registers georeferenced clouds, or mixes up the unit of the voxel size.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 small-gicp==1.0.1
"$work/env/bin/python" - 2> "$work/warnings" <<'PY'
from importlib.metadata import version

import numpy as np
import small_gicp

print("small_gicp", version("small_gicp"))
row, column = np.mgrid[:60, :80]
z = 1.5 + 0.2 * np.sin(column / 9.0) + 0.1 * np.cos(row / 7.0)
cloud = np.stack([(column - 40) * z / 70, (row - 30) * z / 70, z], -1).reshape(-1, 3)
left = {}
for offset in (0.0, 50_000.0, 60_000.0):
    left[offset] = small_gicp.voxelgrid_sampling(cloud + offset, 0.05).points().shape[0]
    print(f"{len(cloud)} points moved by {offset:.0f} m: {left[offset]} left at 0.05 m")
assert left[0.0] > 1000 and left[50_000.0] > 1000 and left[60_000.0] == 1
PY
echo "standard error: $(wc -l < "$work/warnings") lines, first: $(head -n 1 "$work/warnings")"
