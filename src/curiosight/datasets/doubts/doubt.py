"""The doubt itself: what contradicts what, and what mends it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something about a recording that its own numbers contradict.

    code: "camera", "unit", "bits", "poses-inverted", "poses-mirrored", "poses-axes",
        "poses-quaternion", "poses-unit" or "registration".
    text: what contradicts what, in numbers. fix: the option that mends it.
    factor: by what depth ("unit") or positions ("poses-unit") must be multiplied.
    """

    code: str
    text: str
    fix: str
    factor: float | None = None
