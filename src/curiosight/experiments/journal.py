"""A file that grows by one checked record after the other, and is read up to its last whole one."""

from __future__ import annotations

import errno
import json
import os
import struct
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.errors.files import replace_file, writing
from curiosight.errors.inputs import check_file
from curiosight.experiments.state_graph import GraphReader, GraphWriter
from curiosight.learner.archive import DAMAGE, MAX_FILE_BYTES

JOURNAL = "journal.bin"  # of a run's folder
MAGIC = b"curiosight journal 1\n"
# Of each record: a mark, the bytes of its JSON and of its arrays, the CRC-32 of all that follows.
_MARK = b"\xc5rec"
_HEAD = struct.Struct("<4sIII")
# A power cut costs no more than what was written since.
SYNC_S = 2.0
REMEDY = "put the file back as it was, or begin anew with --from RUN"


class Journal:
    """Write records behind each other; each is there, whole, when `add` returns.

    A kill leaves all of them; a power cut those that were synced. One thread adds and begins anew,
    another may sync.
    """

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self._path, self._clock = path, clock
        self._file: int | None = None
        self._lock = threading.Lock()
        self._is_synced, self._synced_at = True, clock()
        self.n_bytes = 0

    def begin_anew(self) -> None:
        """Put an empty journal in the place of the one that is there, whole or not at all."""
        with self._lock:
            replace_file(self._path, MAGIC, is_synced=True)
            with writing(self._path):
                if self._file is not None:
                    os.close(self._file)
                flags = os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0)
                self._file = os.open(self._path, flags)
            self.n_bytes, self._is_synced = len(MAGIC), True

    def add(self, record: object) -> None:
        """Add a record; raises `DataError` where it cannot be written, and leaves no part of it."""
        content = encoded(record)
        with self._lock, writing(self._path):
            if self._file is None:
                raise ValueError("journal: expected one that was begun")
            n_written = os.write(self._file, content)
            if n_written != len(content):
                os.ftruncate(self._file, self.n_bytes)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self.n_bytes += n_written
            self._is_synced = False

    def sync_if_due(self) -> None:
        """Wait until all is on the disk, where that was not done for `SYNC_S`."""
        if self._is_synced or self._clock() - self._synced_at < SYNC_S:
            return
        with self._lock, writing(self._path):
            if self._file is None:
                return
            self._is_synced = True
            # Of its own, so that whoever adds does not wait for the disk.
            file = os.dup(self._file)
        try:
            with writing(self._path):
                os.fsync(file)
        finally:
            os.close(file)
        self._synced_at = self._clock()

    def close(self) -> None:
        """Close the file, once it is on the disk; may be called twice."""
        with self._lock, writing(self._path):
            if self._file is not None:
                os.fsync(self._file)
                os.close(self._file)
                self._file = None


class Read(NamedTuple):
    """The records of a journal; n_cut: bytes of a last one that is not whole."""

    records: list[Any]
    n_cut: int


def read_journal(path: Path) -> Read:
    """Return what is in a journal; no records where there is none.

    Raises `DataError` for what is no journal, and for one that is damaged before its last record.
    """
    try:
        check_file(path, MAX_FILE_BYTES)
        content = path.read_bytes()
    except FileNotFoundError:
        return Read([], 0)
    except OSError as error:
        told = f"cannot be read ({error.strerror or error})"
        raise DataError(path, told, "check its rights") from error
    if not content.startswith(MAGIC):
        raise DataError(path, "is damaged, or no journal of ours", REMEDY)
    records, end = [], len(MAGIC)
    while (found := _payload_at(content, end)) is not None:
        payload, end = found
        try:
            records.append(_decoded(*payload))
        except (*DAMAGE, IndexError, ImportError, RecursionError) as error:
            raise DataError(path, f"holds no usable record ({error})", REMEDY) from error
    if any(True for _ in _whole_behind(content, end)):
        damage = f"is damaged behind its record {len(records)}, and more follow"
        raise DataError(path, damage, REMEDY)
    return Read(records, len(content) - end)


def _payload_at(content: bytes, start: int) -> tuple[tuple[bytes, memoryview], int] | None:
    """Return JSON and arrays of the record that begins there, and its end; None of no whole one."""
    if start + _HEAD.size > len(content):
        return None
    mark, n_json, n_arrays, checksum = _HEAD.unpack_from(content, start)
    first = start + _HEAD.size
    end = first + n_json + n_arrays
    if mark != _MARK or end > len(content):
        return None
    payload = memoryview(content)[first:end]
    if zlib.crc32(payload) != checksum:
        return None
    return (bytes(payload[:n_json]), payload[n_json:]), end


def _whole_behind(content: bytes, start: int) -> Iterator[int]:
    """Yield where whole records begin behind a place where none does."""
    found = content.find(_MARK, start + 1)
    while found >= 0:
        if _payload_at(content, found) is not None:
            yield found
        found = content.find(_MARK, found + 1)


def encoded(record: object) -> bytes:
    """Return a record as it stands in a journal; ValueError for what cannot be kept."""
    writer = GraphWriter({})
    node = writer.node(record)
    arrays = [*map(_laid_out, writer.arrays.values())]
    said = [(one.dtype.str, shape, order) for one, shape, order in arrays]
    text = json.dumps([node, said], separators=(",", ":")).encode()
    checksum = zlib.crc32(text)
    for one, _, _ in arrays:
        checksum = zlib.crc32(one.data, checksum)
    n_bytes = sum(one.nbytes for one, _, _ in arrays)
    head = _HEAD.pack(_MARK, len(text), n_bytes, checksum)
    return b"".join([head, text, *(one.data for one, _, _ in arrays)])


def _laid_out(array: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], tuple[int, ...], str]:
    """Return an array's elements in the order of memory, its shape, and how it is laid out."""
    is_fortran = array.flags.f_contiguous and not array.flags.c_contiguous
    flat = np.ascontiguousarray(array.T if is_fortran else array).ravel()
    return flat, array.shape, "F" if is_fortran else "C"


def _decoded(text: bytes, content: memoryview) -> Any:
    node, said = json.loads(text)
    arrays, start = {}, 0
    for number, (name, shape, order) in enumerate(said):
        dtype = np.dtype(name)
        n = int(np.prod(shape, dtype=np.int64))
        flat = np.frombuffer(content, dtype, n, start).copy()
        arrays[f"{number:06d}"] = flat.reshape(shape, order=order)
        start += flat.nbytes
    return GraphReader(arrays, {}).made(node)
