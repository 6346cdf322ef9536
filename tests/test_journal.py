"""A journal is read to its last whole record, and refused where it is damaged before that."""

from __future__ import annotations

import json
import os
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.experiments import journal as journal_module
from curiosight.experiments.journal import (
    _HEAD,
    _MARK,
    MAGIC,
    SYNC_S,
    Journal,
    encoded,
    read_journal,
)
from curiosight.explorer.outcome import Outcome, Seen
from curiosight.frame import Camera

RECORDS: list[Any] = [
    {"n": 1, "rows": np.arange(12, dtype=np.uint8).reshape(3, 4), "flat": np.zeros((0, 3))},
    [Outcome(0.25, has_changed=True), Camera(4, 3, 2.0, 2.0, 1.5, 1.0), 2**127 + 1],
    (np.asfortranarray(np.arange(6.0).reshape(2, 3)), np.array(5), None, "ü"),
]


def write(path: Path) -> bytes:
    journal = Journal(path)
    journal.begin_anew()
    for record in RECORDS:
        journal.add(record)
    assert journal.n_bytes == path.stat().st_size
    journal.close()
    return path.read_bytes()


def test_records_come_back_in_their_order(tmp_path: Path) -> None:
    content = write(tmp_path / "j")
    assert content == MAGIC + b"".join(map(encoded, RECORDS))
    (first, second, third), n_cut = read_journal(tmp_path / "j")
    assert n_cut == 0
    assert first["rows"].dtype == np.uint8
    assert first["rows"].tolist() == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]
    assert first["flat"].shape == (0, 3)
    outcome, camera, number = second
    assert (outcome.error, outcome.seen, outcome.has_changed) == (0.25, None, True)
    assert camera == Camera(4, 3, 2.0, 2.0, 1.5, 1.0)
    assert number == 2**127 + 1
    assert third[0].flags.f_contiguous
    assert third[0].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert third[1].shape == ()


@pytest.mark.parametrize(
    ("array", "n_bytes"),
    [
        (np.array([0, 255, 3]), 3),
        (np.array([-1, 127], np.int64), 2),
        (np.array([-1, 200], np.int64), 4),
        (np.array([[0, 70_000]], np.uint64), 8),
        (np.array([-1, 2**62]), 16),
        (np.array([2**64 - 1, 0], np.uint64), 16),
        (np.array([5, 6], ">i4"), 2),
        (np.array([7], np.uint8), 1),
        (np.asfortranarray(np.arange(6).reshape(2, 3)), 6),
        (np.arange(17).reshape(17, 1) % 3 == 0, 3),
        (np.zeros((0, 4), np.bool_), 0),
        (np.zeros((3, 0), np.int64), 0),
        (np.array([0.1, np.nan], np.float64), 16),
        (np.arange(65_535, dtype=np.float32) * np.float32(0.001), 2 * 65_535),
        (np.array([np.nan, 1234, 0], np.float32) * np.float32(0.001), 6),
        (np.array([1.2345, np.nan], np.float32), 8),
        (np.array([-0.0, 1], np.float32), 8),
        (np.array([65.535, np.inf], np.float32), 8),
        (np.array([0x7FC00001], np.uint32).view(np.float32), 4),
    ],
)
def test_arrays_come_back_exactly_from_the_fewest_bytes(
    array: np.ndarray, n_bytes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_module, "LEAST_BYTES", 1)
    journal = Journal(tmp_path / "j")
    journal.begin_anew()
    journal.add(array)
    journal.close()
    (back,) = read_journal(tmp_path / "j").records
    assert (back.dtype, back.shape) == (array.dtype, array.shape)
    assert back.flags.f_contiguous == array.flags.f_contiguous
    assert back.tobytes() == array.tobytes()
    _, _, n_arrays, _ = _HEAD.unpack_from((tmp_path / "j").read_bytes(), len(MAGIC))
    assert n_arrays == n_bytes


@pytest.mark.parametrize(
    "array",
    [
        np.arange(40, dtype=np.float32)[::2],
        np.arange(40)[::-1],
        (np.arange(80) % 3 == 0)[::2],
        np.broadcast_to(np.float64(0.5), 30),
        np.arange(120.0).reshape(6, 20)[:, 3],
    ],
)
def test_array_with_gaps_comes_back(
    array: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for least in (1, 10_000):
        monkeypatch.setattr(journal_module, "LEAST_BYTES", least)
        (tmp_path / "j").write_bytes(MAGIC + encoded(array))
        (back,) = read_journal(tmp_path / "j").records
        assert (back.dtype, back.shape, back.strides) == (array.dtype, array.shape, array.strides)
        assert back.tobytes() == array.tobytes()


def test_cut_anywhere_it_is_read_to_its_last_whole_record(tmp_path: Path) -> None:
    content, path = write(tmp_path / "j"), tmp_path / "cut"
    ends = [len(MAGIC)]
    for record in RECORDS:
        ends.append(ends[-1] + len(encoded(record)))
    for size in range(len(MAGIC), len(content) + 1):
        path.write_bytes(content[:size])
        records, n_cut = read_journal(path)
        assert len(records) == sum(end <= size for end in ends[1:])
        assert n_cut == size - max(end for end in ends if end <= size)


def test_last_record_that_is_damaged_is_no_whole_one(tmp_path: Path) -> None:
    """As after a power cut: its bytes were not written, or others."""
    content, path = write(tmp_path / "j"), tmp_path / "bad"
    start = len(content) - len(encoded(RECORDS[-1]))
    for place in range(start, len(content)):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        assert len(read_journal(path).records) == 2
    path.write_bytes(content[:start] + bytes(5000))
    records, n_cut = read_journal(path)
    assert (len(records), n_cut) == (2, 5000)


def test_damage_before_the_last_record_is_refused(tmp_path: Path) -> None:
    content, path = write(tmp_path / "j"), tmp_path / "bad"
    for place in range(len(content) - len(encoded(RECORDS[-1]))):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        with pytest.raises(DataError, match="damaged"):
            read_journal(path)


def test_what_is_no_journal_is_refused(tmp_path: Path) -> None:
    assert read_journal(tmp_path / "none") == ([], 0)
    path = tmp_path / "j"
    for content in (b"", b"something else", MAGIC[:-1]):
        path.write_bytes(content)
        with pytest.raises(DataError, match="is damaged, or no journal of ours"):
            read_journal(path)
    path.write_bytes(MAGIC.replace(b"2", b"1") + bytes(100))
    with pytest.raises(DataError, match="version 1, or damaged; this program reads 2"):
        read_journal(path)
    text = json.dumps([["object", "os:_Environ", None], []]).encode()
    path.write_bytes(MAGIC + _HEAD.pack(_MARK, len(text), 0, zlib.crc32(text)) + text)
    with pytest.raises(DataError, match="holds no usable record"):
        read_journal(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(DataError, match="cannot be read"):
        read_journal(path)


def test_record_of_another_class_than_ours_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="cannot be kept"):
        encoded(tmp_path)
    journal = Journal(tmp_path / "j")
    journal.begin_anew()
    with pytest.raises(ValueError, match="cannot be kept"):
        journal.add([Seen(np.zeros((1, 3), np.float32), np.zeros(1, np.uint8)), open])
    journal.add("whole")
    journal.close()
    assert read_journal(tmp_path / "j") == (["whole"], 0)


def test_it_begins_anew_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "j"
    journal = Journal(path)
    with pytest.raises(ValueError, match="expected one that was begun"):
        journal.add(1)
    journal.begin_anew()
    journal.add(1)

    def failing(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", failing)
        with pytest.raises(DataError, match="cannot be written"):
            journal.begin_anew()
    journal.add(2)
    assert read_journal(path).records == [1, 2]
    journal.begin_anew()
    assert read_journal(path) == ([], 0)
    assert journal.n_bytes == len(MAGIC)
    journal.close()


def test_full_disk_leaves_no_half_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, write = tmp_path / "j", os.write
    journal = Journal(path)
    journal.begin_anew()
    journal.add(1)
    with monkeypatch.context() as patch:
        patch.setattr(os, "write", lambda file, content: write(file, content[:7]))
        with pytest.raises(DataError, match="No space left on device"):
            journal.add(2)
    journal.add(3)
    assert read_journal(path) == ([1, 3], 0)
    journal.close()


def test_it_is_synced_every_few_seconds_where_it_has_grown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, synced = [0.0], []
    journal = Journal(tmp_path / "j", clock=lambda: now[0])
    journal.begin_anew()
    fsync = os.fsync
    monkeypatch.setattr(os, "fsync", lambda file: (synced.append(now[0]), fsync(file)))
    for tenth in range(100):
        now[0] = tenth / 10
        if tenth == 3 or 40 <= tenth < 80:
            journal.add(tenth)
        journal.sync_if_due()
    assert synced[0] == SYNC_S
    assert np.diff(synced).min() >= SYNC_S
    assert synced[-1] <= 7.9 + SYNC_S + 0.1
    assert len(synced) == 4
    journal.close()
