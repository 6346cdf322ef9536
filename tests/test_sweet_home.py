"""Furniture libraries: what is in them arrives upright and in metres, whatever is in them."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from curiosight.errors import DataError
from curiosight.worlds.rooms.mesh import Mesh
from curiosight.worlds.rooms.sweet_home import SweetHomeLibrary, untrusted_zip
from curiosight.worlds.rooms.sweet_home.materials import image_size, read_texture
from curiosight.worlds.rooms.sweet_home.wavefront import (
    ModelError,
    count_triangles,
    read_mtl,
    read_obj,
)

Array = npt.NDArray[Any]

CATALOGUE = """# a comment
id=Tiny
id#1=tiny#crate
name#1=Wooden \\u201ccrate\\u201d
category#1=Boxes
model#1=/models/crate.obj
width#1=40
depth#1=30.0
height#1=20
movable#1=true
doorOrWindow#1=false
"""
# A unit cube, y up; z = 1 is the front, which alone shows the picture.
CRATE = b"""mtllib crate.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl front
f 5/1 6/2 7/3 8/4
usemtl sides
f 1 4 3 2\nf 4 8 7 3\nf 1 2 6 5\nf 1 5 8 4\nf -7 -6 -2 -3
"""
MATERIALS = b"newmtl front\nmap_Kd front.png\nnewmtl sides\nKd 1 0 0\nKs 1 1 1\nNs 50\n"
DEBIANS = Path("/usr/share/sweethome3d/furniture/BlendSwap-CC-0.sh3f")
RED, GREEN = (255, 0, 0), (0, 255, 0)


def picture(top: tuple[int, int, int] = RED, bottom: tuple[int, int, int] = GREEN) -> bytes:
    """Return a PNG of 600x300 of two colours."""
    image = np.empty((300, 600, 3), np.uint8)
    image[:150], image[150:] = top[::-1], bottom[::-1]
    return bytes(cv2.imencode(".png", image)[1])


def members() -> dict[str, bytes]:
    return {
        "PluginFurnitureCatalog.properties": CATALOGUE.encode("latin-1"),
        "models/crate.obj": CRATE,
        "models/crate.mtl": MATERIALS,
        "models/front.png": picture(),
    }


def write_library(path: Path, **changes: bytes | None) -> Path:
    """Write the tiny library; `changes` replace members (by ending) or, as None, leave them out."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members().items():
            new = changes.get(name.rpartition(".")[2], content)
            if new is not None:
                archive.writestr(name, new)
    return path


def only_mesh(path: Path) -> Mesh:
    library = SweetHomeLibrary(path)
    return library.mesh(library.entries[0])


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return write_library(tmp_path / "tiny.sh3f")


def face_colour(mesh: Mesh, normal: tuple[float, float, float]) -> Array:
    """Return the mean colour of the material of all triangles that face one way."""
    faces = (mesh.normals[mesh.triangles].mean(1) @ np.array(normal)) > 0.99
    materials = {int(number) for number in mesh.surface[faces]}
    assert len(materials) == 1
    colour: Array = mesh.materials[materials.pop()].texture.reshape(-1, 3).mean(0)
    return colour


def test_catalogue_gives_names_and_metres(library: Path) -> None:
    (entry,) = SweetHomeLibrary(library).entries
    assert entry.name == "Wooden “crate”"
    assert entry.category == "Boxes"
    assert entry.size == pytest.approx((0.4, 0.3, 0.2))
    assert entry.diagonal == pytest.approx(0.5385, abs=1e-4)


def test_mesh_stands_in_the_middle_in_the_catalogues_size(library: Path) -> None:
    mesh = only_mesh(library)
    low, high = mesh.bounds
    np.testing.assert_allclose(low, [-0.2, -0.15, 0], atol=1e-6)
    np.testing.assert_allclose(high, [0.2, 0.15, 0.2], atol=1e-6)
    corners = mesh.vertices[mesh.triangles].astype(float)
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.einsum("ij,ij->", corners[:, 0], crosses) / 6 == pytest.approx(0.4 * 0.3 * 0.2)
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() <= 0.12
    outwards = np.einsum("tij,tj->ti", mesh.normals[mesh.triangles], crosses)
    assert (outwards > 0.99 * np.linalg.norm(crosses, axis=1)[:, None]).all()


def test_front_looks_to_minus_y_with_its_picture_upright(library: Path) -> None:
    mesh = only_mesh(library)
    np.testing.assert_allclose(face_colour(mesh, (0, -1, 0)), [127.5, 127.5, 0], atol=2)
    for side in ((0, 1, 0), (0, 0, 1), (1, 0, 0), (-1, 0, 0)):
        np.testing.assert_array_equal(face_colour(mesh, side), RED)
    texture = next(m.texture for m in mesh.materials if m.texture.shape[0] > 1)
    assert texture.shape == (128, 256, 3)
    on_front = mesh.normals[:, 1] < -0.99
    v = mesh.uv[on_front, 1]
    np.testing.assert_allclose(mesh.vertices[on_front, 2], 0.2 * v, atol=1e-5)
    np.testing.assert_allclose(mesh.uv[on_front, 0], mesh.vertices[on_front, 0] / 0.4 + 0.5)
    assert tuple(texture[0, 0]) == GREEN  # row 0 is at v = 0, the bottom
    assert tuple(texture[-1, 0]) == RED


def test_model_rotation_comes_first(tmp_path: Path) -> None:
    quarter_turn = CATALOGUE + "modelRotation#1=0 0 1 0 1 0 -1 0 0\n"  # +z to +x: the front
    mesh = only_mesh(write_library(tmp_path / "a.sh3f", properties=quarter_turn.encode()))
    np.testing.assert_allclose(face_colour(mesh, (1, 0, 0)), [127.5, 127.5, 0], atol=2)
    np.testing.assert_allclose(mesh.bounds[1], [0.2, 0.15, 0.2], atol=1e-6)


def test_faces_twice_or_inside_out_look_the_same(library: Path, tmp_path: Path) -> None:
    faces = [line for line in CRATE.decode().splitlines() if line.startswith("f")]
    turned = [" ".join(["f", *reversed(line.split()[1:])]) for line in faces]
    inside_out = CRATE.decode()
    for face, back in zip(faces, turned, strict=True):
        inside_out = inside_out.replace(face, back)
    mesh = only_mesh(library)
    backwards = only_mesh(write_library(tmp_path / "b.sh3f", obj=inside_out.encode()))
    np.testing.assert_allclose(
        np.sort(backwards.normals, axis=0), np.sort(mesh.normals, axis=0), atol=1e-6
    )
    twice = CRATE + ("\n".join(turned[1:]) + "\n").encode()
    doubled = only_mesh(write_library(tmp_path / "c.sh3f", obj=twice))
    assert len(doubled.triangles) == len(mesh.triangles)


def test_round_things_are_smooth(tmp_path: Path) -> None:
    around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = [f"v {np.cos(a)} {y} {np.sin(a)}" for y in (0, 1) for a in around]
    sides = [f"f {i + 1} {i + 25} {(i + 1) % 24 + 25} {(i + 1) % 24 + 1}" for i in range(24)]
    caps = [
        "f " + " ".join(str(i + 25) for i in range(24)),
        "f " + " ".join(map(str, range(1, 25))),
    ]
    model = "\n".join(ring + sides + caps).encode()
    catalogue = CATALOGUE.replace("=30.0", "=40")
    mesh = only_mesh(write_library(tmp_path / "a.sh3f", obj=model, properties=catalogue.encode()))
    on_side = np.abs(mesh.normals[:, 2]) < 0.5
    radial = (
        mesh.vertices[on_side, :2] / np.linalg.norm(mesh.vertices[on_side, :2], axis=1)[:, None]
    )
    assert (mesh.normals[on_side, :2] * radial).sum(1).min() > 0.99
    assert (np.abs(mesh.normals[~on_side, 2]) > 0.999).all()


@pytest.mark.parametrize(
    ("change", "is_thing"),
    [
        ("width#1=40", True),
        ("width#1=400", False),
        ("width#1=1\ndepth#1=1\nheight#1=1", False),
        ("movable#1=false", False),
        ("doorOrWindow#1=true", False),
        ("elevation#1=120", False),
        ("model#1=/models/crate.dae", False),
        ("model#1=/models/gone.obj", False),
        ("model#1=/models/winchesterSofa.obj", False),
    ],
)
def test_things_can_stand_about(tmp_path: Path, change: str, is_thing: bool) -> None:
    catalogue = (CATALOGUE + change).encode()
    library = SweetHomeLibrary(write_library(tmp_path / "a.sh3f", properties=catalogue))
    assert len(library.things()) == is_thing


def test_too_fine_models_are_left_out(library: Path) -> None:
    assert count_triangles(CRATE) == 12
    assert len(SweetHomeLibrary(library).things(max_triangles=12)) == 1
    assert SweetHomeLibrary(library).things(max_triangles=11) == ()


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


@pytest.mark.skipif(not DEBIANS.exists(), reason="Debian's sweethome3d-furniture is not there")
def test_debians_cc0_library_gives_things() -> None:
    library = SweetHomeLibrary(DEBIANS)
    assert len(library.entries) == 173
    things = library.things()
    assert len(things) >= 75
    for entry in things[::8]:
        low, high = library.mesh(entry).bounds
        np.testing.assert_allclose(low[2], 0, atol=1e-5)
        np.testing.assert_allclose(high - low, entry.size, atol=1e-4)


def test_missing_materials_and_pictures_are_plain(tmp_path: Path) -> None:
    mesh = only_mesh(write_library(tmp_path / "a.sh3f", mtl=None, png=None))
    assert {material.texture.shape for material in mesh.materials} == {(1, 1, 3)}


def test_image_size_is_what_opencv_decodes() -> None:
    image = np.zeros((7, 11, 3), np.uint8)
    for ending in (".png", ".jpg"):
        assert image_size(cv2.imencode(ending, image)[1].tobytes()) == (11, 7)


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
