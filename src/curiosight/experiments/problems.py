"""Bad frames are data: count them, so that a run can say what it could not use."""

from __future__ import annotations

from collections.abc import Iterator

from curiosight.frame import Frame

BAD_FRAME = "bad frame"


class Problems:
    """Collect the frames that taught nothing, by what was wrong; each counts once."""

    def __init__(self) -> None:
        self._frames: dict[str, dict[str, str]] = {}

    def add(self, frame: Frame, problem: str | None = None) -> None:
        """Take note of a frame where anything is wrong: with its files, or as `problem` says."""
        if frame.problem is not None:
            self._frames.setdefault(BAD_FRAME, {})[frame.id] = f" ({frame.problem})"
        elif problem is not None:
            self._frames.setdefault(problem, {})[frame.id] = ""

    def counts(self) -> dict[str, int]:
        """Return the number of frames of each problem."""
        return {problem: len(frames) for problem, frames in sorted(self._frames.items())}

    def sentences(self, n_frames: int, what: str) -> Iterator[str]:
        """Yield a line for each problem, with its first frame.

        n_frames: of all frames, the bad ones too. what: came of the bad ones, in words.
        """
        for problem, frames in sorted(self._frames.items()):
            first, detail = next(iter(frames.items()))
            yield f"{len(frames)} of {n_frames} frames {what}: {problem}, first {first}{detail}"
