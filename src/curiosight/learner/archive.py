"""The container of the files that curiosight writes: one checked `.npz` without any pickle.

Beside one `.npy` member per array the zip holds `header.json`: what the caller said of the
arrays, the kind of file, the format's version, and a SHA-256 over all of it. `numpy.load`
opens the arrays too. The same content gives the same bytes.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.errors.files import replace_file
from curiosight.errors.inputs import check_file

Arrays = dict[str, npt.NDArray[np.generic]]
Header = dict[str, Any]

MODEL = "model.npz"  # of a run's folder
FORMAT = "curiosight"
VERSION = 1
HEADER_NAME = "header.json"
# What deflated arrays may unpack to. More is written as it is, and then is as large as its file.
MAX_BYTES = 2**28
MAX_FILE_BYTES = 2**33
COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
# What zipfile, zlib, json and numpy raise on bytes that are not what they claim to be.
DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    MemoryError,
)


def find_model(run: Path | str) -> Path:
    """Return the model file of a run's folder; what is no folder, as it is.

    Raises `DataError` for a folder without a model.
    """
    run = Path(run)
    if not os.path.isdir(run):  # unlike a Path's own `is_dir`, never raises
        return run
    if not os.path.isfile(run / MODEL):
        raise DataError(run, f"holds no {MODEL}", "give the folder that --out of explore wrote")
    return run / MODEL


def write_archive(
    path: Path | str,
    kind: str,
    header: Header,
    arrays: Mapping[str, npt.NDArray[Any]],
    *,
    is_packed: bool = True,
) -> None:
    """Write `arrays` and a JSON-able `header` to `path`, completely or not at all.

    is_packed: deflate them, where they are no more than `MAX_BYTES`; without, the file is larger
        and written some ten times sooner.
    Raises DataError where the file cannot be written, ValueError on arrays of objects.
    """
    path = Path(path)
    members = {f"{name}.npy": _encode(name, array) for name, array in sorted(arrays.items())}
    # What JSON changes (keys become text, tuples lists) changes before the checksum is taken.
    header = json.loads(json.dumps(header))
    envelope = {"format": FORMAT, "version": VERSION, "kind": kind, "header": header}
    checksum = _checksum(envelope, members)
    text = json.dumps(envelope | {"checksum": checksum}, indent=1, sort_keys=True)
    members = {HEADER_NAME: text.encode()} | members
    is_packed = is_packed and sum(map(len, members.values())) <= MAX_BYTES
    contents = _zip(members, is_packed=is_packed)
    replace_file(path, contents, is_synced=True)


def read_archive(path: Path | str, kind: str) -> tuple[Header, Arrays]:
    """Return header and arrays of a file that `write_archive` wrote with the same `kind`.

    Raises DataError on anything else: missing, foreign, damaged, another kind, too new.
    """
    path = Path(path)
    remedy = f"give a {kind} file that curiosight wrote"
    try:
        members = _unzip(path)
        text = members.pop(HEADER_NAME)
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror or error})", remedy) from error
    except DAMAGE as error:
        found = "not a curiosight file, or a damaged one"
        raise DataError(path, found, remedy) from error
    envelope = _read_envelope(path, text, remedy)
    if envelope["kind"] != kind:
        raise DataError(path, f"a curiosight file of kind {envelope['kind']!r}", remedy)
    checksum = envelope.pop("checksum", None)
    if checksum != _checksum(envelope, members):
        raise DataError(path, "damaged: its checksum does not match", "write or copy it again")
    try:
        arrays = {name.removesuffix(".npy"): _decode(member) for name, member in members.items()}
        return dict(envelope["header"]), arrays
    except DAMAGE as error:
        raise DataError(path, f"holds an array that cannot be read ({error})", remedy) from error


def _read_envelope(path: Path, text: bytes, remedy: str) -> Header:
    """Parse `header.json`, and check that this version can read what it announces."""
    try:
        envelope: Header = json.loads(text)
        is_ours = envelope["format"] == FORMAT and {"kind", "header"} <= envelope.keys()
        version = int(envelope["version"])
    except DAMAGE as error:
        raise DataError(path, "not a curiosight file, or a damaged one", remedy) from error
    if not is_ours:
        raise DataError(path, "not a curiosight file", remedy)
    if version > VERSION:
        found = f"written by a newer curiosight (format {version}, this one reads {VERSION})"
        raise DataError(path, found, "update curiosight")
    return envelope


def _encode(name: str, array: npt.NDArray[Any]) -> bytes:
    """Return `array` as the bytes of a `.npy` file."""
    if array.dtype.hasobject:
        raise ValueError(f"{name}: expected an array of numbers or text, got {array.dtype}")
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, allow_pickle=False)
    return buffer.getvalue()


def _decode(member: bytes) -> npt.NDArray[np.generic]:
    array: npt.NDArray[np.generic] = np.lib.format.read_array(
        io.BytesIO(member), allow_pickle=False
    )
    return array


def _checksum(envelope: Header, members: Mapping[str, bytes]) -> str:
    """Return the SHA-256 of everything a file says, each part preceded by its length."""
    digest = hashlib.sha256()
    parts = [json.dumps(envelope, sort_keys=True).encode()]
    for name in sorted(members):
        parts += [name.encode(), members[name]]
    for part in parts:
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return digest.hexdigest()


def _zip(members: Mapping[str, bytes], *, is_packed: bool) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, member in members.items():
            # A ZipInfo of its own carries no clock, umask or operating system.
            info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED if is_packed else zipfile.ZIP_STORED
            info.create_system = 3
            info.external_attr = 0o644 << 16
            archive.writestr(info, member)
    return buffer.getvalue()


def _unzip(path: Path) -> dict[str, bytes]:
    """Return the members of a zip, which may unpack to `MAX_BYTES`, or to what the file is."""
    check_file(path, MAX_FILE_BYTES)
    most = max(MAX_BYTES, path.stat().st_size)
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        if sum(info.file_size for info in members) > most:
            raise zipfile.BadZipFile("unpacks to too many bytes")
        # No `.npz` is packed in another way, and each way has errors of its own.
        if any(info.compress_type not in COMPRESSIONS for info in members):
            raise zipfile.BadZipFile("is neither stored nor deflated")
        return {info.filename: archive.read(info) for info in members}
