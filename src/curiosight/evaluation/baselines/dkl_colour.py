"""Opponent colours of the eye: how far an image's light is from grey, after a monitor's guns.

Derrington, Krauskopf and Lennie, "Chromatic mechanisms in lateral geniculate nucleus of
macaque", 1984: along luminance, red-green (L - M cones), and blue-yellow (S cones).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

# Light per grey level of a monitor's red, green and blue gun: polynomials in level / 255, highest
# power first. They stand in for the measured table of the GBVS toolbox, which is not free.
GUN_CURVES = (
    (10.476288, -20.300133, 7.875999, 4.217949, -1.457673, 0.176012, 0.021296),
    (10.725395, -20.483774, 7.542344, 4.393187, -1.323025, 0.154298, 0.004611),
    (0.866305, 7.639748, -21.690671, 17.745786, -3.937766, 0.353185, 0.035692),
)
LIGHT_OF_LEVEL = np.array([np.polyval(curve, np.arange(256) / 255) for curve in GUN_CURVES])

# Responses of the long, middle and short cones (rows) to the red, green and blue gun.
CONES_FROM_GUNS = np.array(
    [
        [18.32535, 44.60077, 7.46216],
        [4.09544, 28.20135, 6.66066],
        [0.02114, 0.10325, 1.05258],
    ]
)
GREY_CONES = np.array([34.9185389578, 19.3147966765, 0.5856108185])
AXIS_SCALES = np.array([0.5774, 2.7525, 0.4526])


def dkl_colour(red: Array, green: Array, blue: Array) -> Array:
    """Return the (3, h, w) luminance, red-green and blue-yellow of planes in [0, 1]."""
    light = np.stack(
        [
            light_of_level[np.clip(np.ceil(plane * 255).astype(np.int64) - 1, 0, 255)]
            for light_of_level, plane in zip(LIGHT_OF_LEVEL, (red, green, blue), strict=True)
        ],
        axis=-1,
    )
    opponents = (light @ CONES_FROM_GUNS.T - GREY_CONES) @ _opponents_from_cones().T
    return np.moveaxis(opponents, -1, 0)


def _opponents_from_cones() -> Array:
    """Return the (3, 3) matrix from cone responses, less those of grey, to the three axes."""
    long, middle, short = GREY_CONES
    length = np.hypot(long, middle)
    axes = np.array(
        [
            [np.sqrt(3), np.sqrt(3), 0],
            [length / long, -length / middle, 0],
            [-1, -1, (long + middle) / short],
        ]
    )
    matrix: Array = AXIS_SCALES[:, None] * axes / (long + middle)
    return matrix
