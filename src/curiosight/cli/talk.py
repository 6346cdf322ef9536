"""What commands say: notes and warnings to standard error, results to standard output."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from curiosight.datasets import Dataset, open_dataset
from curiosight.viewing.live import FrameProgress, progress_console


class Talk:
    """Speak to the user as much as `--quiet` and `--json` ask for."""

    def __init__(self, *, quiet: bool = False, as_json: bool = False) -> None:
        self.quiet = quiet
        self.as_json = as_json
        self.console = progress_console(is_quiet=quiet)
        self._warnings = Console(stderr=True, highlight=False, soft_wrap=True)
        self._results = Console(highlight=False, soft_wrap=True)

    def note(self, text: str) -> None:
        """Say something worth knowing."""
        self.console.print(text, markup=False, soft_wrap=True)

    def warn(self, text: str) -> None:
        """Say something that the user may want to mend."""
        self._warnings.print(f"warning: {text}", markup=False)

    def following(self, title: str, n_frames: int) -> FrameProgress:
        """Return the line of progress of a command."""
        return FrameProgress(self.console, title, n_frames)

    def results(self, title: str, rows: Mapping[str, Any], content: Any) -> None:
        """Give a command's results: as JSON, or the rows as a table."""
        if self.as_json:
            print(json.dumps(content, indent=1, allow_nan=False))
        elif not self.quiet:
            table = Table(title=title, title_justify="left", show_header=False, box=None)
            for name, value in rows.items():
                table.add_row(name, format_value(value))
            self._results.print(table)


def format_value(value: Any) -> str:
    """Write a result for a person."""
    if value is None:
        return "–"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def open_source(talk: Talk, path: Path, ground_truth: Path | None = None) -> Dataset:
    """Open a recording, and say what it was taken for."""
    dataset = open_dataset(path, ground_truth=ground_truth)
    n_truth = sum(map(dataset.has_ground_truth, range(len(dataset))))
    n_posed = sum(pose is not None for pose in dataset.poses)
    parts = [f"{path}: {dataset.name}, {count(len(dataset), 'frame')}"]
    parts.append(f"{n_posed} with pose" if n_posed else "no poses")
    parts.append(f"{n_truth} with ground truth" if n_truth else "no ground truth")
    talk.note(", ".join(parts))
    for remark in dataset.remarks:
        talk.note(f"  {remark}")
    return dataset


def warn_of_problems(talk: Talk, problems: Mapping[str, int], n_frames: int) -> None:
    """Count what was wrong with frames, a line a kind."""
    for problem, n_affected in sorted(problems.items()):
        talk.warn(f"{n_affected} of {n_frames} looks taught nothing: {problem}")


def count(number: int, noun: str) -> str:
    """Write a number with its noun: 1 frame, 2 frames."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
