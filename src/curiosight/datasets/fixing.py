"""Read depth in the unit that a recording itself speaks for, where its own is contradicted."""

from __future__ import annotations

from curiosight.datasets.depth_bits import ROTATION
from curiosight.datasets.doubts import find_doubts
from curiosight.datasets.reading import Reading
from curiosight.datasets.recording import Recording

# Bits first, then the unit that they hide.
N_FAULTS = 2


def fix_units(recording: Recording, *, depth_alone: bool = False) -> Recording:
    """Return the same recording in the unit that fits, and remark on it; or it as it is.

    What fits is told by `find_doubts`. depth_alone: positions of poses stay as they are.
    """
    for _ in range(N_FAULTS):
        faults = {doubt.code: doubt for doubt in find_doubts(recording)}
        if depth_alone:
            faults.pop("poses-unit", None)
        if "bits" in faults:
            recording = recording.with_bits_rotated_by(ROTATION)
            recording = _remarked(recording, "the bits of depth are rotated back by 3")
        elif "unit" in faults and faults["unit"].factor is not None:
            scale = recording.depth_scale * faults["unit"].factor
            recording = recording.read_as(Reading(depth_scale=scale))
            recording = _remarked(recording, f"depth is read in units of {scale:.6g} m, which fit")
        elif "poses-unit" in faults and faults["poses-unit"].factor is not None:
            factor = faults["poses-unit"].factor
            recording = recording.with_positions_times(factor)
            recording = _remarked(recording, f"positions of poses are taken {factor:.6g} times")
        else:
            break
    return recording


def _remarked(recording: Recording, remark: str) -> Recording:
    recording.remarks_on_files = (*recording.remarks_on_files, remark)
    return recording
