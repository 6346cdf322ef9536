"""Read files that somebody named: no pipe is waited for, and no device fills memory."""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path
from typing import Any

# Of one file: pictures of a hundred million pixels, or boxes of a hundred thousand.
MAX_BYTES = 2**29
KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


class NotReadable(OSError):  # noqa: N818 - what the system might have said, in words
    """Say why a path is no file to be read whole; `strerror` are the words."""

    def __str__(self) -> str:
        return str(self.strerror)


def check_file(path: Path | str, max_bytes: int | None = MAX_BYTES) -> None:
    """Raise `OSError` where a path, or what it is a link to, is no file, or one too large.

    To be called before anything opens it: opening a pipe waits for someone to write into it, and
    some devices never end. max_bytes: None = of any size, for what is not read whole.
    """
    found = os.stat(path)
    kind = stat.S_IFMT(found.st_mode)
    if kind == stat.S_IFDIR:
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if kind != stat.S_IFREG:
        words = f"it is {KINDS.get(kind, 'something else')}, not a file"
        raise NotReadable(errno.EINVAL, words, str(path))
    if max_bytes is not None:
        _check_size(path, found.st_size, max_bytes)


def read_bytes(path: Path | str, max_bytes: int = MAX_BYTES) -> bytes:
    """Return the content of a file; `OSError` as `check_file` says."""
    check_file(path, max_bytes)
    with open(path, "rb") as file:
        # What the system makes up as it is read says that it is empty.
        content = file.read(max_bytes + 1)
    _check_size(path, len(content), max_bytes)
    return content


def read_text(path: Path | str, encoding: str = "utf-8", max_bytes: int = MAX_BYTES) -> str:
    """Return the text of a file, its lines ended by \\n; `OSError` or `UnicodeDecodeError`."""
    text = read_bytes(path, max_bytes).decode(encoding)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_json_object(path: Path | str) -> dict[str, Any]:
    """Return the JSON object that a file holds; empty where it cannot be read, or holds none."""
    try:
        content = json.loads(read_text(path))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _check_size(path: Path | str, n_bytes: int, max_bytes: int) -> None:
    if n_bytes > max_bytes:
        size = f"{max_bytes / 2**20:.3g} MB"
        raise NotReadable(errno.EFBIG, f"it is larger than {size}", str(path))
