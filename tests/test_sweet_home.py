"""Furniture libraries: what is in them arrives upright and in metres."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from curiosight.rooms import RoomSettings, room
from curiosight.rooms.sweet_home import SweetHomeLibrary
from curiosight.rooms.sweet_home.materials import image_size
from curiosight.rooms.sweet_home.wavefront import (
    count_triangles,
)
from furniture_library import (
    CATALOGUE,
    CRATE,
    GREEN,
    RED,
    face_colour,
    only_mesh,
    write_library,
)

DEBIANS = Path("/usr/share/sweethome3d/furniture/BlendSwap-CC-0.sh3f")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return write_library(tmp_path / "tiny.sh3f")


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


def test_a_librarys_things_stand_in_a_room(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "KINDS", ())
    things = room.draw_room(RoomSettings(seed=5, furniture=library)).things
    assert len(things) > 5
    for thing in things:
        assert thing.kind.name == "Wooden \u201ccrate\u201d"
        assert thing.is_on_floor  # half a metre across
        np.testing.assert_allclose(np.ptp(thing.mesh.vertices, axis=0), (0.4, 0.3, 0.2), atol=1e-4)


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
