"""A home that changes while it is looked at."""

from __future__ import annotations

from dataclasses import dataclass

_FORM = "LOOK:rearrange=SEED, with :lights=SEED and :room=NUMBER where wanted"


@dataclass(frozen=True, slots=True)
class Change:
    """What happens to a home, and when.

    look: how many looks see it as it was. rearrange: seed of the new arrangement of the things.
    lights: seed of other lights. None = as they were. room: of this room alone; None = of all.
    """

    look: int
    rearrange: int | None = None
    lights: int | None = None
    room: int | None = None

    def __str__(self) -> str:
        """Return the text that `read_change` reads."""
        named = ((name, getattr(self, name)) for name in ("rearrange", "lights", "room"))
        return ":".join([str(self.look), *(f"{n}={v}" for n, v in named if v is not None)])


def read_change(text: str) -> Change:
    """Read 200:rearrange=2; raises ValueError for anything else."""
    look, *pairs = text.split(":")
    numbers = {"look": look}
    for pair in pairs:
        name, _, number = pair.partition("=")
        if name not in ("rearrange", "lights", "room") or name in numbers:
            raise ValueError(f"change: expected {_FORM}; got {text!r}")
        numbers[name] = number
    if not all(number.isdecimal() for number in numbers.values()):
        raise ValueError(f"change: expected {_FORM}; got {text!r}")
    change = Change(**{name: int(number) for name, number in numbers.items()})
    if change.rearrange is None and change.lights is None:
        raise ValueError(f"change: expected {_FORM}; got {text!r}")
    return change
