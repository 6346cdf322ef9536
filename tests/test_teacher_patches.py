"""Sets of nodes, patches and their borders against plain references."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from curiosight.teacher.cloud.points import Points
from curiosight.teacher.things.groups import Groups
from curiosight.teacher.things.meetings import (
    CONCAVE,
    NEARER,
    SEEN,
    TOUCHING,
    Patches,
    _count_borders,
    _sum_patches,
    _walk,
)
from curiosight.teacher.things.patches import (
    CORE_PX,
    _core,
    _grow,
    _link,
    _number_known,
    _number_whole,
    find_patches,
    in_front,
)
from curiosight.teacher.things.touching import _join_small
from curiosight.teacher.things.union import join_linked, join_nodes, number_sets, root_of

Array = npt.NDArray[Any]
Cell = tuple[int, int]
SHAPE = (14, 18)
SIZE = SHAPE[0] * SHAPE[1]
REACH = 2
MIN_COSINE = float(np.cos(np.radians(7)))
SEEDS = st.integers(0, 10**6)
RIGHT_AND_BELOW = ((0, 1), (1, 0))


@dataclass(frozen=True)
class Surface:
    """A rough surface with holes, in things and patches.

    xyz, normals: (*SHAPE, 3). depth, tolerance: SHAPE. thing, patch: SHAPE, 0 = none.
    """

    xyz: Array
    normals: Array
    depth: Array
    tolerance: Array
    thing: Array
    patch: Array

    @property
    def rows(self) -> tuple[Array, Array]:
        """The (n, 3) points and normals as the kernels have them."""
        return self.xyz.reshape(-1, 3), self.normals.reshape(-1, 3)

    def in_front(self, one: Cell, other: Cell) -> float:
        """Apply the definition of `in_front`."""
        way = self.xyz[other] - self.xyz[one]
        return float(np.fmax(way @ self.normals[one], -way @ self.normals[other]))


def some_surface(seed: int) -> Surface:
    rng = np.random.default_rng(seed)
    row, column = np.mgrid[: SHAPE[0], : SHAPE[1]]
    # Steps of some centimetres, and noise of some millimetres.
    step = 0.05 * rng.integers(0, 2, (3, 3)).repeat(5, axis=0).repeat(6, axis=1)[: SHAPE[0]]
    depth = 1 + step + rng.normal(0, 0.002, SHAPE)
    depth[rng.random(SHAPE) < 0.05] = np.nan
    xyz = np.dstack([0.004 * column, 0.004 * row, np.ones(SHAPE)]) * depth[..., None]
    normals = rng.normal(0, 0.06, (*SHAPE, 3)) - [0, 0, 1]
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals[rng.random(SHAPE) < 0.15] = np.nan
    thing = rng.integers(0, 3, (2, 3)).repeat(7, axis=0).repeat(6, axis=1)
    patch = np.where(rng.random(SHAPE) < 0.1, rng.integers(1, 5, SHAPE), 0) * (thing > 0)
    tolerance = rng.uniform(0.004, 0.012, SHAPE)
    return Surface(xyz, normals, depth, tolerance, thing.astype(np.int32), patch.astype(np.int32))


def inside(cell: Cell) -> bool:
    return 0 <= cell[0] < SHAPE[0] and 0 <= cell[1] < SHAPE[1]


def flat(cell: Cell) -> int:
    return cell[0] * SHAPE[1] + cell[1]


def neighbours() -> list[tuple[Cell, Cell, Cell]]:
    """Return every cell, one to its right or below, and the direction from one to the other."""
    pairs = [
        ((v, u), (v + dv, u + du), (dv, du))
        for v, u, (dv, du) in product(range(SHAPE[0]), range(SHAPE[1]), RIGHT_AND_BELOW)
    ]
    return [pair for pair in pairs if inside(pair[1])]


def components(links: Array) -> Array:
    return np.asarray(connected_components(links, directed=False)[1])


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(1, 40), st.floats(0, 0.1))
def test_joined_sets_are_the_components_of_the_graph(seed: int, n: int, density: float) -> None:
    links = np.random.default_rng(seed).random((n, n)) < density
    parent = np.arange(n)
    join_linked(links, parent)
    # SciPy numbers components in the order of their first nodes, too.
    np.testing.assert_array_equal(number_sets(parent), components(links))


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(1, 60))
def test_nodes_have_one_root_where_they_were_joined(seed: int, n: int) -> None:
    joins = np.random.default_rng(seed).integers(0, n, (n // 2, 2))
    parent = np.arange(n)
    for one, other in joins:
        join_nodes(parent, one, other)
    number = components(coo_array((np.ones(len(joins)), joins.T), (n, n)))
    roots = [root_of(parent, node) for node in range(n)]
    are_one = np.equal.outer(roots, roots)
    np.testing.assert_array_equal(are_one, np.equal.outer(number, number))
    assert all(parent[root] == root for root in roots)


def links_by_definition(surface: Surface, where: set[Cell]) -> Array:
    """Return the (n, n) bool graph of `_link` from dot products, cell by cell."""
    links = np.zeros((SIZE, SIZE), np.bool_)
    for one, other, (dv, du) in neighbours():
        if one not in where or surface.thing[one] != surface.thing[other]:
            continue
        limit = surface.tolerance[one]
        cosine = surface.normals[one] @ surface.normals[other]
        goes_on = cosine > MIN_COSINE and surface.in_front(one, other) < limit
        before = (one[0] - REACH * dv, one[1] - REACH * du)
        beyond = (other[0] + REACH * dv, other[1] + REACH * du)
        if inside(before) and inside(beyond):
            are_in = surface.thing[before] == surface.thing[beyond] == surface.thing[one]
            goes_on &= not (are_in and surface.in_front(before, beyond) > limit)
        links[flat(one), flat(other)] = goes_on
    return links


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_links_join_what_goes_on_without_a_crease(seed: int) -> None:
    surface = some_surface(seed)
    cells = {(int(v), int(u)) for v, u in zip(*np.nonzero(surface.thing), strict=True)}
    parent = np.arange(SIZE)
    _link(surface.thing, *surface.rows, surface.tolerance, MIN_COSINE, REACH, parent)
    expected = components(links_by_definition(surface, cells))
    np.testing.assert_array_equal(number_sets(parent), expected)
    assert not len(cells) or expected.max() < SIZE - 1


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_in_front_is_the_height_over_a_tangent_plane(seed: int) -> None:
    surface = some_surface(seed)
    ends = np.random.default_rng(seed).integers(0, SIZE, (20, 2))
    for one, other in ends:
        found = in_front(*surface.rows, one, other)
        expected = surface.in_front(
            *((int(end) // SHAPE[1], int(end) % SHAPE[1]) for end in (one, other))
        )
        np.testing.assert_allclose(found, expected, atol=1e-12)
        np.testing.assert_array_equal(in_front(*surface.rows, other, one), found)


def test_in_front_asks_the_normal_that_is_known() -> None:
    xyz = np.array([[0.0, 0, 1], [0.1, 0, 0.9]])
    normals = np.array([[0.0, 0, -1], [np.nan, np.nan, np.nan]])
    for one, other in ((0, 1), (1, 0)):
        np.testing.assert_allclose(in_front(xyz, normals, one, other), 0.1)
    assert np.isnan(in_front(xyz, np.full((2, 3), np.nan), 0, 1))


def grown_by_queue(surface: Surface, slack: float) -> Array:
    """Flood from all the patches at once, first come first served."""
    patch = surface.patch.copy()
    waiting = deque((int(v), int(u)) for v, u in zip(*np.nonzero(patch), strict=True))
    while waiting:
        here = waiting.popleft()
        for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            there = (here[0] + dv, here[1] + du)
            if inside(there) and not patch[there] and surface.thing[there] == surface.thing[here]:
                step = abs(surface.depth[there] - surface.depth[here])
                if step <= slack * surface.tolerance[here]:
                    patch[there] = patch[here]
                    waiting.append(there)
    return patch


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.sampled_from([0.5, 2.0, np.inf]))
def test_patches_grow_like_a_flood(seed: int, slack: float) -> None:
    surface = some_surface(seed)
    patch, queue = surface.patch.copy(), np.empty((SIZE, 2), np.int32)
    _grow(surface.thing, surface.depth, surface.tolerance, slack, queue, patch)
    np.testing.assert_array_equal(patch, grown_by_queue(surface, slack))
    assert not patch[surface.thing == 0].any()


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_core_is_the_middle_of_squares_of_one_number(seed: int) -> None:
    rng = np.random.default_rng(seed)
    smooth = rng.integers(-1, 2, (2, 2)).repeat(7, axis=0).repeat(9, axis=1).astype(np.int32)
    smooth[rng.integers(0, SHAPE[0]), rng.integers(0, SHAPE[1])] = 5
    expected = np.zeros(SHAPE, np.bool_)
    half = 2
    for v, u in product(range(half, SHAPE[0] - half), range(half, SHAPE[1] - half)):
        square = smooth[v - half : v + half + 1, u - half : u + half + 1]
        expected[v, u] = smooth[v, u] >= 0 and (square == smooth[v, u]).all()
    np.testing.assert_array_equal(_core(smooth, half), expected)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_patches_are_sets_with_enough_points_and_a_core(seed: int) -> None:
    surface, rng = some_surface(seed), np.random.default_rng(seed)
    parent = np.arange(SIZE)
    for one, other in rng.integers(0, SIZE, (400, 2)):
        join_nodes(parent, one, other)
    is_known = (surface.thing > 0) & np.isfinite(surface.normals[..., 0])
    smooth = _number_known(surface.thing, surface.rows[1], parent)
    number = number_sets(parent).reshape(SHAPE)
    np.testing.assert_array_equal(smooth, np.where(is_known, number, -1))
    core, patch, n_whole = rng.random(SHAPE) < 0.05, np.zeros(SHAPE, np.int32), 0
    expected = patch.copy()
    for one in range(smooth.max() + 1):
        is_one = smooth == one
        if np.count_nonzero(is_one) >= 5 and core[is_one].any():
            n_whole += 1
            expected[is_one] = n_whole
    _number_whole(smooth, core, SIZE, 5, patch)
    np.testing.assert_array_equal(patch, expected)


def sums_by_patch(surface: Surface) -> Array:
    """Return what `_sum_patches` adds up, patch by patch."""
    sums = np.zeros((4, 10))
    for number in range(1, 5):
        is_in = surface.patch == number
        sums[number - 1, :2] = np.argwhere(is_in).sum(axis=0)
        sums[number - 1, 2:5] = surface.xyz[is_in].sum(axis=0)
        sums[number - 1, 5:8] = np.nansum(surface.normals[is_in], axis=0)
        for (v, u), (dv, du) in product(np.argwhere(is_in), RIGHT_AND_BELOW):
            there = (v + REACH * dv, u + REACH * du)
            if inside(there) and is_in[there]:
                way = surface.xyz[there] - surface.xyz[v, u]
                bend = (surface.normals[there] - surface.normals[v, u]) @ way / (way @ way)
                sums[number - 1, 8:] += 0 if np.isnan(bend) else (bend, 1)
    return sums


def large_patches(seed: int) -> Surface:
    """Return a surface whose patches fill the things' part of it."""
    surface = some_surface(seed)
    patch = np.random.default_rng(seed).integers(0, 5, (5, 6))
    large = patch.repeat(3, axis=0).repeat(3, axis=1)[: SHAPE[0]].astype(np.int32)
    readings = np.where(np.isnan(surface.depth), 0, large)
    return Surface(
        surface.xyz, surface.normals, surface.depth, surface.tolerance, surface.thing, readings
    )


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_patches_are_summed_up(seed: int) -> None:
    surface = large_patches(seed)
    sums = np.zeros((4, 10))
    _sum_patches(surface.patch, *surface.rows, REACH, sums)
    np.testing.assert_allclose(sums, sums_by_patch(surface), atol=1e-9)


def farthest_by_definition(surface: Surface, begin: Cell, way: Cell) -> Cell | None:
    """Apply the definition of `_walk`."""
    reached = [(begin[0] + step * way[0], begin[1] + step * way[1]) for step in range(REACH + 1)]
    fit = [
        cell
        for cell in reached
        if inside(cell)
        and surface.patch[cell] == surface.patch[begin]
        and np.isfinite(surface.normals[cell]).all()
    ]
    return fit[-1] if fit else None


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.sampled_from([(0, 1), (1, 0), (0, -1), (-1, 0)]))
def test_walk_ends_at_the_farthest_point_that_fits(seed: int, way: Cell) -> None:
    surface = large_patches(seed)
    for v, u in product(range(SHAPE[0]), range(SHAPE[1])):
        cell = farthest_by_definition(surface, (v, u), way)
        found = _walk(surface.patch, surface.rows[1], v, u, *way, REACH)
        assert found == (-1 if cell is None else flat(cell))


def borders_by_definition(surface: Surface) -> Array:
    """Count what `Patches.borders` says, pair by pair."""
    borders = np.zeros((4, 4, 4), np.int32)
    for one, other, (dv, du) in neighbours():
        first, second = surface.patch[one] - 1, surface.patch[other] - 1
        if first < 0 or second < 0 or first == second:
            continue
        ends = (
            farthest_by_definition(surface, one, (-dv, -du)),
            farthest_by_definition(surface, other, (dv, du)),
        )
        step = surface.depth[other] - surface.depth[one]
        for here, there, nearer in ((first, second, step), (second, first, -step)):
            borders[here, there, TOUCHING] += 1
            if ends[0] is not None and ends[1] is not None:
                borders[here, there, SEEN] += 1
                borders[here, there, CONCAVE] += surface.in_front(*ends) > surface.tolerance[one]
                borders[here, there, NEARER] += nearer > 0.01
    return borders


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_borders_are_counted(seed: int) -> None:
    surface = large_patches(seed)
    borders = np.zeros((4, 4, 4), np.int32)
    _count_borders(surface.patch, *surface.rows, surface.tolerance, REACH, borders)
    np.testing.assert_array_equal(borders, borders_by_definition(surface))
    for column in (TOUCHING, SEEN, CONCAVE):
        np.testing.assert_array_equal(borders[..., column], borders[..., column].T)


def joined_small(touching: Array, sizes: list[int], whose: list[int], least: float) -> list[int]:
    parent = np.arange(len(sizes))
    _join_small(touching, np.array(sizes), np.array(whose), least, parent)
    return list(number_sets(parent).tolist())


def test_small_patches_join_what_they_touch_most() -> None:
    touching = np.array([[0, 2, 0, 0], [2, 0, 5, 0], [0, 5, 0, 0], [0, 0, 0, 0]])
    assert joined_small(touching, [90, 5, 80, 7], [1, 1, 1, 1], 30) == [0, 1, 1, 0]
    # Never a patch of another thing.
    assert joined_small(touching, [90, 5, 80, 7], [1, 1, 2, 2], 30) == [0, 0, 1, 1]
    assert joined_small(touching, [90, 5, 80, 7], [1, 2, 3, 4], 30) == [0, 1, 2, 3]
    assert joined_small(touching, [90, 50, 80, 70], [1, 1, 1, 1], 30) == [0, 1, 2, 3]


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(1, 12))
def test_no_small_set_of_patches_is_left_in_a_thing_that_has_more(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    touching = rng.integers(0, 4, (n, n))
    sizes, whose = rng.integers(1, 40, n), rng.integers(0, 3, n)
    parent = np.arange(n)
    _join_small(touching + touching.T, sizes, whose, 30, parent)
    number = number_sets(parent)
    assert all(len(set(whose[number == one])) == 1 for one in set(number))
    small = np.flatnonzero(np.bincount(number, sizes) < 30)
    for one in small:
        is_in = number == one
        assert is_in[whose == whose[is_in][0]].all()


def bent_sheet(bend: float, *, width: int = 41) -> Points:
    """Return a sheet before a camera that looks along z, of two halves that meet at an angle.

    bend: slope of the halves; above 0 the middle is nearest, a convex roof.
    """
    height = 30
    x, y = 0.004 * (np.arange(width) - width // 2), 0.004 * np.arange(height)
    across = np.broadcast_to(x, (height, width))
    depth = (1 / (1 - bend * np.abs(across))).astype(np.float32)
    xyz = np.dstack([across * depth, y[:, None] * depth, depth]).astype(np.float32)
    normals = np.stack([bend * np.sign(across), 0 * across, -np.ones_like(across)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals[:, np.abs(np.arange(width) - width // 2) < 2] = np.nan
    return Points(
        xyz,
        depth,
        normals.astype(np.float32),
        np.ones_like(depth),
        x.astype(np.float32),
        y.astype(np.float32),
        2,
    )


def test_patches_end_at_a_crease_and_have_its_edges() -> None:
    points = bent_sheet(0.8)
    thing = np.ones(points.depth.shape, np.int32)
    thing[:, :4] = 0
    patch = find_patches(thing, points, 0.0035)
    assert not patch[:, :4].any()
    assert set(np.unique(patch[:, 4:19])) == {1}
    assert set(np.unique(patch[:, 22:])) == {2}
    assert set(np.unique(patch[:, 19:22])) == {1, 2}


def test_patches_do_not_depend_on_how_much_is_looked_at() -> None:
    points = bent_sheet(0.0)
    strip = np.zeros(points.depth.shape, np.int32)
    core = 1 + 2 * points.steps(CORE_PX)
    strip[:, : core - 1] = 1
    assert not find_patches(strip, points, 0.0035).any()
    strip[:, :core] = 1
    assert find_patches(strip, points, 0.0035).sum() == np.count_nonzero(strip)


def measured(points: Points) -> Patches:
    patch = find_patches(np.ones(points.depth.shape, np.int32), points, 0.0035)
    where = np.arange(patch.size)
    return Patches.measure(
        Groups.of(where, patch.ravel()), points, -points.xyz[..., 1].ravel(), 0.0035
    )


def test_halves_meet_convexly_in_a_roof_and_not_in_a_valley() -> None:
    for bend, is_one in ((0.8, True), (-0.8, False)):
        patches = measured(bent_sheet(bend))
        assert patches.normals.shape == (2, 3)
        np.testing.assert_array_equal(patches.meet_convexly(), is_one & ~np.eye(2, dtype=bool))
        assert patches.borders[0, 1, SEEN] >= 20
