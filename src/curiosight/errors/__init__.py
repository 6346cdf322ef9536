"""The errors a user can cause and mend, and what raises them: arguments, inputs, files, kernels."""

from __future__ import annotations

from pathlib import Path
from unicodedata import category


class DataError(Exception):
    """Report a file or folder that cannot be used: where, what was found, what to do.

    Wrong arguments are `ValueError`s instead; a bad frame inside a good recording is no
    exception at all (see `Frame.problem`). It can be pickled, so it reaches the parent of a
    worker process whole.
    """

    def __init__(self, path: Path | str, found: str, remedy: str) -> None:
        # These are what pickle makes the error from again.
        super().__init__(path, found, remedy)
        self.path = Path(path)
        self.found = found
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{printable(str(self.args[0]))}: {self.found}; {self.remedy}"


def printable(text: str) -> str:
    """Return a text on one line that does nothing to a terminal.

    Line breaks, control characters, marks that turn the direction of writing, and bytes that
    are no text become escapes such as \\x1b: a file may have any of them in its name.
    """
    return text if text.isprintable() else "".join(map(_printable, text))


def _printable(character: str) -> str:
    is_shown = character.isprintable() or category(character) == "Zs"  # blanks of any width
    return character if is_shown else ascii(character)[1:-1]
