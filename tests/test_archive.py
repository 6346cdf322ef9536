"""Files survive the round trip, and everything that is not one of ours is refused in words."""

from __future__ import annotations

import errno
import io
import json
import os
import zipfile

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.learner import archive
from curiosight.learner.archive import read_archive, write_archive

HEADER = {"features": "paper", "n_trees": 30, "share": 0.7, "names": ["a", "ü"]}
ARRAYS = {
    "rows": np.arange(60, dtype=np.uint8).reshape(5, 12),
    "values": np.array([0.5, np.nan], np.float32),
    "empty": np.empty((0, 3), np.int32),
    "columns": np.asfortranarray(np.eye(3)),
    "scalar": np.array(7),
}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "model.npz"
    write_archive(path, "model", HEADER, ARRAYS)
    return path


def rewrite_header(path, **changes):
    """Change header.json and leave the rest of the zip as it is."""
    with zipfile.ZipFile(path) as source:
        members = {name: source.read(name) for name in source.namelist()}
    members["header.json"] = json.dumps(json.loads(members["header.json"]) | changes).encode()
    with zipfile.ZipFile(path, "w") as target:
        for name, member in members.items():
            target.writestr(name, member)


def test_round_trip(path):
    header, arrays = read_archive(path, "model")
    assert header == HEADER
    assert arrays.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(arrays[name], array)
        assert arrays[name].dtype == array.dtype
        assert arrays[name].shape == array.shape


def test_header_comes_back_as_json_has_it(path):
    write_archive(path, "model", {"by_tree": {9: (1, 2), 10: None}}, {})
    assert read_archive(path, "model") == ({"by_tree": {"9": [1, 2], "10": None}}, {})


def test_numpy_opens_the_arrays(path):
    with np.load(path, allow_pickle=False) as loaded:
        np.testing.assert_array_equal(loaded["rows"], ARRAYS["rows"])


def test_same_content_gives_same_bytes(path, tmp_path, monkeypatch):
    monkeypatch.setattr("time.time", lambda: 2e9)
    other = tmp_path / "other.npz"
    write_archive(other, "model", dict(reversed(HEADER.items())), dict(reversed(ARRAYS.items())))
    assert other.read_bytes() == path.read_bytes()


def test_every_damaged_byte_is_noticed(path):
    contents = path.read_bytes()
    for position in range(0, len(contents), 3):
        damaged = bytearray(contents)
        damaged[position] ^= 0x55
        path.write_bytes(damaged)
        try:
            header, arrays = read_archive(path, "model")
        except DataError:
            continue
        # Some bytes of a zip (times, attributes) say nothing about its content.
        assert header == HEADER
        assert all(np.array_equal(arrays[n], ARRAYS[n], equal_nan=True) for n in ARRAYS)


def test_every_truncation_is_refused(path):
    contents = path.read_bytes()
    for length in range(0, len(contents), 7):
        path.write_bytes(contents[:length])
        with pytest.raises(DataError, match="damaged"):
            read_archive(path, "model")


def write_npz():
    buffer = io.BytesIO()
    np.savez(buffer, rows=np.zeros(3))
    return buffer.getvalue()


@pytest.mark.parametrize(
    "contents",
    [b"", b"hello\n", b"\x89PNG\r\n\x1a\n" + bytes(200), write_npz()],
    ids=["empty", "text", "image", "npz"],
)
def test_foreign_files_are_refused(tmp_path, contents):
    path = tmp_path / "foreign.npz"
    path.write_bytes(contents)
    with pytest.raises(DataError, match=r"foreign\.npz: not a curiosight file.*; give a model"):
        read_archive(path, "model")


def test_missing_files_and_folders_are_refused(tmp_path):
    with pytest.raises(DataError, match="No such file"):
        read_archive(tmp_path / "nothing.npz", "model")
    with pytest.raises(DataError, match="Is a directory"):
        read_archive(tmp_path, "model")


def test_other_kinds_and_newer_versions_are_refused(path):
    with pytest.raises(DataError, match="a curiosight file of kind 'model'; give a history file"):
        read_archive(path, "history")
    rewrite_header(path, version=archive.VERSION + 1)
    with pytest.raises(DataError, match=r"newer curiosight .*; update curiosight"):
        read_archive(path, "model")


@pytest.mark.parametrize(
    "changes", [{"header": {"n_trees": 31}}, {"checksum": None}, {"header": None}]
)
def test_changed_headers_are_refused(path, changes):
    rewrite_header(path, **changes)
    with pytest.raises(DataError, match="checksum does not match"):
        read_archive(path, "model")


@pytest.mark.parametrize("changes", [{"format": "other"}, {"version": "new"}, {"version": None}])
def test_headers_of_other_programs_are_refused(path, changes):
    rewrite_header(path, **changes)
    with pytest.raises(DataError, match="not a curiosight file"):
        read_archive(path, "model")


def test_files_that_unpack_to_too_much_are_refused(path, monkeypatch):
    write_archive(path, "model", HEADER, {"rows": np.zeros(100_000, np.uint8)})
    assert path.stat().st_size < 5000
    monkeypatch.setattr(archive, "MAX_BYTES", 50_000)
    with pytest.raises(DataError, match="not a curiosight file, or a damaged one"):
        read_archive(path, "model")


def test_what_is_written_can_be_read_however_large(path, monkeypatch):
    monkeypatch.setattr(archive, "MAX_BYTES", 50_000)
    write_archive(path, "model", HEADER, {"rows": np.zeros(100_000, np.uint8)})
    assert path.stat().st_size > 100_000, "it is not packed"
    assert not read_archive(path, "model")[1]["rows"].any()


@pytest.mark.parametrize("compression", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
@pytest.mark.parametrize("is_damaged", [True, False])
def test_other_compressions_are_refused(path, compression, is_damaged):
    with zipfile.ZipFile(path, "w", compression) as target:
        target.writestr("header.json", json.dumps({"format": archive.FORMAT}) * 20)
    contents = bytearray(path.read_bytes())
    if is_damaged:
        start = contents.index(b"header.json") + len("header.json")
        contents[start : start + 12] = bytes(12)
    path.write_bytes(contents)
    with pytest.raises(DataError, match="not a curiosight file, or a damaged one"):
        read_archive(path, "model")


def test_pickled_members_are_refused_though_the_checksum_matches(path, monkeypatch):
    def encode_pickled(name, array):
        buffer = io.BytesIO()
        np.save(buffer, array.astype(object), allow_pickle=True)
        return buffer.getvalue()

    monkeypatch.setattr(archive, "_encode", encode_pickled)
    write_archive(path, "model", HEADER, ARRAYS)
    with pytest.raises(DataError, match="array that cannot be read"):
        read_archive(path, "model")


def test_arrays_of_objects_are_refused(tmp_path):
    with pytest.raises(ValueError, match="names: expected an array of numbers or text, got object"):
        write_archive(tmp_path / "model.npz", "model", {}, {"names": np.array([None])})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("number", "message"),
    [(errno.ENOSPC, "No space left.*free some space"), (errno.EIO, "cannot be written")],
)
def test_failed_writes_keep_the_old_file_and_leave_no_part(path, monkeypatch, number, message):
    def fail(descriptor):
        raise OSError(number, os.strerror(number))

    before = path.read_bytes()
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(DataError, match=message):
        write_archive(path, "model", {"n_trees": 1}, {})
    assert path.read_bytes() == before
    assert [entry.name for entry in path.parent.iterdir()] == ["model.npz"]


def test_an_interrupted_write_keeps_the_old_file(path, monkeypatch):
    def interrupt(descriptor):
        raise KeyboardInterrupt

    before = path.read_bytes()
    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_archive(path, "model", {}, {})
    assert path.read_bytes() == before
    assert [entry.name for entry in path.parent.iterdir()] == ["model.npz"]


def test_missing_folder_is_named(tmp_path):
    with pytest.raises(DataError, match=r"cannot be written .*; check the folder and its rights"):
        write_archive(tmp_path / "none" / "model.npz", "model", {}, {})
    (tmp_path / "file").write_text("")
    with pytest.raises(DataError, match="Not a directory"):
        write_archive(tmp_path / "file" / "model.npz", "model", {}, {})
