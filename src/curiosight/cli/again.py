"""The command that does the same again, for a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path


def command_again(
    command: str, sources: Sequence[Path], options: Mapping[str, object]
) -> list[str]:
    """Return the words of a command to be given in the folder that it wrote.

    options: by name, without dashes; None is left out. Paths of files become absolute.
    """
    words = ["curiosight", command, *map(from_anywhere, sources), "--config", "config.toml"]
    for option, value in options.items():
        if value is not None:
            words += [
                f"--{option}",
                from_anywhere(value) if isinstance(value, Path) else str(value),
            ]
    return words


def from_anywhere(path: Path) -> str:
    """Return an absolute path; what is no file or folder, such as a drawn room, as it is."""
    return str(path.absolute() if path.exists() else path)
