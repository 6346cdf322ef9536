"""What is told of a watch: the keys of /state.json, there from the first answer on."""

from __future__ import annotations

from typing import Any, Protocol

KEYS = (
    "state",
    "map_hz",
    "learn_hz",
    "map_age_s",
    "model_age_s",
    "dropped",
    "regions",
    "goal",
    "why",
    "alarms",
)
PREPARING, RUNNING, PAUSED, FROZEN, ENDED = "preparing", "running", "paused", "frozen", "ended"


class Subject(Protocol):
    """What a page shows. Any thread may call."""

    def state(self) -> dict[str, Any]:
        """Return the values of `KEYS`; None while one is not known."""
        ...

    def live(self) -> dict[str, Any]:
        """Return what else changes: what is under way, the switches, the robot, the curves."""
        ...

    def plan(self) -> dict[str, Any]:
        """Return what there is to see from above."""
        ...

    def picture(self, name: str) -> bytes | None:
        """Return a JPEG of the newest frame by name; None = none yet, or of no such name."""
        ...

    def command(self, name: str, value: Any) -> str:
        """Do what a button asks for and say what was done; raises ValueError for what cannot be."""
        ...


class Preparing:
    """What a page shows until there is something to see. note: what is under way, in words."""

    def __init__(self, note: str = "") -> None:
        self.note = note

    def state(self) -> dict[str, Any]:
        return dict.fromkeys(KEYS) | {"state": PREPARING}

    def live(self) -> dict[str, Any]:
        return {"note": self.note}

    def plan(self) -> dict[str, Any]:
        return {"outlines": [], "regions": []}

    def picture(self, name: str) -> bytes | None:
        return None

    def command(self, name: str, value: Any) -> str:
        raise ValueError(f"{name}: expected a watch that has begun; it is being prepared")
