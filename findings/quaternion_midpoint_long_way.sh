#!/usr/bin/env bash
# pytransform3d 3.17.0, quaternionic 1.0.18, numpy-quaternion 2024.0.13 against
# scipy 1.17.1, seen 2026-11-29 (Python 3.11, Linux x86-64).
# Expected: half way between headings of 10 and 30 degrees is 20, whatever the sign
#   of the quaternions (q and -q are one rotation; trackers do flip the sign).
# Happens: with the second quaternion negated pytransform3d's quaternion_slerp and
#   quaternionic's slerp give -160 by default, and so does numpy-quaternion's
#   mean_rotor_in_chordal_metric; scipy, pytransform3d's own pq_slerp, and
#   numpy-quaternion's slerp_evaluate give 20.
# Meets: who interpolates or averages camera poses between depth frames.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 scipy==1.17.1 pytransform3d==3.17.0 \
  quaternionic==1.0.18 numpy-quaternion==2024.0.13
"$work/env/bin/python" - <<'PY'
from importlib.metadata import version

import numpy as np
import pytransform3d.rotations as rotations
import pytransform3d.transformations as transformations
import quaternion
import quaternionic
from scipy.spatial.transform import Rotation, Slerp

for name in ("pytransform3d", "quaternionic", "numpy-quaternion", "scipy"):
    print(name, version(name))


def heading(wxyz):
    w, x, y, z = np.asarray(wxyz, float).tolist()
    return round(float(Rotation.from_quat([x, y, z, w]).as_euler("ZYX", degrees=True)[0]), 3)


first = Rotation.from_euler("z", 10, degrees=True)
second = Rotation.from_euler("z", 30, degrees=True)
for sign in (1, -1):
    a = np.roll(first.as_quat(), 1)
    b = sign * np.roll(second.as_quat(), 1)
    both = quaternion.from_float_array(np.array([a, b]))
    pair = Rotation.from_quat([np.roll(a, -1), np.roll(b, -1)])
    midpoints = {
        "scipy Slerp": heading(np.roll(Slerp([0, 1], pair)(0.5).as_quat(), 1)),
        "scipy mean": heading(np.roll(pair.mean().as_quat(), 1)),
        "pytransform3d pq_slerp": heading(
            transformations.pq_slerp(np.r_[0, 0, 0, a], np.r_[0, 0, 0, b], 0.5)[3:]
        ),
        "numpy-quaternion slerp_evaluate": heading(
            quaternion.as_float_array(quaternion.slerp_evaluate(both[0], both[1], 0.5))
        ),
        "pytransform3d quaternion_slerp": heading(rotations.quaternion_slerp(a, b, 0.5)),
        "quaternionic slerp": heading(
            quaternionic.interpolation.slerp(
                quaternionic.array(a), quaternionic.array(b), 0.5
            )
        ),
        "numpy-quaternion mean_rotor": heading(
            quaternion.as_float_array(quaternion.mean_rotor_in_chordal_metric(both))
        ),
    }
    print("second quaternion times", sign)
    for name, value in midpoints.items():
        print(f"  {name}: {value}")
    wanted = [20.0] * 7 if sign == 1 else [20.0] * 4 + [-160.0] * 3
    assert list(midpoints.values()) == wanted
PY
