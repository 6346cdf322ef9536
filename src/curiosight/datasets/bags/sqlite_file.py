"""Scan a bag of ROS 2 in an SQLite database, also one that is cut short."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote

import yaml

from curiosight.datasets.bags.messages import HEAD_BYTES, Messages, type_name
from curiosight.datasets.bags.sources import BagFile, unpacked
from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError

MAGIC = b"SQLite format 3\0"
# What SQLite says of a damaged database may be no text, either.
FAULTS = (sqlite3.Error, UnicodeDecodeError)
REMEDY = "copy or record it again"


class SqliteFile(BagFile):
    """A bag in a database; the offset of a message is its row. `DataError` where it is none."""

    def __init__(self, path: Path, *, are_zstd: bool = False) -> None:
        super().__init__(path, are_zstd=are_zstd)
        with path.open("rb") as file:
            head = file.read(100)
            size = file.seek(0, 2)
        if not head.startswith(MAGIC) or len(head) < 100:
            raise DataError(path, "is no SQLite database", REMEDY)
        n_page = int.from_bytes(head[16:18], "big")
        n_page = 65536 if n_page == 1 else n_page
        self._is_cut = size < n_page * int.from_bytes(head[28:32], "big")
        with self._database() as database:
            self._scan(database)

    def read(self, messages: Messages, number: int) -> bytes:
        try:
            with self._database() as database:
                return self._content(database, messages.offsets[number])
        except FAULTS as error:
            raise UnreadableFile(f"{self.path.name} cannot be read ({error})") from error

    def contents(self, messages: Messages) -> Iterator[tuple[int, bytes]]:
        with self._database() as database:
            for number, row in enumerate(messages.offsets):
                with suppress(*FAULTS, UnreadableFile):
                    yield number, self._content(database, row)

    def _content(self, database: sqlite3.Connection, row: int) -> bytes:
        found = database.execute("SELECT data FROM messages WHERE id = ?", (row,)).fetchone()
        if found is None or not isinstance(found[0], bytes):
            raise UnreadableFile(f"{self.path.name} has lost a message")
        return unpacked(found[0], "zstd") if self.are_zstd else found[0]

    @contextmanager
    def _database(self) -> Iterator[sqlite3.Connection]:
        """Open it without writing; what a recorder that was killed left beside it is read too."""
        log, shared = (self.path.with_name(f"{self.path.name}-{part}") for part in ("wal", "shm"))
        has_log = log.is_file() and log.stat().st_size > 0
        is_in_use = shared.exists()
        database = self._connect(log if has_log else None)
        try:
            if self._is_cut:
                # Else a database that is shorter than it says is refused whole.
                with suppress(*FAULTS):
                    database.execute("PRAGMA writable_schema=ON")
            yield database
        finally:
            database.close()
            if has_log and not is_in_use:
                # SQLite makes it to read the log, and leaves it.
                with suppress(OSError):
                    shared.unlink(missing_ok=True)

    def _connect(self, log: Path | None) -> sqlite3.Connection:
        place = f"file:{quote(str(self.path.absolute()))}"
        if log is not None:
            database = _open(f"{place}?mode=ro")
            try:
                database.execute("SELECT count(*) FROM sqlite_master")
                return database
            except FAULTS:  # it would have to write beside it, and may not
                database.close()
                fault = f"{log.name} cannot be read: the last messages may be missing"
                self.faults += [fault] if fault not in self.faults else []
        return _open(f"{place}?immutable=1")

    def _scan(self, database: sqlite3.Connection) -> None:
        try:
            listed = database.execute("SELECT id, name, type, serialization_format FROM topics")
            by_id = {
                number: self.topics.setdefault(
                    (str(topic), type_name(str(kind))),
                    Messages(str(topic), type_name(str(kind)), str(encoding)),
                )
                for number, topic, kind, encoding in listed
            }
        except FAULTS as error:
            found = f"is no bag of ROS 2, or cut before its messages ({error})"
            raise DataError(self.path, found, REMEDY) from None
        with suppress(*FAULTS, yaml.YAMLError):
            self.n_announced = _announced(database)
        try:
            for topic, row, logged_ns, length, head in self._rows(database, by_id):
                by_id[topic].add(-1, row, length, logged_ns, head)
        except (*FAULTS, UnreadableFile):
            self._is_cut = True
        if self._is_cut:
            self.faults.append("it is cut short or damaged, read to its last whole message")

    def _rows(
        self, database: sqlite3.Connection, by_id: dict[int, Messages]
    ) -> Iterator[tuple[int, int, int, int, bytes]]:
        """Yield topic, row, time, length and first bytes of each message that is whole."""
        query = "SELECT topic_id, id, timestamp, length(data) FROM messages ORDER BY id"
        for topic, row, logged_ns, length in database.execute(query):
            are_numbers = all(isinstance(value, int) for value in (row, logged_ns, length))
            if topic not in by_id or not are_numbers:
                continue
            head = b""
            if by_id[topic].is_stamped or self._is_cut:
                # A part of it, as a query would read it whole.
                with database.blobopen("messages", "data", row, readonly=True) as blob:
                    head = blob.read(length if self._is_cut or self.are_zstd else HEAD_BYTES)
                if self.are_zstd:
                    head = unpacked(head, "zstd")
            yield topic, row, logged_ns, length, head[:HEAD_BYTES]


def _open(place: str) -> sqlite3.Connection:
    # Any thread may ask, one at a time; a connection serves one question.
    database = sqlite3.connect(place, uri=True, check_same_thread=False)
    database.text_factory = lambda content: content.decode("utf-8", "replace")
    return database


def _announced(database: sqlite3.Connection) -> int | None:
    """Return how many messages the recorder noted when it closed the bag."""
    row = database.execute("SELECT metadata FROM metadata ORDER BY id DESC").fetchone()
    content = yaml.safe_load(row[0]) if row and row[0] else None
    count = content.get("message_count") if isinstance(content, dict) else None
    return count if isinstance(count, int) else None
