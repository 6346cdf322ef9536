"""A room's plan, its walls and openings, its furniture and where that stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt
import pytest
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from curiosight.frame import is_rigid
from curiosight.worlds.rooms.furniture import (
    Furniture,
    Placed,
    furnish,
    kitchen,
    soft,
    storage,
    tables,
)
from curiosight.worlds.rooms.mesh import Mesh, join
from curiosight.worlds.rooms.plan import FloorPlan, draw_plan
from curiosight.worlds.rooms.scene import Part, Role
from curiosight.worlds.rooms.shell import Shell, draw_shell

SQUARE = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], float)
L_SHAPE = np.array([(0, 0), (6, 0), (6, 2), (3, 2), (3, 5), (0, 5)], float)
SEEDS = range(5)
# Draws of each kind of furniture, and the heights between which its highest top lies.
KINDS: dict[Callable[[np.random.Generator], Furniture], tuple[float, float] | None] = {
    tables.table: (0.72, 0.76),
    tables.coffee_table: (0.40, 0.50),
    tables.desk: (0.72, 0.76),
    storage.sideboard: (0.70, 0.95),
    storage.tv_board: (0.40, 0.52),
    kitchen.kitchen_counter: (0.90, 0.90),
    storage.shelf: None,
    storage.wardrobe: None,
    soft.sofa: None,
    soft.armchair: None,
    soft.bed: None,
}
# Handles, and a worktop's tap, may stick out of the size that counts on the floor.
HANDLE = 0.035

Points = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Drawn:
    """A room of a seed."""

    plan: FloorPlan
    shell: Shell
    furniture: tuple[Placed, ...]

    @property
    def furniture_parts(self) -> list[Part]:
        return [part for placed in self.furniture for part in placed.parts()]

    @property
    def parts(self) -> list[Part]:
        return [*self.shell.parts, *self.furniture_parts]


def draw(seed: int) -> Drawn:
    rng = np.random.default_rng(seed)
    plan = draw_plan(rng)
    shell = draw_shell(plan, rng)
    return Drawn(plan, shell, furnish(plan, shell, rng))


@pytest.fixture(scope="module", params=SEEDS)
def room(request: pytest.FixtureRequest) -> Drawn:
    return draw(request.param)


def same_bytes(one: Mesh, other: Mesh) -> bool:
    arrays = ("vertices", "normals", "uv", "triangles", "surface")
    return all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in arrays
    ) and all(
        a.texture.tobytes() == b.texture.tobytes()
        for a, b in zip(one.materials, other.materials, strict=True)
    )


# The plan


@given(st.integers(0, 10_000), st.sampled_from(["rect", "l"]))
@settings(max_examples=60, deadline=None)
def test_drawn_plan_has_a_rooms_size(seed: int, shape: str) -> None:
    plan = draw_plan(np.random.default_rng(seed), shape)  # type: ignore[arg-type]
    x_min, y_min, x_max, y_max = plan.bounds
    assert (x_min, y_min) == (0, 0)
    assert 2.4 <= plan.height <= 2.8
    if shape == "rect":
        assert len(plan.outline) == 4
        assert 5.5 <= x_max <= 8
        assert 4.2 <= y_max <= 6
        assert plan.area == pytest.approx(x_max * y_max)
    else:
        assert len(plan.outline) == 6
        assert x_max <= 9
        assert 0.7 * x_max * y_max < plan.area < 0.9 * x_max * y_max
    rectangles = np.array(plan.rectangles)
    areas = (rectangles[:, 2:] - rectangles[:, :2]).prod(1)
    assert areas.sum() == pytest.approx(plan.area)


def test_both_shapes_are_drawn_where_none_is_asked_for() -> None:
    corners = {len(draw_plan(np.random.default_rng(seed)).outline) for seed in range(20)}
    assert corners == {4, 6}


def test_any_corner_of_an_l_may_be_missing() -> None:
    missing = set()
    for seed in range(40):
        plan = draw_plan(np.random.default_rng(seed), "l")
        x, y = plan.bounds[2:]
        corners = np.array([(0.01, 0.01), (x - 0.01, 0.01), (0.01, y - 0.01), (x - 0.01, y - 0.01)])
        missing.add(int(np.flatnonzero(~plan.contains(corners))[0]))
    assert missing == {0, 1, 2, 3}


def test_plan_contains_what_lies_inside() -> None:
    plan = FloorPlan(L_SHAPE, 2.5)
    places = np.array([(1, 1), (5, 1), (1, 4), (5, 4), (-1, 1), (3, 2), (7, 1)], float)
    assert plan.contains(places).tolist() == [True, True, True, False, False, True, False]


def test_wall_distance_is_that_to_the_nearest_point_of_a_wall() -> None:
    plan = FloorPlan(L_SHAPE, 2.5)
    ends = np.roll(L_SHAPE, -1, axis=0)
    steps = np.linspace(0, 1, 2001)[:, None, None]
    on_walls = (L_SHAPE + steps * (ends - L_SHAPE)).reshape(-1, 2)
    places = np.random.default_rng(0).uniform(-1, 7, (50, 2))
    expected = np.linalg.norm(places[:, None] - on_walls, axis=2).min(1)
    np.testing.assert_allclose(plan.wall_distance(places), expected, atol=2e-3)


def test_walls_look_into_the_room_and_follow_each_other() -> None:
    plan = FloorPlan(L_SHAPE, 2.5)
    for wall, following in pairwise((*plan.walls, plan.walls[0])):
        assert is_rigid(wall.T_room_wall)
        np.testing.assert_allclose(wall.ends[0], following.ends[1], atol=1e-12)
        middle = np.array([(wall.length / 2, y, 1, 1) for y in (-0.1, 0.1)])
        inside, outside = (middle @ wall.T_room_wall.T)[:, :2]
        assert plan.contains(inside)
        assert not plan.contains(outside)


@pytest.mark.parametrize(
    ("outline", "message"),
    [
        (SQUARE[:3], "K at least 4"),
        (SQUARE[::-1], "counter-clockwise"),
        (SQUARE + np.array([(0, 0), (0, 1), (0, 0), (0, 0)]), "slanting"),
        (np.zeros((4, 3)), "K, 2"),
    ],
)
def test_impossible_outline_is_refused(outline: Points, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        FloorPlan(outline, 2.5)


def test_unknown_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="shape: expected rect or l, got round"):
        draw_plan(np.random.default_rng(0), "round")  # type: ignore[arg-type]


# The shell


def test_shell_is_closed(room: Drawn) -> None:
    mesh = join([part.mesh for part in room.shell.parts])
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices, mesh.triangles)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3)).astype(np.float32)
    for x_min, y_min, x_max, y_max in room.plan.rectangles:
        eye = np.array([(x_min + x_max) / 2, (y_min + y_max) / 2, 1.0], np.float32)
        hits = scene.run(np.broadcast_to(eye, directions.shape), directions, output=1)
        assert (hits["geomID"] >= 0).all()


def test_surfaces_look_into_the_room(room: Drawn) -> None:
    for part in room.shell.parts:
        if part.name in {"floor", "ceiling"}:
            up = part.mesh.normals[:, 2]
            assert (up == (1 if part.name == "floor" else -1)).all()
        if part.name == "wall":
            away = part.mesh.vertices - 0.01 * part.mesh.normals
            assert not room.plan.contains(away[:, :2]).all()
            towards = part.mesh.vertices + 0.01 * part.mesh.normals
            assert room.plan.contains(towards[:, :2].mean(0))


def test_shell_has_what_a_room_has(room: Drawn) -> None:
    names = [part.name for part in room.shell.parts]
    assert {"floor", "ceiling", "wall", "door", "window", "skirting", "ceiling lamp"} <= set(names)
    assert sum(name in {"poster", "notice board", "clock", "outlet"} for name in names) >= 4
    assert all(part.role is Role.STRUCTURE for part in room.shell.parts)
    kinds = [opening.kind for opening in room.shell.openings]
    assert kinds.count("door") == names.count("door") == len(room.shell.kept_free)
    assert kinds.count("window") == names.count("window")


def test_openings_lie_in_their_walls_without_touching(room: Drawn) -> None:
    for opening in room.shell.openings:
        assert 0 < opening.left < opening.right < opening.wall.length
        assert 0 <= opening.bottom < opening.top < room.plan.height
    for one, other in combinations(room.shell.openings, 2):
        assert one.wall is not other.wall or one.right < other.left or other.right < one.left


def test_lights_are_in_the_room_and_shine_into_it(room: Drawn) -> None:
    windows = sum(opening.kind == "window" for opening in room.shell.openings)
    assert len(room.shell.lights) > windows
    for light in room.shell.lights:
        direction = np.cross(light.along, light.across)
        direction /= np.linalg.norm(direction)
        ahead = light.centre + 0.4 * direction
        assert room.plan.contains(ahead[:2])
        assert 0 < ahead[2] < room.plan.height
        assert (light.rgb > 0).all()


def test_no_depth_comes_through_a_window(room: Drawn) -> None:
    for part in room.shell.parts:
        if part.name == "window":
            (view,) = [material for material in part.mesh.materials if material.emission > 0]
            assert view.infrared == 0


# Furniture


@pytest.fixture(scope="module", params=KINDS, ids=lambda draw: draw.__name__)
def kind(request: pytest.FixtureRequest) -> Callable[[np.random.Generator], Furniture]:
    draw_kind: Callable[[np.random.Generator], Furniture] = request.param
    return draw_kind


def test_furniture_stands_on_the_floor_and_fills_its_size(
    kind: Callable[[np.random.Generator], Furniture],
) -> None:
    for seed in range(6):
        piece = kind(np.random.default_rng(seed))
        low, high = piece.mesh.bounds
        width, depth, height = piece.size
        assert low[2] == pytest.approx(0, abs=1e-6)
        assert high[2] == pytest.approx(height, abs=0.02) or piece.name == "bed"
        for axis, length in enumerate((width, depth)):
            assert high[axis] <= length / 2 + 1e-6
            assert -length / 2 - HANDLE <= low[axis] <= -length / 2 + 0.02


def test_tops_lie_on_the_mesh_with_room_above(
    kind: Callable[[np.random.Generator], Furniture],
) -> None:
    heights = KINDS[kind]
    for seed in range(6):
        piece = kind(np.random.default_rng(seed))
        assert bool(piece.tops) == (heights is not None)
        points = piece.mesh.vertices.astype(float)
        for top in piece.tops:
            x_min, y_min, x_max, y_max = top.area
            assert x_max - x_min > 0.2
            assert y_max - y_min > 0.2
            inside = (points[:, :2] > (x_min, y_min)) & (points[:, :2] < (x_max, y_max))
            above = points[inside.all(1), 2]
            assert np.abs(above - top.height).min() < 1e-6
            assert not ((above > top.height + 1e-6) & (above < top.height + 0.45)).any()
            assert heights is not None
            assert heights[0] - 1e-9 <= top.height <= heights[1] + 1e-9


def test_shelf_holds_what_is_undecided() -> None:
    shelf = storage.shelf(np.random.default_rng(0))
    assert shelf.contents is not None
    low, high = shelf.contents.bounds
    assert (high - low <= np.array(shelf.size) + 1e-6).all()
    own, contents = Placed(shelf, np.eye(4)).parts()
    assert (own.name, own.role) == ("shelf", Role.SUPPORT)
    assert (contents.name, contents.role) == ("shelf contents", Role.UNDECIDED)


def test_placed_furniture_takes_its_tops_and_footprint_along() -> None:
    table = tables.table(np.random.default_rng(0))
    pose = np.array([(0, -1, 0, 3), (1, 0, 0, 2), (0, 0, 1, 0), (0, 0, 0, 1)], float)
    placed = Placed(table, pose)
    width, depth, height = table.size
    low, high = placed.footprint.min(0), placed.footprint.max(0)
    np.testing.assert_allclose(high - low, (depth, width))
    np.testing.assert_allclose((high + low) / 2, (3, 2))
    ((T_room_top, area),) = placed.tops
    assert area == table.tops[0].area
    np.testing.assert_allclose(T_room_top[:3, 3], (3, 2, height))


# A furnished room


def boxes(room: Drawn) -> list[tuple[Points, Points]]:
    """Return the corners, seen from above, of the box around each piece of furniture."""
    meshes = [placed.parts()[0].mesh for placed in room.furniture]
    return [(low[:2], high[:2]) for low, high in (mesh.bounds for mesh in meshes)]


def test_furniture_stands_inside_without_touching(room: Drawn) -> None:
    for low, high in boxes(room):
        x, y = np.meshgrid(np.linspace(low[0], high[0], 20), np.linspace(low[1], high[1], 20))
        assert room.plan.contains(np.stack((x, y), -1)).all()
    for (low, high), (other_low, other_high) in combinations(boxes(room), 2):
        assert (low > other_high).any() or (other_low > high).any()


def test_doors_and_windows_stay_clear(room: Drawn) -> None:
    before_doors = [np.array(area).reshape(2, 2) for area in room.shell.kept_free]
    windows = [opening for opening in room.shell.openings if opening.kind == "window"]
    for placed, (low, high) in zip(room.furniture, boxes(room), strict=True):
        before_glass = [
            np.array(window.front(0.3)).reshape(2, 2)
            for window in windows
            if placed.furniture.size[2] > window.bottom
        ]
        for area in (*before_doors, *before_glass):
            assert (low + HANDLE > area[1]).any() or (high - HANDLE < area[0]).any()


def test_a_robot_can_go_everywhere(room: Drawn) -> None:
    x_min, y_min, x_max, y_max = room.plan.bounds
    places = np.stack(np.meshgrid(np.arange(x_min, x_max, 0.05), np.arange(y_min, y_max, 0.05)), -1)
    clearance = room.plan.wall_distance(places)
    is_covered = np.zeros(clearance.shape, bool)
    for placed in room.furniture:
        low, high = placed.footprint.min(0), placed.footprint.max(0)
        away = np.linalg.norm(places - np.clip(places, low, high), axis=-1)
        is_covered |= away == 0
        clearance = np.minimum(clearance, away)
    is_inside = room.plan.contains(places)
    _, n_pieces = ndimage.label(is_inside & (clearance > 0.35), np.ones((3, 3)))
    assert n_pieces == 1
    assert is_covered.sum() < 0.6 * is_inside.sum()


def test_room_has_places_for_things(room: Drawn) -> None:
    tops = [top for placed in room.furniture for top in placed.tops]
    assert len(tops) >= 2
    assert any(placed.furniture.name == "table" for placed in room.furniture)
    for T_room_top, _ in tops:
        assert is_rigid(T_room_top)
        assert 0.4 <= T_room_top[2, 3] <= 0.95
    roles = {part.role for part in room.furniture_parts}
    assert {Role.SUPPORT} <= roles <= {Role.SUPPORT, Role.UNDECIDED}


def test_room_is_made_of_a_bounded_number_of_triangles(room: Drawn) -> None:
    assert 15_000 < sum(len(part.mesh.triangles) for part in room.parts) < 80_000


def test_meshes_are_sound(room: Drawn) -> None:
    for part in room.parts:
        mesh = part.mesh
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-4)
        corners = mesh.vertices[mesh.triangles].astype(float)
        winding = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        agreement = np.einsum("ti,ti->t", winding, mesh.normals[mesh.triangles].sum(1))
        assert (agreement > 0).mean() > 0.99


def test_same_seed_draws_the_same_room() -> None:
    first, again, other = draw(3), draw(3), draw(4)
    assert [part.name for part in first.parts] == [part.name for part in again.parts]
    for one, two in zip(first.parts, again.parts, strict=True):
        assert same_bytes(one.mesh, two.mesh)
    assert not np.array_equal(first.plan.outline, other.plan.outline)
