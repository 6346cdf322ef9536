"""The kinds of things, and the shapes that they are put together from."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.round_shapes import cylinder, ellipsoid, lathe, ring, tube
from curiosight.rooms.shapes import box, disc, extrude, panel, rounded_box
from curiosight.rooms.surfaces import arc, scaled, sheet, turned, warped
from curiosight.rooms.things import KINDS, Kind

GREY = Material(np.full((2, 2, 3), 128, np.uint8))
SEEDS = (1, 2, 3)

kinds = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)


@cache
def drawn(kind: Kind, seed: int) -> Mesh:
    return kind.draw(np.random.default_rng(seed))


def face_normals(mesh: Mesh) -> npt.NDArray[np.float64]:
    """Return (T, 3) normals of the triangles as they are wound, twice as long as their area."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(float) for corner in range(3))
    return np.cross(b - a, c - a)


def area(mesh: Mesh) -> float:
    return float(np.linalg.norm(face_normals(mesh), axis=1).sum() / 2)


def volume(mesh: Mesh) -> float:
    """Return what the surface encloses, by the divergence theorem; negative if inside out."""
    centres = mesh.vertices[mesh.triangles].astype(float).mean(1)
    return float((centres * face_normals(mesh)).sum() / 6)


def share_of_normals_outwards(mesh: Mesh) -> float:
    wound = face_normals(mesh)
    agreement = (mesh.normals[mesh.triangles] * wound[:, None]).sum(-1)
    return float(np.mean(agreement > 0))


def content(mesh: Mesh) -> bytes:
    arrays = (mesh.vertices, mesh.normals, mesh.uv, mesh.triangles, mesh.surface)
    textures = [material.texture for material in mesh.materials]
    return b"".join(array.tobytes() for array in (*arrays, *textures))


def regular_area(n: int, radius: float) -> float:
    return n / 2 * np.sin(2 * np.pi / n) * radius**2


def test_there_are_many_kinds_and_each_has_its_own_name() -> None:
    assert len(KINDS) >= 36
    assert len({kind.name for kind in KINDS}) == len(KINDS)
    assert all(kind.places and kind.places <= {"table", "floor"} for kind in KINDS)
    for place in ("table", "floor"):
        assert sum(place in kind.places for kind in KINDS) >= 15


@kinds
def test_stands_on_the_ground_centred_within_the_papers_sizes(kind: Kind) -> None:
    for seed in SEEDS:
        low, high = drawn(kind, seed).bounds
        assert abs(low[2]) < 1e-4
        assert np.abs(low + high)[:2].max() < 1e-4
        # What stands on a table shall neither hide the room nor need the table for itself.
        limit = 0.85 if "table" in kind.places else 1.45
        assert 0.10 <= np.linalg.norm(high - low) <= limit
        assert (high - low).max() >= 0.09


@kinds
def test_surface_is_sound(kind: Kind) -> None:
    for seed in SEEDS:
        mesh = drawn(kind, seed)
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-4)
        assert share_of_normals_outwards(mesh) > 0.99
        assert (np.linalg.norm(face_normals(mesh), axis=1) > 1e-10).mean() > 0.99
        assert mesh.triangles.min() >= 0
        assert mesh.triangles.max() < len(mesh.vertices)
        assert set(mesh.surface) == set(range(len(mesh.materials)))


@kinds
def test_is_drawn_by_the_seed_alone(kind: Kind) -> None:
    first, other = drawn(kind, SEEDS[0]), drawn(kind, SEEDS[1])
    assert content(kind.draw(np.random.default_rng(SEEDS[0]))) == content(first)
    assert content(other) != content(first)
    assert not np.isclose(first.diagonal, other.diagonal, rtol=1e-4)


def test_a_room_of_things_is_light() -> None:
    counts = [len(drawn(kind, seed).triangles) for kind in KINDS for seed in SEEDS]
    assert max(counts) <= 4000
    assert np.mean(counts) <= 1550


def test_about_a_fifth_is_hard_to_see_for_a_depth_sensor() -> None:
    shares = []
    for kind in KINDS:
        mesh = drawn(kind, 1)
        is_dark = np.array([material.infrared < 0.35 for material in mesh.materials])
        areas = np.linalg.norm(face_normals(mesh), axis=1)
        shares.append(areas[is_dark[mesh.surface]].sum() / areas.sum())
    assert 0.08 < np.mean(np.array(shares) > 0.4) < 0.35


def test_panel_looks_to_along_cross_across_and_pictures_stand_upright_on_it() -> None:
    wall = panel((1, 2, 0.5), (2, 0, 0), (0, 0, 1.5), GREY, spacing=0.25)
    assert area(wall) == pytest.approx(3.0)
    np.testing.assert_allclose(wall.normals, np.broadcast_to([0, -1, 0], wall.normals.shape))
    assert share_of_normals_outwards(wall) == 1
    # uv in metres: u from the left, v from the top.
    np.testing.assert_allclose(wall.uv[:, 0], wall.vertices[:, 0] - 1, atol=1e-6)
    np.testing.assert_allclose(wall.uv[:, 1], 2 - wall.vertices[:, 2], atol=1e-6)
    with pytest.raises(ValueError, match="along, across: expected two directions"):
        panel((0, 0, 0), (1, 0, 0), (2, 0, 0), GREY)
    fitted = panel((0, 0, 0), (2, 0, 0), (0, 0, 1.5), GREY, fit=True)
    assert fitted.uv.min() == 0
    assert fitted.uv.max() == 1


def test_box_is_exact_and_stands_where_it_is_lifted() -> None:
    crate = box((0.4, 0.3, 0.2), GREY, lift=0.7)
    assert volume(crate) == pytest.approx(0.4 * 0.3 * 0.2, rel=1e-5)
    assert area(crate) == pytest.approx(2 * (0.12 + 0.08 + 0.06), rel=1e-5)
    np.testing.assert_allclose(crate.bounds, [(-0.2, -0.15, 0.7), (0.2, 0.15, 0.9)], atol=1e-6)
    assert share_of_normals_outwards(crate) == 1


def test_spacing_bounds_the_distance_of_vertices() -> None:
    fine = box((0.4, 0.3, 0.2), GREY, spacing=0.05)
    edges = np.diff(fine.vertices[fine.triangles][:, [0, 1, 2, 0]], axis=1)
    assert np.linalg.norm(edges, axis=-1).max() <= 0.05 * 2**0.5 + 1e-6


def test_rounded_box_loses_its_corners_only() -> None:
    size, radius = (1.0, 0.6, 0.4), 0.1
    inner = np.array(size) - 2 * radius
    # Steiner: the core grown by the radius on all sides.
    faces = 2 * (inner[0] * inner[1] + inner[1] * inner[2] + inner[2] * inner[0])
    exact = inner.prod() + faces * radius + np.pi * inner.sum() * radius**2
    exact += 4 / 3 * np.pi * radius**3
    assert volume(rounded_box(size, radius, GREY, n_bevel=8)) == pytest.approx(exact, rel=1e-3)
    with pytest.raises(ValueError, match="radius: expected"):
        rounded_box(size, 0.25, GREY)


def test_lathe_turns_a_profile_into_an_exact_prism() -> None:
    n, radius, height = 24, 0.3, 0.5
    profile = [(0, 0), (radius, 0), (radius, height), (0, height)]
    body = lathe(profile, GREY, n_around=n)
    base = regular_area(n, radius)
    assert volume(body) == pytest.approx(base * height, rel=1e-5)
    sides = n * 2 * radius * np.sin(np.pi / n) * height
    assert area(body) == pytest.approx(2 * base + sides, rel=1e-5)
    # Its edges are creases: every normal is level or upright.
    assert np.isin(np.abs(body.normals[:, 2]).round(5), (0, 1)).all()
    with pytest.raises(ValueError, match="profile: expected"):
        lathe([(-0.1, 0), (0.1, 1)], GREY)
    assert volume(cylinder(radius, height, GREY, n_around=n)) == pytest.approx(volume(body))


def test_lathe_runs_its_texture_around_once_and_down() -> None:
    side = lathe([(0.1, 0.0), (0.1, 0.4)], GREY, n_around=8)
    np.testing.assert_allclose(side.uv[:, 1], 1 - side.vertices[:, 2] / 0.4, atol=1e-6)
    angle = np.arctan2(side.vertices[:, 1], side.vertices[:, 0]) % (2 * np.pi)
    inside = (side.uv[:, 0] > 0) & (side.uv[:, 0] < 1)
    np.testing.assert_allclose(side.uv[inside, 0], angle[inside] / (2 * np.pi), atol=1e-6)


def test_ellipsoid_has_its_size_and_its_gradient_as_normals() -> None:
    radii = np.array([0.1, 0.2, 0.3])
    egg = ellipsoid((0.1, 0.2, 0.3), GREY, n_around=64, lift=0.5)
    assert volume(egg) == pytest.approx(4 / 3 * np.pi * radii.prod(), rel=5e-3)
    gradient = (egg.vertices - [0, 0, 0.8]) / radii**2
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    assert ((gradient * egg.normals).sum(1) > 0.99).all()


def test_tubes_and_rings_enclose_what_they_should() -> None:
    rod = tube([(0, 0, 0), (0.3, 0, 0.4), (0.6, 0, 0.8)], 0.05, GREY, n_around=12)
    assert volume(rod) == pytest.approx(regular_area(12, 0.05), rel=1e-5)
    # A straight rod has vertices on the way: light is worked out there.
    heights = np.unique(tube([(0, 0, 0), (0, 0, 1)], 0.05, GREY, spacing=0.25).vertices[:, 2])
    np.testing.assert_allclose(heights, [0, 0.25, 0.5, 0.75, 1], atol=1e-6)
    hoop = ring(0.5, 0.05, GREY, n_around=96, n_rod=12)
    assert volume(hoop) == pytest.approx(regular_area(12, 0.05) * np.pi, rel=1e-2)
    assert share_of_normals_outwards(hoop) == 1


def test_extrude_fills_an_outline_that_is_not_convex() -> None:
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
    bracket = extrude(outline, 0.5, GREY, lift=1.0)
    assert volume(bracket) == pytest.approx(4 * 0.5, rel=1e-5)
    assert area(bracket) == pytest.approx(2 * 4 + 10 * 0.5, rel=1e-5)
    with pytest.raises(ValueError, match="outline: expected corners counter-clockwise"):
        extrude(outline[::-1], 0.5, GREY)


def test_disc_looks_up() -> None:
    lid = disc(0.2, GREY, n_around=32, lift=0.1, fit=True)
    assert area(lid) == pytest.approx(regular_area(32, 0.2), rel=1e-5)
    assert (lid.normals[:, 2] == 1).all()
    assert lid.uv.min() == pytest.approx(0, abs=1e-6)


def test_sheet_looks_to_the_side_of_rows_going_up() -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2, 4))
    flag = sheet(np.stack([u, 0 * u, v], -1), GREY)
    np.testing.assert_allclose(flag.normals, np.broadcast_to([0, -1, 0], flag.normals.shape))
    assert area(flag) == pytest.approx(2)


def test_warps_carry_normals_and_notice_a_mirror() -> None:
    ball = ellipsoid((1, 1, 1), GREY, n_around=48)
    squashed = scaled(ball, (1, 2, 0.5))
    assert volume(squashed) == pytest.approx(volume(ball), rel=1e-3)
    assert share_of_normals_outwards(squashed) == 1
    mirrored = warped(ball, lambda points: points * [-1, 1, 1])
    assert volume(mirrored) == pytest.approx(volume(ball), rel=1e-5)
    assert share_of_normals_outwards(mirrored) == 1


def test_turned_is_a_rigid_motion() -> None:
    pose = turned((0, 0, 2), np.pi / 2, (1, 2, 3))
    np.testing.assert_allclose(pose @ [1, 0, 0, 1], [1, 3, 3, 1], atol=1e-12)


def test_arc_goes_from_angle_to_angle() -> None:
    bow = arc(0, np.pi / 2, (2, 1), (1, 5), 3)
    np.testing.assert_allclose(bow[[0, -1]], [(3, 0, 5), (1, 0, 6)], atol=1e-12)
