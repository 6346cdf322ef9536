"""The truth of every pixel of a drawn room, by the paper's definition of an object (sec. II-A).

What stands free and is no larger than 150 cm is an object, furniture that carries nothing too. What
carries things is a support. The paper's robot on the floor takes it for one object together with
all that stands on it, or for none where the two are larger: `scene` says who looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame import Label
from curiosight.rooms.arrangement import Thing
from curiosight.rooms.furniture import Placed
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.scene import Part, Role
from curiosight.rooms.settings import SceneName

Ids = npt.NDArray[np.integer[Any]]
Grey = npt.NDArray[np.uint8]
# Metres across the box around an object. The paper has 10 to 150 cm; a box of 10 cm at an angle
# is 8 cm wide.
MIN_SIZE, MAX_SIZE = 0.08, 1.5


def role_of_furniture(placed: Placed, things: Sequence[Thing], scene: SceneName) -> Role:
    """Return what a piece of furniture is with the room's things where they stand.

    scene: "floor" = who looks takes what carries something for one with all that is on it.
    """
    carries = placed.furniture.contents is not None or any(
        placed.carries(thing.T_room_thing[:3, 3]) for thing in things if not thing.is_on_floor
    )
    if not carries and across(placed.furniture.mesh) <= MAX_SIZE:
        return Role.OBJECT
    return Role.UNDECIDED if scene == "floor" else Role.SUPPORT


def role_of_thing(thing: Thing, scene: SceneName) -> Role:
    """Return what a thing is; scene: see `role_of_furniture`."""
    return Role.OBJECT if thing.is_on_floor or scene != "floor" else Role.UNDECIDED


def across(mesh: Mesh) -> float:
    """Return the metres across the smallest upright box around a mesh, however it is turned."""
    _, size, _ = cv2.minAreaRect(np.ascontiguousarray(mesh.vertices[:, :2], np.float32))
    return float(np.hypot(np.hypot(*size), np.ptp(mesh.vertices[:, 2])))


def draw_truth(
    ids: Ids,
    parts: Sequence[Part],
    *,
    outline_px: int = 2,
    min_size: float = MIN_SIZE,
    max_size: float = MAX_SIZE,
) -> Grey:
    """Return (H, W) uint8: 255 salient, 0 not salient, 125 to be ignored.

    ids: (H, W) the number of the part in each pixel, its place in `parts` + 1; 0 = nothing.
    outline_px: pixels this close to a boundary between salient and not are ignored, as they
        are in annotations made by hand.
    min_size: metres across the box around an object along the room's axes; max_size: across the
        smallest upright box, see `across`.
    """
    if not 0 <= ids.min() <= ids.max() <= len(parts):
        found = f"{ids.min()} to {ids.max()}"
        raise ValueError(f"ids: expected 0 to {len(parts)}, the number of parts, got {found}")
    return with_outlines(_greys(ids, parts, min_size, max_size)[ids], outline_px)


def with_outlines(truth: Grey, outline_px: int = 2) -> Grey:
    """Return the truth with pixels on both sides of a boundary ignored; see `draw_truth`."""
    truth = truth.copy()
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * outline_px + 1, 2 * outline_px + 1))
    near_salient = cv2.dilate((truth == Label.SALIENT).astype(np.uint8), disc)
    near_not_salient = cv2.dilate((truth == Label.NOT_SALIENT).astype(np.uint8), disc)
    truth[(near_salient & near_not_salient) > 0] = Label.UNKNOWN
    return truth


def greys_of(
    parts: Sequence[Part], *, min_size: float = MIN_SIZE, max_size: float = MAX_SIZE
) -> Grey:
    """Return the (number of parts,) greys of parts in the truth, see `draw_truth`."""
    return np.array([_grey(part, min_size, max_size) for part in parts], np.uint8)


def _greys(ids: Ids, parts: Sequence[Part], min_size: float, max_size: float) -> Grey:
    """(number of parts + 1,) the grey of each part in view, by its number."""
    greys = np.full(len(parts) + 1, Label.UNKNOWN, np.uint8)
    for number in np.flatnonzero(np.bincount(ids.ravel())).tolist():
        if number > 0:
            greys[number] = _grey(parts[number - 1], min_size, max_size)
    return greys


def _grey(part: Part, min_size: float, max_size: float) -> Label:
    if part.role in (Role.SUPPORT, Role.STRUCTURE):
        return Label.NOT_SALIENT
    if part.role is not Role.OBJECT or part.mesh.diagonal < min_size:
        return Label.UNKNOWN
    return Label.SALIENT if across(part.mesh) <= max_size else Label.UNKNOWN


def draw_instances(
    ids: Ids, parts: Sequence[Part], *, min_size: float = MIN_SIZE, max_size: float = MAX_SIZE
) -> npt.NDArray[np.int32]:
    """Return (H, W) int32: the number of each salient part, 0 = not salient, -1 = to be ignored.

    As `draw_truth`, but up to the outlines.
    """
    return instances_of(ids, _greys(ids, parts, min_size, max_size)[ids])


def instances_of(ids: Ids, truth: Grey) -> npt.NDArray[np.int32]:
    """Return the numbers of the parts where the truth up to the outlines is salient."""
    instances = np.where(truth == Label.SALIENT, ids, 0).astype(np.int32)
    instances[truth == Label.UNKNOWN] = -1
    return instances
