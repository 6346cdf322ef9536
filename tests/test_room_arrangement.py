"""Things on tables and on the floor."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from curiosight.rooms.arrangement import (
    Arrangement,
    Surface,
    Thing,
    corners,
    draw_kinds,
    rearranged,
)
from curiosight.rooms.mesh import Material, Mesh, standing
from curiosight.rooms.plan import FloorPlan
from curiosight.rooms.scene import Role
from curiosight.rooms.shapes import box
from curiosight.rooms.things.kind import Kind

GREY = Material(np.full((2, 2, 3), 128, np.uint8))
OUTLINE = np.array([(0, 0), (6, 0), (6, 2), (3, 2), (3, 5), (0, 5)], float)
TABLE_BOX = (-0.6, -0.4, 0.6, 0.4)
TABLE = Surface(standing(1.5, 3.5, 0.75, 0.5), TABLE_BOX)
TABLE_FOOT = np.array([0.7, 2.8, 2.3, 4.2])


def small(rng: np.random.Generator) -> Mesh:
    return box(rng.uniform(0.08, 0.2, 3), GREY)


def large(rng: np.random.Generator) -> Mesh:
    return box(rng.uniform(0.3, 0.6, 3), GREY)


KINDS = (
    Kind("tin", small, frozenset({"table"})),
    Kind("mug", small, frozenset({"table", "floor"})),
    Kind("crate", large, frozenset({"floor"})),
)


def empty() -> Arrangement:
    return Arrangement(FloorPlan(OUTLINE, 2.5), [TABLE], [corners(TABLE_FOOT)])


def arranged(seed: int = 0) -> list[Thing]:
    arrangement = empty()
    arrangement.fill(KINDS, 8, np.random.default_rng(seed))
    return arrangement.things


@pytest.fixture(params=range(4))
def things(request: pytest.FixtureRequest) -> list[Thing]:
    return arranged(request.param)


def boxes_of(things: list[Thing]) -> list[tuple[np.ndarray, np.ndarray]]:
    return [thing.part().mesh.bounds for thing in things]


def test_things_stand_on_the_table_or_the_floor(things: list[Thing]) -> None:
    assert {thing.is_on_floor for thing in things} == {True, False}
    for thing, (low, _) in zip(things, boxes_of(things), strict=True):
        assert low[2] == pytest.approx(0.0 if thing.is_on_floor else 0.75, abs=1e-5)
        assert ("floor" if thing.is_on_floor else "table") in thing.kind.places
        assert thing.part().role is Role.OBJECT


def test_nothing_hangs_over_an_edge(things: list[Thing]) -> None:
    to_table = np.linalg.inv(TABLE.T_room_surface)
    for thing in things:
        vertices = thing.part().mesh.vertices
        if thing.is_on_floor:
            in_long_part = (vertices[:, 0] < 6) & (vertices[:, 1] < 2)
            in_wide_part = (vertices[:, 0] < 3) & (vertices[:, 1] < 5)
            assert (in_long_part | in_wide_part).all()
            assert (vertices[:, :2] > 0).all()
        else:
            on_table = vertices @ to_table[:3, :3].T + to_table[:3, 3]
            assert (on_table[:, :2] > TABLE_BOX[:2]).all()
            assert (on_table[:, :2] < TABLE_BOX[2:]).all()


def test_nothing_touches_another(things: list[Thing]) -> None:
    on_floor = [thing for thing in things if thing.is_on_floor]
    footprints = [thing.footprint() for thing in on_floor] + [corners(TABLE_FOOT)]
    for a, b in combinations(footprints, 2):
        gaps = np.maximum(b.min(0) - a.max(0), a.min(0) - b.max(0))
        assert gaps.max() >= 0.12
    on_table = [thing for thing in things if not thing.is_on_floor]
    for one, other in combinations(on_table, 2):
        a, b = (thing.part().mesh.vertices[:, :2] for thing in (one, other))
        distances = np.linalg.norm(a[:, None] - b[None], axis=2)
        assert distances.min() > 0.0


def test_the_same_chance_gives_the_same_places() -> None:
    once, again, other = arranged(1), arranged(1), arranged(2)
    assert [thing.T_room_thing.tobytes() for thing in once] == [
        thing.T_room_thing.tobytes() for thing in again
    ]
    assert [thing.T_room_thing.tobytes() for thing in once] != [
        thing.T_room_thing.tobytes() for thing in other
    ]


def test_rearranging_moves_leaves_out_and_adds() -> None:
    before = arranged()
    after = rearranged(before, empty(), KINDS, np.random.default_rng(9))
    meshes_before = {id(thing.mesh): thing for thing in before}
    stayed = [thing for thing in after if id(thing.mesh) in meshes_before]
    assert 0 < len(stayed) < len(before)
    assert len(stayed) < len(after)
    for thing in stayed:
        old = meshes_before[id(thing.mesh)]
        assert thing.is_on_floor == old.is_on_floor
        assert np.linalg.norm(thing.T_room_thing[:2, 3] - old.T_room_thing[:2, 3]) > 0.01


def test_where_nothing_fits_nothing_is_put() -> None:
    closet = Arrangement(FloorPlan(corners(np.array([0, 0, 0.4, 0.4])), 2.5), [], [])
    closet.fill(KINDS, 5, np.random.default_rng(0))
    assert closet.things == []


def test_every_kind_comes_before_any_comes_again() -> None:
    drawn = [kind.name for kind in draw_kinds(KINDS, 7, np.random.default_rng(0))]
    assert sorted(drawn[:3]) == sorted(drawn[3:6]) == ["crate", "mug", "tin"]
    assert list(draw_kinds((), 3, np.random.default_rng(0))) == []
