"""Pieces of furniture, each by itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from curiosight.rooms.furniture import (
    Furniture,
    Placed,
    kitchen,
    soft,
    storage,
    tables,
)
from curiosight.rooms.scene import Role

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
    own, contents = Placed(shelf, np.eye(4)).parts(Role.SUPPORT)
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
