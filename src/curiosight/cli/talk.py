"""What commands say: notes and warnings to standard error, results to standard output."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from curiosight.datasets import Dataset
from curiosight.errors import printable
from curiosight.experiments.describing import doubts_of
from curiosight.experiments.problems import Problems
from curiosight.viewing.live import FrameProgress, progress_console
from curiosight.viewing.paper import NEEDED, can_draw

NOTHING_LEARNED = (
    "nothing was learned: no frame showed both an object and its surroundings "
    "(see what `curiosight segment` makes of it)"
)
NO_CLASSES = "no frame shows anything salient, or all of them nothing else: no figures"


def need_figures(command: str) -> None:
    """Raise `ValueError` where a command's figures cannot be drawn, before it works for hours."""
    if not can_draw():
        raise ValueError(f"{command}: its figures {NEEDED}")


class Talk:
    """Speak to the user as much as `--quiet` and `--json` ask for.

    Names of files and frames are somebody else's: they are shown `printable`.
    """

    def __init__(self, *, quiet: bool = False, as_json: bool = False) -> None:
        self.quiet = quiet
        self.as_json = as_json
        self.console = progress_console(is_quiet=quiet)
        self._warnings = Console(stderr=True, highlight=False, emoji=False)
        self._results = Console(highlight=False, emoji=False)

    def note(self, text: str) -> None:
        """Say something worth knowing."""
        self.console.print(printable(text), markup=False, soft_wrap=True)

    def can_draw(self) -> bool:
        """Tell whether figures can be drawn; where they cannot, say that they are left out."""
        if not can_draw():
            self.note(f"figures are left out: they {NEEDED}")
        return can_draw()

    def warn(self, text: str) -> None:
        """Say something that the user may want to mend."""
        self._warnings.print(f"warning: {printable(text)}", markup=False, soft_wrap=True)

    def warn_of_learned(self, n_learned: int, n_tested: int) -> None:
        """Warn where a model is tested on what it was taught with."""
        if n_learned:
            self.warn(f"{n_learned} of {n_tested} test frames were learned from: too good scores")

    def warn_of(self, problems: Problems, n_frames: int, what: str) -> None:
        """Count the bad ones of so many frames, a line for each problem; what: came of them."""
        for sentence in problems.sentences(n_frames, what):
            self.warn(sentence)

    def introduce(self, path: Path, dataset: Dataset, *, for_depth: bool = True) -> None:
        """Say what a source was taken for and, where its depth is used, what contradicts itself.

        To be called once the command can start: a refusal is one line and no more.
        """
        n_truth = sum(map(dataset.has_ground_truth, range(len(dataset))))
        n_posed = sum(pose is not None for pose in dataset.poses)
        parts = [f"{path}: {dataset.name}, {count(len(dataset), 'frame')}"]
        parts.append(f"{n_posed} with pose" if n_posed else "no poses")
        parts.append(f"{n_truth} with ground truth" if n_truth else "no ground truth")
        self.note(", ".join(parts))
        reasons = getattr(dataset, "reasons", ())
        if reasons:
            self.note(f"  told by {'; '.join(reasons)}")
        for remark in dataset.remarks:
            self.note(f"  {remark}")
        for doubt in doubts_of(dataset) if for_depth else []:
            self.warn_of_doubt(doubt.text, doubt.fix)

    def warn_of_doubt(self, text: str, fix: str) -> None:
        """Warn of what contradicts itself in a recording; fix: the option that mends it."""
        self.warn(f"{text} ({fix})")

    def following(self, title: str, n_frames: int, unit: str = "frame") -> FrameProgress:
        """Return the line of progress of a command."""
        return _Progress(self.console, title, n_frames, unit=unit)

    def results(self, title: str, rows: Mapping[str, Any], content: Any) -> None:
        """Give a command's results: as JSON, or the rows as a table."""
        if self.as_json:
            print(json.dumps(content, indent=1, allow_nan=False))
        elif not self.quiet:
            self._results.print(printable(title), style="bold", markup=False, soft_wrap=True)
            width = max(map(len, rows))
            for name, value in rows.items():
                line = f"  {name:{width}}  {format_value(value)}"
                self._results.print(printable(line), markup=False, soft_wrap=True)


class _Progress(FrameProgress):
    """Progress with a note that may be anybody's, such as a region's name."""

    def advance(self, note: str = "") -> None:
        super().advance(printable(note))


def format_value(value: Any) -> str:
    """Write a result for a person."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def count(number: int, noun: str) -> str:
    """Write a number with its noun: 1 frame, 2 frames."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def scores_are_too_good(n_learned: int, n_tested: int) -> str:
    """Say in a report that a model was tested on what it was taught with."""
    tested = count(n_tested, "test frame")
    return f"{n_learned} of {tested} were learned from: the scores are too good."
