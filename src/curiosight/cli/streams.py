"""Standard output and standard error that never end a run, whatever becomes of them."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
import time
from typing import Any, TextIO

_PLAIN = {"–": "-", "…": "...", "×": "x", "→": "->", "≥": ">=", "≤": "<=", "²": "2"}
_PLAINLY = "curiosight-plainly"


class Output(io.FileIO):
    """A descriptor that takes everything; what could not be written is gone.

    error: the first that writing met; None = nothing is lost.
    """

    def __init__(self, descriptor: int, *, is_closed: bool) -> None:
        super().__init__(descriptor, "wb", closefd=False)
        self.error: OSError | None = None
        self._is_closed = is_closed

    def write(self, data: Any, /) -> int:
        """Write as much as goes; a reader that is slow is waited for."""
        try:
            if self._is_closed:
                raise OSError(errno.EBADF, "closed")
            n_written = super().write(data)
            while n_written is None:  # the descriptor does not block, and its pipe is full
                time.sleep(0.01)
                n_written = super().write(data)
        except OSError as error:
            self.error = self.error or error
            return len(data)
        return n_written


def settle_streams() -> Output | None:
    """Let no stream end the run, and no character that it cannot show; return standard output.

    What is closed becomes the null device: the next file that is opened would take its place,
    and get what was meant for a person. None where standard output is no file, in a test, say.
    """
    codecs.register_error(_PLAINLY, _write_plainly)
    is_closed = [_is_closed(descriptor) for descriptor in range(3)]
    out, sys.stdout = _settle(sys.stdout, 1, is_closed=is_closed[1])
    _, sys.stderr = _settle(sys.stderr, 2, is_closed=is_closed[2])
    return out


def _is_closed(descriptor: int) -> bool:
    """Tell whether it is closed, and open the null device in its place."""
    try:
        os.fstat(descriptor)
    except OSError:
        os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest that is free
        return True
    return False


def _settle(
    stream: TextIO | None, descriptor: int, *, is_closed: bool
) -> tuple[Output | None, TextIO]:
    if stream is None:
        output = Output(descriptor, is_closed=is_closed)
        return output, io.TextIOWrapper(io.BufferedWriter(output), "utf-8", line_buffering=True)
    if not isinstance(stream, io.TextIOWrapper):
        return None, stream
    stream.flush()
    output = Output(stream.fileno(), is_closed=False)
    return output, io.TextIOWrapper(
        io.BufferedWriter(output),
        stream.encoding,
        _PLAINLY,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


def _write_plainly(error: UnicodeError) -> tuple[str, int]:
    """Replace what an encoding has no character for."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lost = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lost), error.end
