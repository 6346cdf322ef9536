"""Rotations as matrices, as unit quaternions x, y, z, w, and as vectors: poses are written so."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def matrix_of(quaternions: npt.ArrayLike) -> Floats:
    """Return the (..., 3, 3) matrices of (..., 4) quaternions x, y, z, w of any length but 0.

    Raises `ValueError` where one is of length 0.
    """
    x, y, z, w = np.moveaxis(np.asarray(quaternions, np.float64), -1, 0)
    lengths = np.sqrt(x * x + y * y + z * z + w * w)
    if (lengths == 0).any():
        raise ValueError("quaternions: expected lengths above 0, got 0")
    x, y, z, w = (part / lengths for part in (x, y, z, w))
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    rows = (
        (xx - yy - zz + ww, 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), -xx + yy - zz + ww, 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), -xx - yy + zz + ww),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_of(matrices: npt.ArrayLike) -> Floats:
    """Return the unit quaternions (..., 4) x, y, z, w of (..., 3, 3) rotation matrices.

    One that is a rotation but for rounding is taken for the nearest that is one. Of the two of
    opposite sign it is that whose largest number is positive.
    """
    given = np.asarray(matrices, np.float64)
    flat = given.reshape(-1, 3, 3)
    left, _, right = np.linalg.svd(flat)
    near = left @ right
    found = np.array([_quaternion(matrix) for matrix in near]).reshape(-1, 4)
    return found.reshape(*given.shape[:-2], 4)


def _quaternion(matrix: Floats) -> Floats:
    """Return the quaternion of one rotation, by whichever of its numbers is largest."""
    diagonal = matrix.diagonal()
    trace = float(diagonal.sum())
    largest = int(np.argmax([*diagonal, trace]))
    quaternion = np.empty(4)
    if largest == 3:
        quaternion[0] = matrix[2, 1] - matrix[1, 2]
        quaternion[1] = matrix[0, 2] - matrix[2, 0]
        quaternion[2] = matrix[1, 0] - matrix[0, 1]
        quaternion[3] = 1 + trace
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        quaternion[i] = 1 - trace + 2 * matrix[i, i]
        quaternion[j] = matrix[j, i] + matrix[i, j]
        quaternion[k] = matrix[k, i] + matrix[i, k]
        quaternion[3] = matrix[k, j] - matrix[j, k]
    return quaternion / np.linalg.norm(quaternion)


def quaternion_about(vectors: npt.ArrayLike) -> Floats:
    """Return the unit quaternions (..., 4) of rotations about (..., 3) vectors, by their length.

    The length is the angle in radians.
    """
    given = np.asarray(vectors, np.float64)
    angles = np.linalg.norm(given, axis=-1, keepdims=True)
    # sin(a / 2) / a, whose limit at 0 is a half.
    share = np.sinc(angles / (2 * np.pi)) / 2
    return np.concatenate([given * share, np.cos(angles / 2)], axis=-1)


def between(first: npt.ArrayLike, last: npt.ArrayLike, share: float) -> Floats:
    """Return the (4,) unit quaternion a share of the shortest way from one to another (slerp)."""
    one, other = (np.asarray(q, np.float64) / np.linalg.norm(q) for q in (first, last))
    cosine = float(one @ other)
    if cosine < 0:  # the same rotation on the other side
        other, cosine = -other, -cosine
    sine = float(np.linalg.norm(other - cosine * one))
    angle = np.arctan2(sine, cosine)
    if angle < 1e-8:
        mixed: Floats = (1 - share) * one + share * other
    else:
        mixed = (np.sin((1 - share) * angle) * one + np.sin(share * angle) * other) / sine
    return np.asarray(mixed / np.linalg.norm(mixed))
