"""Furniture libraries that are broken, or made to do harm."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from curiosight.errors import DataError
from curiosight.rooms.sweet_home import untrusted_zip
from curiosight.rooms.sweet_home.materials import read_texture
from curiosight.rooms.sweet_home.wavefront import (
    ModelError,
    read_mtl,
    read_obj,
)
from furniture_library import (
    CATALOGUE,
    CRATE,
    GREEN,
    face_colour,
    only_mesh,
    picture,
    write_library,
)


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return write_library(tmp_path / "tiny.sh3f")


@pytest.mark.parametrize(
    "name", ["../secret.png", "/secret.png", "..\\secret.png", "C:/secret.png"]
)
def test_nothing_outside_the_zip_is_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.png").write_bytes(picture((1, 2, 3), (1, 2, 3)))
    (tmp_path / "secret.mtl").write_bytes(b"newmtl sides\nKd 0 0 1\n")
    materials = f"newmtl front\nKd 0 1 0\nmap_Kd {name}\n".encode()
    model = CRATE.replace(b"mtllib", b"mtllib ../secret.mtl\nmtllib")
    mesh = only_mesh(write_library(tmp_path / "a.sh3f", mtl=materials, obj=model))
    np.testing.assert_array_equal(face_colour(mesh, (0, -1, 0)), GREEN)
    np.testing.assert_array_equal(face_colour(mesh, (0, 1, 0)), [204, 204, 204])


def bomb(path: Path) -> Path:
    return write_library(path, obj=b"v 0 0 0\n" * (10 * 2**20))


def liar(path: Path) -> Path:
    """Write a zip whose large member says that it is small."""
    write_library(path, obj=b"v 0 0 0\n" * 2**20)
    content = path.read_bytes()
    return _rewritten(path, content.replace(struct.pack("<I", 8 * 2**20), struct.pack("<I", 800)))


def _rewritten(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def missing(path: Path) -> Path:
    return path


def folder(path: Path) -> Path:
    path.mkdir()
    return path


def not_a_zip(path: Path) -> Path:
    return _rewritten(path, b"PK\x03\x04 but no zip")


def truncated(path: Path) -> Path:
    return _rewritten(path, write_library(path).read_bytes()[:-100])


def unusually_packed(path: Path) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("PluginFurnitureCatalog.properties", CATALOGUE)
    return path


@pytest.mark.parametrize(
    ("write", "found"),
    [
        (missing, "missing"),
        (folder, "not a file"),
        (not_a_zip, "not a zip file"),
        (truncated, "not a zip file"),
        (unusually_packed, "unusual way"),
        (bomb, "unpacks to 80 MB"),
        (liar, "damaged"),
    ],
)
def test_bad_files_are_data_errors(
    tmp_path: Path, write: Callable[[Path], Path], found: str
) -> None:
    path = write(tmp_path / "bad.sh3f")
    with pytest.raises(DataError, match=found) as caught:
        only_mesh(path)
    assert caught.value.path == path


@pytest.mark.parametrize(
    ("member", "content", "found"),
    [
        ("properties", None, "PluginFurnitureCatalog.properties is missing"),
        ("properties", b"", "0 entries"),
        ("properties", b"name#1=A\nmodel#1=a.obj\nwidth#1=1\ndepth#1=1", "entry 1 has no height"),
        ("properties", CATALOGUE.replace("=40", "=nan").encode(), "width of 'nan'"),
        ("properties", CATALOGUE.replace("=40", "=-1").encode(), "width of '-1'"),
        ("properties", CATALOGUE.encode() + b"modelRotation#1=1 2 3", "modelRotation"),
        ("obj", None, "crate.obj is missing"),
        ("obj", b"", "no faces"),
        ("obj", CRATE.replace(b"v 1 1 1", b"v 1 nan 1"), "line 8 is not a v line"),
        ("obj", CRATE.replace(b"v 1 1 1", b"v 1 1e300 1"), "line 8 is not a v line"),
        ("obj", CRATE + b"f 1 2 9", "is not a f line"),
        ("obj", CRATE + b"f 0 1 2", "is not a f line"),
        ("obj", CRATE + b"f -9 1 2", "is not a f line"),
        ("obj", CRATE + b"f 1/9 2/1 3/1", "is not a f line"),
        ("obj", CRATE + b"f 1 2 99999999999999999999", "is not a f line"),
        ("obj", CRATE + b"f 1 2 3\n" * 20_001, "more than 20000 triangles"),
        ("obj", CRATE + b"v 1 2 3\n" * 200_001, "more than 200000 vertices"),
        ("obj", b"# " + b"x" * 30_000, "too long"),
        ("obj", b"\n" * 1_000_001, "one too many"),
        ("obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3", "at one place"),
        ("obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3", "no face has an area"),
        ("mtl", b"newmtl front\nKd red green blue", "is not a Kd line"),
        ("png", b"GIF89a", "neither PNG nor JPEG"),
        ("png", picture()[:60], "cannot be decoded"),
        ("png", picture()[:16] + struct.pack(">II", 50_000, 50_000) + picture()[24:], "50000x"),
    ],
)
def test_bad_members_are_data_errors(
    tmp_path: Path, member: str, content: bytes | None, found: str
) -> None:
    path = write_library(tmp_path / "bad.sh3f", **{member: content})
    with pytest.raises(DataError, match=found):
        only_mesh(path)


def test_a_library_unpacks_to_so_much_in_all(library: Path) -> None:
    with untrusted_zip.UntrustedZip(library, "", 2 * len(CRATE) - 1) as archive:
        archive.read("models/crate.obj")
        with pytest.raises(DataError, match=r"crate\.obj in it unpacks"):
            archive.read("models/crate.obj")


KEYWORDS = ["v", "vt", "f", "usemtl", "mtllib", "newmtl", "Kd", "Ns", "d", "x"]
WORDS = st.sampled_from([*KEYWORDS, "0", "1", "-1", "2", "3", "1/1", "2//3", "1e9", "nan", "inf"])
TEXTS = st.lists(st.lists(WORDS, max_size=6).map(" ".join), max_size=12).map("\n".join)


@given(TEXTS.map(str.encode) | st.binary(max_size=200))
def test_any_text_is_read_or_a_model_error(content: bytes) -> None:
    for read in (read_obj, read_mtl):
        try:
            result = read(content)
        except ModelError:
            continue
        assert result is not None
    if not content.startswith((b"\x89PNG", b"\xff\xd8")):
        with pytest.raises(ModelError):
            read_texture(content)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150)
@given(place=st.floats(0, 1, exclude_max=True), junk=st.binary(min_size=1, max_size=8))
def test_a_damaged_library_is_read_or_a_data_error(
    library: Path, tmp_path: Path, place: float, junk: bytes
) -> None:
    content = bytearray(library.read_bytes())
    start = int(place * len(content))
    content[start : start + len(junk)] = junk
    (tmp_path / "damaged.sh3f").write_bytes(content)
    try:
        mesh = only_mesh(tmp_path / "damaged.sh3f")
    except DataError:
        return
    assert len(mesh.triangles) > 0
