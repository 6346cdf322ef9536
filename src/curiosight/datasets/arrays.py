"""Read NumPy's files, with what they claim to hold compared with what they do hold."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.inputs import read_bytes

ZIP_START = b"PK"
# That one array of a packed file may unpack to.
MAX_BYTES = 2**29


def read_array(path: Path, choose: Callable[[list[str]], str] | None = None) -> npt.NDArray[Any]:
    """Return the array of a `.npy` file, or one of those in a `.npz` file.

    choose: the one of their names; None = a `.npz` is not wanted. What it raises goes through;
    else raises `OSError`, and `ValueError` for any other file.
    """
    content = read_bytes(path)
    if choose is None or not content.startswith(ZIP_START):
        return _array(content)
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
    # What damage makes of the reader is not foreseeable.
    except Exception as error:
        raise ValueError(f"arrays: expected a zip of them ({error})") from error
    member = choose([name.removesuffix(".npy") for name in archive.namelist()])
    return _array(_unpacked(archive, f"{member}.npy"))


def _unpacked(archive: zipfile.ZipFile, name: str) -> bytes:
    try:
        n_bytes = archive.getinfo(name).file_size
        with archive.open(name) as member:
            # Asked for so many bytes it unpacks no more, whatever it says of its size.
            return member.read(n_bytes) if n_bytes <= MAX_BYTES else b""
    except Exception as error:
        raise ValueError(f"arrays: expected a zip of them ({error})") from error


def _array(content: bytes) -> npt.NDArray[Any]:
    """Return the array that a `.npy` file's bytes hold; `ValueError` where they do not."""
    try:
        _check_length(content)
        array: npt.NDArray[Any] = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    except Exception as error:
        raise ValueError(f"array: expected one in NumPy's form ({error})") from error
    return array


def _check_length(content: bytes) -> None:
    """Raise `ValueError` where an array claims more than there is."""
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    with_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    if version not in with_header:  # names of columns that are not latin
        return
    shape, _, dtype = with_header[version](file)
    n_bytes = np.prod(shape, dtype=float) * dtype.itemsize
    if any(length < 0 for length in shape) or n_bytes > len(content) - file.tell():
        raise ValueError("shape: larger than the file")
