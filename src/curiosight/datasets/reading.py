"""How a recording is to be read, where its owner knows better than its files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

# Row and sign of each direction in axes right, down, forward.
AXES = {
    "right": (0, 1.0),
    "left": (0, -1.0),
    "down": (1, 1.0),
    "up": (1, -1.0),
    "forward": (2, 1.0),
    "backward": (2, -1.0),
}
# A unit of 10 cm is coarser than any depth camera: such a number is units per metre.
MAX_DEPTH_SCALE = 10.0


@dataclass(frozen=True, slots=True)
class Reading:
    """What overrules the files of a recording; the defaults overrule nothing.

    depth_scale: metres per unit of depth; 0 = as the recording says or its layout has it.
    fix_units: read depth in the unit that its own readings and the poses speak for, where the
        recording's contradicts them.
    invert_poses: poses are world to camera.
    pose_axes: where the axes of the cameras that poses speak of point, such as
        "right,up,backward" for those of OpenGL and ARKit; "" = right,down,forward. Axes that make
        a left hand mirror the world.
    min_confidence: readings less sure than this are none; -1 = 1 of 0 to 2 where the
        recording has confidence, which leaves out what the sensor itself calls low.
    depth_camera: a file with the intrinsics of the depth camera and `T_colour_depth`, for depth
        that is not registered to colour; "" = none.
    topics: of a bag, `color=/a,depth=/b,info=/c,pose=/d`; those not named are guessed.
    """

    depth_scale: float = 0.0
    fix_units: bool = False
    invert_poses: bool = False
    pose_axes: str = ""
    min_confidence: int = -1
    depth_camera: str = ""
    topics: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.depth_scale <= MAX_DEPTH_SCALE:
            raise ValueError(
                "depth_scale: expected metres per unit, 0.001 for millimetres, "
                f"got {self.depth_scale}"
            )
        if self.min_confidence < -1:
            raise ValueError(f"min_confidence: expected 0 or more, got {self.min_confidence}")
        if self.pose_axes:
            axes_of(self.pose_axes)
        if self.fix_units and self.depth_scale:
            raise ValueError("fix_units: expected it or depth_scale, got both")


def axes_of(names: str) -> npt.NDArray[np.float64]:
    """Return (3, 3) from axes right, down, forward to those that are named; `ValueError`.

    >>> axes_of("right,up,backward").diagonal().tolist()
    [1.0, -1.0, -1.0]
    """
    axes = np.zeros((3, 3))
    words = [word.strip() for word in names.split(",")]
    for column, word in enumerate(words[:3]):
        if word in AXES:
            axes[AXES[word][0], column] = AXES[word][1]
    if len(words) != 3 or abs(np.linalg.det(axes)) != 1:
        raise ValueError(f"pose_axes: expected three of {', '.join(AXES)}, got {names!r}")
    return axes.T


AS_RECORDED = Reading()
