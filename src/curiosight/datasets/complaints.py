"""Hear what OpenCV's decoders complain of: they say it to standard error, and to nobody else."""

from __future__ import annotations

import os
import re
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import IO, TypeVar

Decoded = TypeVar("Decoded")

STDERR = 2
# libjpeg goes on with grey or shifted blocks; libpng's errors are OpenCV's own, too.
DAMAGE = re.compile(rb"(Corrupt JPEG data|Premature end of JPEG|Inconsistent progression).*")
# Webcams leave a few bytes between a picture and its end, which harm nothing.
HARMLESS = re.compile(rb"Corrupt JPEG data: \d{1,2} extraneous bytes before marker 0xd9")
OF_DECODERS = re.compile(
    rb"(Corrupt|Premature|Inconsistent|Invalid|Unsupported|Warning|Unknown|Application"
    rb"|libpng |TIFF|\[ ?WARN|\[ERROR)"
)
_lock = threading.Lock()
_heard: IO[bytes] | None = None


def listen(decode: Callable[[], Decoded]) -> tuple[Decoded, str | None]:
    """Return what a decoder returns, and its complaint of damage; None = it has none.

    One at a time, with descriptor 2 led elsewhere meanwhile: nothing else stops the decoders from
    writing there, or tells what they found. What others write there is handed on.
    """
    with _lock:
        try:
            heard, stderr = _file(), os.dup(STDERR)
        except OSError:  # there is no standard error, or no room for a file
            return decode(), None
        try:
            _flush()
            os.dup2(heard.fileno(), STDERR)
            try:
                decoded = decode()
            finally:
                _flush()
                os.dup2(stderr, STDERR)
            lines = _take(heard)
            foreign = b"".join(line for line in lines if not OF_DECODERS.match(line))
            with suppress(OSError):
                os.write(stderr, foreign) if foreign else None
        finally:
            os.close(stderr)
    return decoded, _damage(lines)


def _damage(lines: list[bytes]) -> str | None:
    found = (DAMAGE.match(line) for line in lines if not HARMLESS.match(line))
    return next((match[0].decode("ascii", "replace").strip() for match in found if match), None)


def _file() -> IO[bytes]:
    global _heard
    if _heard is None:
        _heard = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 - as long as the program
    return _heard


def _take(heard: IO[bytes]) -> list[bytes]:
    heard.seek(0)
    content = heard.read()
    heard.seek(0)
    heard.truncate()
    return content.splitlines(keepends=True)


def _flush() -> None:
    with suppress(OSError, ValueError):
        sys.stderr.flush() if sys.stderr else None
