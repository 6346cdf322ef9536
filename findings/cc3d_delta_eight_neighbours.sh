#!/usr/bin/env bash
# connected-components-3d 4.1.1, seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: connected_components(depth, delta=20, connectivity=8) parts a box one
#   metre in front of a wall from that wall, as connectivity 4 and 26 do.
# Happens: with connectivity=8 and delta > 0 on a 2-D array box and wall get ONE
#   label; a box at the upper edge gives three labels instead of two. No warning;
#   every dtype; delta=0 and the same image lifted by connectivity=26 are right.
# Meets: who cuts an organised depth image into surfaces by a step in depth.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check connected-components-3d==4.1.1 numpy==2.3.4
"$work/env/bin/python" - <<'PY'
from importlib.metadata import version

import cc3d
import numpy as np

print("connected-components-3d", version("connected-components-3d"))


def surfaces(depth, connectivity, delta=20):
    return int(
        cc3d.connected_components(
            depth, delta=delta, connectivity=connectivity, return_N=True
        )[1]
    )


wall = np.full((120, 160), 2000, np.uint16)
inside, upper_edge = wall.copy(), wall.copy()
inside[40:80, 60:90] = 1000
upper_edge[0:50, 60:90] = 1000
for name, depth in (("box inside", inside), ("box at the upper edge", upper_edge)):
    print(name, {c: surfaces(depth, c) for c in (4, 8, 26)}, "labels; 2 are right")

for kind in (np.uint8, np.uint16, np.int32, np.float32):
    row = np.array([[17, 163, 141]], kind)
    print(kind.__name__, row[0].tolist(), "delta 1:",
          cc3d.connected_components(row, delta=1, connectivity=8)[0].tolist())
    assert cc3d.connected_components(row, delta=1, connectivity=8)[0].tolist() == [1, 1, 2]
    assert cc3d.connected_components(row, delta=1, connectivity=26)[0].tolist() == [1, 2, 3]

assert {c: surfaces(inside, c) for c in (4, 8, 26)} == {4: 2, 8: 1, 26: 2}
assert {c: surfaces(upper_edge, c) for c in (4, 8, 26)} == {4: 2, 8: 3, 26: 2}
assert surfaces(inside, 8, delta=0) == 2
PY
