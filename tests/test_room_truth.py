"""The truth of a drawn room's pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from curiosight.rooms.arrangement import Thing
from curiosight.rooms.furniture import Furniture, Placed, soft, storage, tables
from curiosight.rooms.mesh import Material, Mesh, standing
from curiosight.rooms.scene import Part, Role
from curiosight.rooms.settings import SceneName
from curiosight.rooms.things import KINDS
from curiosight.rooms.truth import (
    across,
    draw_truth,
    role_of_furniture,
    role_of_thing,
)

Draw = Callable[[np.random.Generator], Furniture]

PLAIN = Material(np.zeros((1, 1, 3), np.uint8))


def part(role: Role, size: float = 0.3) -> Part:
    """Return a part that is `size` metres across."""
    vertices = np.array([[0, 0, 0], [size, 0, 0], [size, 0, 0]], np.float32)
    up = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    triangles, surface = np.array([[0, 1, 2]], np.int32), np.zeros(1, np.int32)
    return Part("part", role, Mesh(vertices, up, vertices[:, :2], triangles, surface, (PLAIN,)))


PARTS = (
    part(Role.STRUCTURE, 5.0),
    part(Role.SUPPORT),
    part(Role.OBJECT),
    part(Role.OBJECT),
    part(Role.UNDECIDED),
    part(Role.OBJECT, 0.07),
    part(Role.OBJECT, 1.6),
)
NOTHING, FLOOR, TABLE, MUG, BOWL, ON_SHELF, TINY, HUGE = range(len(PARTS) + 1)


@pytest.mark.parametrize(
    ("number", "grey"),
    [
        (NOTHING, 125),
        (FLOOR, 0),
        (TABLE, 0),
        (MUG, 255),
        (ON_SHELF, 125),
        (TINY, 125),
        (HUGE, 125),
    ],
)
def test_grey_of_a_part(number: int, grey: int) -> None:
    truth = draw_truth(np.full((4, 5), number, np.int32), PARTS)
    np.testing.assert_array_equal(truth, np.full((4, 5), grey, np.uint8))


def test_large_part_at_an_angle_is_measured_along_its_own_sides() -> None:
    corners = np.array([[0, 0, 0], [1.2, 0, 0], [1.2, 0.5, 0.4], [0, 0.5, 0.4]], np.float32)
    turned = corners @ Rotation.from_euler("z", 45, degrees=True).as_matrix().astype(np.float32)
    mesh = replace(part(Role.OBJECT).mesh, vertices=turned)
    assert mesh.diagonal > 1.5
    assert across(mesh) == pytest.approx(np.linalg.norm((1.2, 0.5, 0.4)))
    assert draw_truth(np.ones((1, 1), np.int32), (Part("cabinet", Role.OBJECT, mesh),)) == 255


def coffee_table(scene: SceneName, *things: Thing) -> tuple[Role, list[Role]]:
    """Return what a coffee table is, and what stands on it."""
    table = Placed(tables.coffee_table(np.random.default_rng(0)), standing(2.0, 1.0))
    roles = [role_of_thing(thing, scene) for thing in things]
    return role_of_furniture(table, things, scene), roles


def cup_at(x: float, y: float, z: float) -> Thing:
    kind = next(kind for kind in KINDS if kind.name == "mug")
    return Thing(kind, kind.draw(np.random.default_rng(0)), z == 0, standing(x, y, z))


def test_furniture_that_carries_nothing_is_an_object() -> None:
    height = tables.coffee_table(np.random.default_rng(0)).tops[0].height
    on_it, beside = cup_at(2.0, 1.0, height), cup_at(4.0, 1.0, 0.0)
    for scene in ("auto", "table"):
        assert coffee_table(scene) == (Role.OBJECT, [])
        assert coffee_table(scene, beside) == (Role.OBJECT, [Role.OBJECT])
        assert coffee_table(scene, on_it) == (Role.SUPPORT, [Role.OBJECT])
    assert coffee_table("floor", beside) == (Role.OBJECT, [Role.OBJECT])
    assert coffee_table("floor", on_it) == (Role.UNDECIDED, [Role.UNDECIDED])


@pytest.mark.parametrize("draw", [soft.sofa, soft.bed, storage.wardrobe, storage.shelf])
def test_furniture_larger_than_objects_or_full_is_none(draw: Draw) -> None:
    placed = Placed(draw(np.random.default_rng(0)), standing(2.0, 1.0))
    assert role_of_furniture(placed, (), "auto") is Role.SUPPORT
    assert role_of_furniture(placed, (), "floor") is Role.UNDECIDED


def test_sizes_are_arguments() -> None:
    ids = np.full((1, 1), TINY, np.int32)
    assert draw_truth(ids, PARTS, min_size=0.05) == 255
    assert draw_truth(ids, PARTS, min_size=0.05, max_size=0.06) == 125


@pytest.mark.parametrize("outline_px", [1, 2, 3])
def test_outlines_between_salient_and_not_are_ignored(outline_px: int) -> None:
    ids = np.full((9, 20), FLOOR, np.int32)
    ids[:, 10:] = MUG
    row = draw_truth(ids, PARTS, outline_px=outline_px)[4]
    n_clear = 10 - outline_px
    expected = [0] * n_clear + [125] * 2 * outline_px + [255] * n_clear
    np.testing.assert_array_equal(row, expected)


@pytest.mark.parametrize(("left", "right"), [(MUG, BOWL), (FLOOR, TABLE)])
def test_other_outlines_are_kept(left: int, right: int) -> None:
    ids = np.full((9, 20), left, np.int32)
    ids[:, 10:] = right
    assert len(np.unique(draw_truth(ids, PARTS))) == 1


def test_outline_beside_ignored_pixels_is_kept() -> None:
    ids = np.full((9, 20), ON_SHELF, np.int32)
    ids[:, 10:] = MUG
    np.testing.assert_array_equal(draw_truth(ids, PARTS)[4], [125] * 10 + [255] * 10)


@pytest.mark.parametrize("number", [-1, len(PARTS) + 1])
def test_unknown_ids_are_refused(number: int) -> None:
    with pytest.raises(ValueError, match=f"ids: expected 0 to 7.*{number}"):
        draw_truth(np.full((2, 2), number, np.int32), PARTS)
