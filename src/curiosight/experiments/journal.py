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
from curiosight.errors.compiling import njit
from curiosight.errors.files import replace_file, writing
from curiosight.errors.inputs import check_file
from curiosight.experiments.state_graph import GraphReader, GraphWriter
from curiosight.learner.archive import DAMAGE, MAX_FILE_BYTES

JOURNAL = "journal.bin"  # of a run's folder
KIND, VERSION = b"curiosight journal ", 2
MAGIC = KIND + b"%d\n" % VERSION
# Of each record: a mark, the bytes of its JSON and of its arrays, the CRC-32 of all that follows.
_MARK = b"\xc5rec"
_ENCODER = json.JSONEncoder(separators=(",", ":"), check_circular=False)
_HEAD = struct.Struct("<4sIII")
# What takes less is not made smaller.
LEAST_BYTES = 64
# How truth values are written: eight a byte. How depth is, where a sensor told whole millimetres.
BITS, MILLIMETRES = "bits", "mm"
_NO_READING, _METRES = 2**16 - 1, np.float32(0.001)
_NAN_BITS, _MINUS_BITS = (int(np.float32(one).view(np.uint32)) for one in (np.nan, -0.0))
Array = npt.NDArray[Any]
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
        raise _other(path, content)
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


def _other(path: Path, content: bytes) -> DataError:
    """Return what to raise for a file that does not begin as a journal of this version."""
    version, end, _ = content[len(KIND) : len(KIND) + 8].partition(b"\n")
    if content.startswith(KIND) and end and version.isdigit():
        found = f"is a journal of version {int(version)}, or damaged; this program reads {VERSION}"
        remedy = "go on with the program that wrote it, or begin anew with --from RUN"
        return DataError(path, found, remedy)
    return DataError(path, "is damaged, or no journal of ours", REMEDY)


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


def encoded(record: object) -> bytearray:
    """Return a record as it stands in a journal; ValueError for what cannot be kept."""
    writer = GraphWriter({})
    node = writer.node(record)
    arrays = [*map(_laid_out, writer.arrays.values())]
    text = _ENCODER.encode([node, [one[1:] for one in arrays]]).encode()
    parts: list[bytes | memoryview] = [bytes(_HEAD.size), text]
    content = bytearray().join([*parts, *(one.stored.data for one in arrays)])
    n_arrays = len(content) - _HEAD.size - len(text)
    checksum = zlib.crc32(memoryview(content)[_HEAD.size :])
    _HEAD.pack_into(content, 0, _MARK, len(text), n_arrays, checksum)
    return content


class _Laid(NamedTuple):
    """An array as it is written: in the order of memory, in as few bytes as tell it exactly.

    stored: (n,) elements, or of truth values the bits. As what and as what else it is said:
    stored_as: their type, or `BITS`, or `MILLIMETRES`. name, shape, order: of the array.
    """

    stored: npt.NDArray[Any]
    stored_as: str
    name: str
    shape: tuple[int, ...]
    order: str


def _laid_out(array: npt.NDArray[Any]) -> _Laid:
    flags = array.flags
    is_fortran = flags.f_contiguous and not flags.c_contiguous
    # Of one that has gaps, a copy: what lies between its elements is not its own.
    flat = np.ascontiguousarray((array.T if is_fortran else array).reshape(-1))
    name = array.dtype.str
    said = name, array.shape, "F" if is_fortran else "C"
    if flat.nbytes <= LEAST_BYTES:
        return _Laid(flat, name, *said)
    if flat.dtype == np.bool_:
        return _Laid(np.packbits(flat), BITS, *said)
    if flat.dtype.kind in "iu" and flat.itemsize > 1:
        flat = _narrowed(flat)
    if flat.dtype == np.float32 and (millimetres := _in_millimetres(flat)) is not None:
        return _Laid(millimetres, MILLIMETRES, *said)
    return _Laid(flat, flat.dtype.str, *said)


def _narrowed(whole: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return whole numbers in the smallest type that holds them all."""
    low, high = int(whole.min()), int(whole.max())
    least = np.min_scalar_type(high if low >= 0 else min(low, -1 - high))
    return whole.astype(least) if least.itemsize < whole.itemsize else whole


def _in_millimetres(metres: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16] | None:
    """Return (n,) metres as whole millimetres; None where these would not tell them to the bit."""
    whole = np.empty(len(metres), np.uint16)
    return whole if _find_millimetres(metres, metres.view(np.uint32), whole) else None


@njit(cache=True, nogil=True)
def _find_millimetres(metres: Array, bits: Array, whole: Array) -> bool:
    """Set (n,) whole millimetres, and tell whether they are the metres to the bit.

    bits: of the metres.
    """
    for place in range(len(metres)):
        if bits[place] == _NAN_BITS:
            whole[place] = _NO_READING
            continue
        found = np.rint(metres[place] * np.float32(1000))
        # Nothing is written as -0.
        if not 0 <= found < _NO_READING or np.float32(found) * _METRES != metres[place]:
            return False
        if bits[place] == _MINUS_BITS:
            return False
        whole[place] = np.uint16(found)
    return True


def _in_metres(millimetres: npt.NDArray[np.uint16]) -> npt.NDArray[np.float32]:
    metres = millimetres.astype(np.float32) * _METRES
    metres[millimetres == _NO_READING] = np.nan
    return metres


def _decoded(text: bytes, content: memoryview) -> Any:
    node, said = json.loads(text)
    arrays, start = {}, 0
    for number, (stored_as, name, shape, order) in enumerate(said):
        n = int(np.prod(shape, dtype=np.int64))
        stored: Array
        if stored_as == BITS:
            stored = np.frombuffer(content, np.uint8, -(-n // 8), start)
            flat: Array = np.unpackbits(stored, count=n)
        elif stored_as == MILLIMETRES:
            stored = np.frombuffer(content, np.uint16, n, start)
            flat = _in_metres(stored)
        else:
            stored = flat = np.frombuffer(content, np.dtype(stored_as), n, start)
        # A copy, for it is read-only.
        arrays[f"{number:06d}"] = flat.astype(np.dtype(name)).reshape(shape, order=order)
        start += stored.nbytes
    return GraphReader(arrays, {}).made(node)
