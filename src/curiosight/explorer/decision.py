"""Why there: what a strategy weighed when it last decided where to go."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable


@dataclass(frozen=True, slots=True)
class Candidate:
    """A region that could have been chosen.

    expected_gain: what is hoped for there, in the strategy's own measure; None = not known yet.
    seconds: of the way there. score: what the choice was by: the highest wins, or a chance.
    """

    region: int
    expected_gain: float | None
    seconds: float
    score: float


@dataclass(frozen=True, slots=True)
class Decision:
    """One decision between regions. chosen: a region; text: the reason in a few words."""

    candidates: tuple[Candidate, ...]
    chosen: int
    text: str

    @classmethod
    def among(
        cls,
        regions: Iterable[int],
        gains: Iterable[float | None],
        seconds: Iterable[float],
        scores: Iterable[float],
        *,
        chosen: int,
        text: str,
    ) -> Self:
        """Return the decision between regions, one of each number; see `Candidate`."""
        candidates = (
            Candidate(int(region), None if gain is None else float(gain), float(way), float(score))
            for region, gain, way, score in zip(regions, gains, seconds, scores, strict=True)
        )
        return cls(tuple(candidates), int(chosen), text)


@runtime_checkable
class Explains(Protocol):
    """A strategy that can say why it went where it is; what others do is their secret."""

    def reasons(self) -> Decision | None:
        """Return the last decision, the same object until the next; None = none yet."""
        ...
