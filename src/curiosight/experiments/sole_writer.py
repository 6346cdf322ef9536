"""One writer of a folder at a time, by a lock that ends with whoever holds it."""

from __future__ import annotations

import errno
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from curiosight.errors import DataError
from curiosight.errors.files import writing

LOCK = ".curiosight.lock"
_HELD = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)
_N_TRIES = 10

if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(file: int) -> None:
        # Of this open file, not of the process as with `lockf`: two in one process exclude each
        # other, too. Over NFS the server is asked, so that other machines are kept out.
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


_held: ContextVar[ExitStack | None] = ContextVar("held", default=None)


@contextmanager
def letting_go() -> Iterator[None]:
    """Let go of all folders at the end that `hold` was called for meanwhile."""
    with ExitStack() as held:
        before = _held.set(held)
        try:
            yield
        finally:
            _held.reset(before)


def hold(folder: Path) -> None:
    """Be the `sole_writer` of a folder to the end of the `letting_go` around, if there is one."""
    held = _held.get()
    if held is not None:
        held.enter_context(sole_writer(folder))


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Keep all others from writing a folder, which is made if it is not there.

    The system lets go of the lock however this process ends, even where the file that it is on
    stays. A file system that has no locks is warned of.

    Raises `DataError` where another writes the folder now, or nobody can.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    file = _locked_file(folder)
    try:
        yield
    finally:
        # Before it is let go of: who waits for it sees that its name is gone, and tries again.
        with suppress(OSError):
            (folder / LOCK).unlink()
        os.close(file)


def _locked_file(folder: Path) -> int:
    """Return the open file that is locked; it tells others who holds it."""
    path = folder / LOCK
    for _ in range(_N_TRIES):
        with writing(path):
            # Workers do not inherit it: one that outlives this process for a moment holds nothing.
            file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _try_to_lock(file, path)
            with writing(path):
                if _is_of(file, path):
                    _write_holder(file)
                    return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)
    raise DataError(folder, "is written by others again and again", "choose another --out")


def _try_to_lock(file: int, path: Path) -> None:
    try:
        _lock(file)
    except OSError as error:
        if error.errno in _HELD:
            found = f"is being written by another command{_holder(path)}"
            remedy = "wait for it, or choose another --out"
            raise DataError(path.parent, found, remedy) from None
        text = f"cannot be locked ({error.strerror}); let no other command write into it now"
        warnings.warn(f"{path.parent}: {text}", stacklevel=2)


def _is_of(file: int, path: Path) -> bool:
    """Tell whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def _write_holder(file: int) -> None:
    os.ftruncate(file, 0)
    os.write(file, f"process {os.getpid()} on {socket.gethostname()}\n".encode())


def _holder(path: Path) -> str:
    """Return who holds the lock, as they wrote it; "" = not known."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")[:200].strip()
    except OSError:
        return ""
    return f", {text}" if text else ""
