"""The errors a user can cause and mend."""

from __future__ import annotations

from pathlib import Path


class DataError(Exception):
    """Report a file or folder that cannot be used: where, what was found, what to do.

    Wrong arguments are `ValueError`s instead; a bad frame inside a good recording is no
    exception at all (see `Frame.problem`).
    """

    def __init__(self, path: Path | str, found: str, remedy: str) -> None:
        self.path = Path(path)
        self.found = found
        self.remedy = remedy
        super().__init__(f"{path}: {found}; {remedy}")
