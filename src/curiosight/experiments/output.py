"""The folder that a command writes: never over a user's files without being told to."""

from __future__ import annotations

import csv
import errno
import io
import itertools
import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError, printable
from curiosight.errors.files import replace_file, try_to_write_in, writing
from curiosight.experiments.sole_writer import LOCK, hold
from curiosight.experiments.written import Written

# What spreadsheets begin a formula with, and what we mark one with.
FORMULA = ("=", "+", "-", "@", "'")


def default_path(command: str, ending: str = "") -> Path:
    """Return where a command writes that was told nothing."""
    return Path("runs") / f"{command}-{datetime.now():%Y%m%d-%H%M%S}{ending}"


class OutputFolder:
    """A folder to write results to.

    It is made with its first file: a command that is refused leaves nothing behind. From then on
    it is this command's alone, until the command ends (`hold`).

    path: None = a new folder `runs/<command>-<date>-<time>`. One that exists and is not empty
        is refused unless `overwrite`; then what an earlier such command wrote there is removed
        before the first file is written, and files of the same names are replaced.
    source: the recording that is read; nothing is written into it but a new `runs` folder. None =
        none is.
    is_held: keep others from writing it, and remove what an earlier one wrote; without, who asks
        sees to that.
    goes_on: with what the same command wrote there before, which stays.
    option: that lets a command write into a folder that is not empty.
    """

    def __init__(
        self,
        path: Path | None,
        command: str,
        source: Path | None,
        *,
        overwrite: bool = False,
        is_held: bool = True,
        goes_on: bool = False,
        option: str = "--overwrite",
    ) -> None:
        self._option = option
        self._may_exist = path is not None
        self.path = path or default_path(command)
        self._overwrite = overwrite or goes_on
        self._goes_on = goes_on
        self._is_held = is_held
        self._is_made = False
        self._command = command
        self._kept = set[str]()
        self._written: Written | None = None
        with writing(self.path):
            if path and source and path.resolve().is_relative_to(source.resolve()):
                found = "lies inside the recording, which stays as it is"
                raise DataError(path, found, "choose an --out elsewhere")
            if self.path.exists():
                self._check_existing()
            try_to_write_in(self.path)

    def write_text(self, name: str, text: str) -> None:
        """Write a file, completely or not at all."""
        self._write(name, text.encode())

    def write_json(self, name: str, content: Any) -> None:
        """Write JSON-able content, with NaN refused."""
        self._write(name, json_bytes(content))

    def write_image(self, name: str, image: npt.NDArray[Any]) -> None:
        """Write a grey (H, W) uint8 or uint16 or an RGB image; the name's ending says how."""
        if image.ndim == 3:
            image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
        is_encoded, encoded = cv2.imencode(Path(name).suffix, np.ascontiguousarray(image))
        if not is_encoded:
            raise ValueError(f"name: expected an image's ending, got {name!r}")
        self._write(name, encoded.tobytes())

    def _write(self, name: str, content: bytes) -> None:
        replace_file(self.file(name, content), content)

    def hold(self) -> None:
        """Make the folder now, for what is written there by its path."""
        with writing(self.path):
            if not self._is_made:
                self._make()

    def keep(self, name: str) -> None:
        """Let a file of an earlier command stay until it is written anew."""
        self._kept.add(name)

    def remove(self, names: Iterable[str]) -> None:
        """Remove files of an earlier run that this one will write later, or not at all.

        What lies beside them stays: the folder may hold a user's own files.
        """
        for name in names:
            path = self.path / name
            with writing(path):
                path.unlink(missing_ok=True)

    def remove_half_written(self) -> None:
        """Remove what a kill left of files that were being written: nobody else writes here."""
        with writing(self.path):
            for pattern in ("", "figures/"):
                for path in self.path.glob(f"{pattern}.*.partial"):
                    if re.fullmatch(r"\..+\.\d+\.partial", path.name):
                        path.unlink(missing_ok=True)

    def file(self, name: str, content: bytes | None = None) -> Path:
        """Return the path of a file to be written, its folder made.

        content: what it will hold, where that is known; so a later command can tell whether
        somebody changed it.
        """
        with writing(self.path):
            if not self._is_made:
                self._make()
            path = self.path / name
            path.parent.mkdir(parents=True, exist_ok=True)
        if self._written is not None:
            self._written.note(name, content)
        return path

    def _make(self) -> None:
        """Make the folder; a name of ours that another run took in this second gets a number."""
        stem = self.path.name
        for number in itertools.count(2):
            try:
                self.path.mkdir(parents=True, exist_ok=self._may_exist)
                break
            except FileExistsError:
                if self._may_exist:
                    raise
                self.path = self.path.with_name(f"{stem}-{number}")
        if self._is_held:
            hold(self.path)
            self._check_existing()  # whoever held it until now may have written
            self._written = Written(self.path, self._command)
            if not self._goes_on:
                self._written.remove_all(self._kept)
        self._is_made = True

    def _check_existing(self) -> None:
        if not self.path.is_dir():
            raise DataError(self.path, "is a file", "choose a folder for --out")
        if all(path.name == LOCK for path in self.path.iterdir()):
            return
        if not self._overwrite:
            remedy = f"choose another --out, or add {self._option}"
            raise DataError(self.path, "exists and is not empty", remedy)


def write_json_file(path: Path, content: Any) -> None:
    """Write JSON-able content, completely or not at all, with NaN refused."""
    replace_file(path, json_bytes(content))


def json_bytes(content: Any) -> bytes:
    """Return JSON-able content as a file holds it; ValueError where there is NaN."""
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


class TableFile:
    """A CSV file that is complete up to the last row whenever it is read.

    Numbers are written with six decimals, None as an empty cell.

    n_kept: bytes of a file that is there, to go on behind; None = begin anew. What stood behind
        them is written again: `is_other` tells whether anything of it came out otherwise.
        Raises DataError for a file that is shorter.
    """

    def __init__(self, path: Path, columns: Sequence[str], *, n_kept: int | None = None) -> None:
        self._path = path
        self._columns = list(columns)
        self._before, self._n_bytes = b"", 0
        self.is_other = False
        with writing(path):
            self._file = path.open("wb" if n_kept is None else "r+b", buffering=0)
            if n_kept is None:
                self._write(self._columns)
            else:
                self._go_on(n_kept)

    def _go_on(self, n_kept: int) -> None:
        n_bytes = self._file.seek(0, os.SEEK_END)
        if n_bytes < n_kept:
            self._file.close()
            found = f"holds {n_bytes} bytes, not the {n_kept} that it had"
            raise DataError(self._path, found, "put the whole file back")
        self._file.seek(n_kept)
        self._before = self._file.readall()
        self._file.truncate(n_kept)
        self._file.seek(n_kept)

    def add(self, row: Mapping[str, Any]) -> None:
        """Append a row; every column must be there."""
        with writing(self._path):
            self._write([_cell(row[column]) for column in self._columns])

    def sync(self) -> int:
        """Wait until all of it is on the disk; return how many bytes there are."""
        with writing(self._path):
            if not self._file.closed:
                os.fsync(self._file.fileno())
                self._n_bytes = self._file.tell()
        return self._n_bytes

    def close(self) -> None:
        """Close the file, once it is on the disk."""
        self.sync()
        with writing(self._path):
            self._file.close()

    def _write(self, cells: Sequence[Any]) -> None:
        line = io.StringIO()
        csv.writer(line, lineterminator="\n").writerow(cells)
        content = line.getvalue().encode()
        start = self._file.tell()
        if self._file.write(content) != len(content):
            self._file.truncate(start)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        n_before = min(len(content), len(self._before))
        self.is_other |= self._before[:n_before] != content[:n_before]
        self._before = self._before[n_before:]


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, str):
        return written_cell(value)
    return f"{value:.6f}" if isinstance(value, float) else value


def written_cell(text: str) -> str:
    """Return a text as it stands in a table: on one line, and no formula to a spreadsheet.

    An apostrophe before it tells spreadsheets that it is text; `read_cell` takes it away.
    """
    shown = printable(text)
    return f"'{shown}" if shown.startswith(FORMULA) and not _is_number(shown) else shown


def read_cell(cell: str) -> str:
    """Return the text of a cell that `written_cell` made."""
    return cell[1:] if cell.startswith("'") else cell


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
