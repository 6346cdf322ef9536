"""A room's walls and openings, and where its furniture stands."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from scipy import ndimage

from curiosight.frame import is_rigid
from curiosight.rooms.furniture import (
    Placed,
    furnish,
)
from curiosight.rooms.mesh import Mesh, join
from curiosight.rooms.plan import FloorPlan, draw_plan
from curiosight.rooms.scene import Part, Role
from curiosight.rooms.shell import Shell, draw_shell

SEEDS = range(5)
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
        return [part for placed in self.furniture for part in placed.parts(Role.SUPPORT)]

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


def boxes(room: Drawn) -> list[tuple[Points, Points]]:
    """Return the corners, seen from above, of the box around each piece of furniture."""
    meshes = [placed.parts(Role.SUPPORT)[0].mesh for placed in room.furniture]
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
