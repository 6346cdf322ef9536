"""Bad frames are data: count them, so that a run can say what it could not use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Self

from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation

BAD_FRAME = "bad frame"
NOTHING_KNOWN = "every pixel unknown"
NO_OBJECT = "no object"
NO_SURROUNDINGS = "no surroundings"
OTHER = "other problems"
MAX_IDS, MAX_KINDS = 100_000, 1000
# Of the looks; where more taught nothing, something is likely to be wrong with the recording.
MANY = 0.5

_SEE = "see `curiosight segment SOURCE --reasons`"
_UNIT = "check the unit of depth (`curiosight info SOURCE`, depth_scale in camera.json)"
_SCENE = "try --scene floor and --scene table"
_REMEDIES = {
    BAD_FRAME: "mend or leave out the files that are named",
    NOTHING_KNOWN: f"{_SEE}; {_UNIT}; depth teaches within a few metres only",
    NO_OBJECT: f"{_SEE}; things must stand free and whole in view; {_SCENE}; {_UNIT}",
    NO_SURROUNDINGS: f"{_SEE}; something that is no object must be in view; {_SCENE}",
    "no depth": "give depth, or a teacher of another kind (--teacher masks:… or boxes:…)",
    "no reading": "the depth images are empty: mend or leave out these frames",
    "in view": f"{_SEE}; a table or the floor must be in view; --up says how the camera is held; "
    f"{_SCENE}; {_UNIT}",
    "which way is up": 'say how the camera is held: --up, or "mount" in camera.json',
    "mask": "give a mask <id>.png of the image's size for every frame",
    "name this frame": "name the images of the boxes as the frames are named",
}


@dataclass(slots=True)
class _Frames:
    """Frames of one problem. first: id of the first, detail: what is wrong with it. ids: known."""

    first: str
    detail: str
    count: int = 0
    ids: set[str] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class Trouble:
    """What was wrong with a look, in words; None = nothing.

    id: of its frame. frame: with its files. told: as its teacher says. lacks: to be more than what
    depth alone tells. nothing: why it taught nothing about objects.
    """

    id: str
    frame: str | None
    told: str | None
    lacks: str | None
    nothing: str | None

    @classmethod
    def of(cls, frame: Frame, segmentation: Segmentation) -> Self:
        """Return what was wrong with a look at a frame."""
        nothing = _why_nothing(frame, segmentation)
        told, lacks = segmentation.problem, segmentation.lacks or None
        return cls(frame.id, frame.problem, told, lacks, nothing)


class Problems:
    """Count the frames that taught nothing, by what was wrong; each counts once.

    And those that depth alone told of, where masks were to say where objects end. Of a live
    source that goes on for weeks frames beyond `MAX_IDS` are not remembered, and problems beyond
    `MAX_KINDS` are counted together.
    """

    def __init__(self) -> None:
        self._frames: dict[str, _Frames] = {}
        self._by_depth_alone: dict[str, _Frames] = {}

    def add(self, frame: Frame, problem: str | None = None) -> None:
        """Take note of a frame where anything is wrong: with its files, or as `problem` says."""
        self.note(Trouble(frame.id, frame.problem, problem, None, None))

    def add_told(self, frame: Frame, segmentation: Segmentation) -> None:
        """Take note of a frame where anything is wrong: as `add`, or as its teacher says."""
        self.note(Trouble.of(frame, segmentation))

    def note(self, one: Trouble) -> None:
        """Take note of a frame where anything is wrong."""
        if one.frame is not None:
            _count(self._frames, BAD_FRAME, one.id, f" ({one.frame})")
        elif one.told is not None:
            _count(self._frames, one.told, one.id)
        elif one.lacks is not None:
            _count(self._by_depth_alone, one.lacks, one.id)

    def counts(self) -> dict[str, int]:
        """Return the number of frames of each problem."""
        counts = {problem: frames.count for problem, frames in self._frames.items()}
        counts |= {reason: frames.count for reason, frames in self._by_depth_alone.items()}
        return dict(sorted(counts.items()))

    def sentences(self, n_frames: int, what: str) -> Iterator[str]:
        """Yield a line for each problem, with its first frame.

        n_frames: of all frames, the bad ones too. what: came of the bad ones, in words.
        """
        for problem, frames in sorted(self._frames.items()):
            told = f"{frames.count} of {n_frames} frames {what}: {problem}"
            yield f"{told}, first {frames.first}{frames.detail}"
        for reason, alone in sorted(self._by_depth_alone.items()):
            told = f"{alone.count} of {n_frames} frames are told by depth alone"
            yield f"{told}: {reason}, first {alone.first}"


def _count(kinds: dict[str, _Frames], kind: str, frame_id: str, detail: str = "") -> None:
    """Count a frame that was not counted before."""
    if kind not in kinds and len(kinds) >= MAX_KINDS:
        kind = OTHER
    frames = kinds.setdefault(kind, _Frames(frame_id, detail))
    if frame_id not in frames.ids:
        frames.count += 1
        if sum(len(known.ids) for known in kinds.values()) < MAX_IDS:
            frames.ids.add(frame_id)


class Lessons:
    """Count the looks that taught nothing about objects, by the reason.

    A look teaches where the teacher knows both an object and what is none. One that shows no
    object still teaches what is none, but of such looks alone nothing can be learned.
    """

    def __init__(self) -> None:
        self.n_looks = 0
        self._reasons: Counter[str] = Counter()

    def add(self, frame: Frame, segmentation: Segmentation) -> None:
        """Count a look at a frame, by what its teacher said of it."""
        self.note(_why_nothing(frame, segmentation))

    def note(self, reason: str | None) -> None:
        """Count a look; reason: why it taught nothing about objects, None = it did."""
        self.n_looks += 1
        if reason is not None:
            self._reasons[reason] += 1

    @property
    def n_nothing(self) -> int:
        """How many looks taught nothing."""
        return self._reasons.total()

    @property
    def is_suspect(self) -> bool:
        """Tell whether so many looks taught nothing that something is likely to be wrong."""
        return self.n_nothing > MANY * self.n_looks

    def summary(self) -> dict[str, Any]:
        """Return the looks that taught nothing and how many for each reason, JSON-able."""
        return {"looks": self.n_nothing, "reasons": dict(sorted(self._reasons.items()))}

    def sentence(self) -> str | None:
        """Say how many looks taught nothing, and why; None where every one taught."""
        if not self.n_nothing:
            return None
        looks = f"{self.n_nothing} of {self.n_looks} looks"
        return f"{looks} taught nothing about objects: {self._reasons_in_words()}"

    def in_short(self) -> str:
        """Say the same where it is said already of what."""
        reasons = f": {self._reasons_in_words()}" if self.n_nothing else ""
        return f"{self.n_nothing} of {self.n_looks}{reasons}"

    def remedies(self) -> Iterator[str]:
        """Yield for each reason what to try, the most frequent first."""
        for reason, _ in self._by_number():
            for part, remedy in _REMEDIES.items():
                if part in reason:
                    yield f"{reason}: {remedy}"
                    break

    def _reasons_in_words(self) -> str:
        return ", ".join(f"{reason} ({n})" for reason, n in self._by_number())

    def _by_number(self) -> list[tuple[str, int]]:
        return sorted(self._reasons.items(), key=lambda counted: (-counted[1], counted[0]))


def _why_nothing(frame: Frame, segmentation: Segmentation) -> str | None:
    """Return why a look teaches nothing about objects; None where it does."""
    if frame.problem is not None:
        return BAD_FRAME
    if segmentation.problem is not None:
        # Of a mask's problem the file's name is left out, or each would be a reason of its own.
        is_of_mask = segmentation.problem.startswith("mask:")
        return "no usable mask" if is_of_mask else segmentation.problem
    has_object = bool((segmentation.labels == Label.SALIENT).any())
    has_other = bool((segmentation.labels == Label.NOT_SALIENT).any())
    if has_object and has_other:
        return None
    if has_object:
        return NO_SURROUNDINGS
    return NO_OBJECT if has_other else NOTHING_KNOWN
