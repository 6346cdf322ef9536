#!/usr/bin/env bash
# gtsam 4.3.0, pycolmap 4.2.1 against scipy 1.17.1, seen 2026-11-29 (Python 3.11).
# Expected: a quaternion rounded to two or three digits in a trajectory file is brought
#   to unit length or refused; a mirrored matrix (determinant -1) is refused.
# Happens: gtsam.Rot3.Quaternion and pycolmap.Rotation3d keep it as it is, so that the
#   "rotation" scales (determinant 0.980) and pose x inverse is not the identity
#   (0.028 and 0.016 off). pycolmap makes a rounded matrix worse (0.998 in, 0.976 out). Mirrored
#   matrices pass: gtsam keeps determinant -1, pycolmap holds a quaternion of length
#   0.715. pycolmap's norm() shows it; nothing warns.
# Meets: who puts poses of text files into a pose graph or a reconstruction.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy==2.3.4 scipy==1.17.1 gtsam==4.3.0 pycolmap==4.2.1
"$work/env/bin/python" - <<'PY'
from importlib.metadata import version

import gtsam
import numpy as np
import pycolmap
from scipy.spatial.transform import Rotation

for name in ("gtsam", "pycolmap", "scipy"):
    print(name, version(name))
turn = Rotation.from_euler("xyz", [10, 20, 120], degrees=True)
position = np.array([1.0, 2.0, 3.0])
x, y, z, w = rounded = np.round(turn.as_quat(), 2)

graph_pose = gtsam.Pose3(gtsam.Rot3.Quaternion(w, x, y, z), position)
graph_determinant = np.linalg.det(graph_pose.rotation().matrix())
graph_off = np.abs(graph_pose.compose(graph_pose.inverse()).matrix() - np.eye(4)).max()
pose = pycolmap.Rigid3d(pycolmap.Rotation3d(rounded), position)
determinant = np.linalg.det(pose.rotation.matrix())
off = np.abs((pose * pose.inverse()).matrix() - np.eye(3, 4)).max()
print(f"length {np.linalg.norm(rounded):.4f}")
print(f"scipy    determinant {np.linalg.det(Rotation.from_quat(rounded).as_matrix()):.4f}")
print(f"gtsam    determinant {graph_determinant:.4f}, pose x inverse off by {graph_off:.4f}")
print(f"pycolmap determinant {determinant:.4f}, pose x inverse off by {off:.4f}")
assert abs(graph_determinant - 0.9801) < 1e-3 and abs(determinant - 0.9801) < 1e-3
assert graph_off > 0.02 and off > 0.01

matrix = np.round(turn.as_matrix(), 2)
out = np.linalg.det(pycolmap.Rotation3d(matrix).matrix())
print(f"rounded matrix: determinant {np.linalg.det(matrix):.4f}, pycolmap gives {out:.4f}")
assert abs(np.linalg.det(matrix) - 0.9979) < 1e-3 and abs(out - 0.9764) < 1e-3

mirrored = np.diag([1.0, 1.0, -1.0]) @ turn.as_matrix()
kept = np.linalg.det(gtsam.Rot3(mirrored).matrix())
length = pycolmap.Rotation3d(mirrored).norm()
print(f"mirrored matrix: gtsam determinant {kept:.4f}, pycolmap quaternion length {length:.4f}")
assert abs(kept + 1) < 1e-6 and abs(length - 0.715) < 1e-3
try:
    Rotation.from_matrix(mirrored)
    raise SystemExit("scipy took the mirrored matrix")
except ValueError as problem:
    print("scipy:", str(problem)[:40])
PY
