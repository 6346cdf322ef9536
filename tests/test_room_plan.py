"""A room's outline."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.frame import is_rigid
from curiosight.rooms.plan import FloorPlan, draw_plan

SQUARE = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], float)
L_SHAPE = np.array([(0, 0), (6, 0), (6, 2), (3, 2), (3, 5), (0, 5)], float)
Points = npt.NDArray[np.float64]


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
