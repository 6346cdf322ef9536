"""Clusters against a k-d tree and brute force."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from curiosight.teacher.things.clusters import euclidean_clusters, join_stacked

Points3 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
SEED = 3


def clusters_by_tree(xyz: Points3, leaf: float, tolerance: float) -> Numbers:
    """Cluster as the paper does: voxels, k-d tree, connected components."""
    cells = np.floor(xyz / leaf).astype(np.int64)
    _, voxel, n_points = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(voxel, xyz[:, axis]) for axis in range(3)], axis=1)
    means = sums / n_points[:, None]
    one, other = cKDTree(means).query_pairs(tolerance, output_type="ndarray").T
    links = coo_array((np.ones(len(one), bool), (one, other)), (len(means), len(means)))
    _, cluster = connected_components(links, directed=False)
    return np.asarray(cluster[voxel])


def clusters_by_flooding(xyz: Points3, tolerance: float) -> Numbers:
    """Number points by brute force: neighbours within the tolerance share a number."""
    near = np.linalg.norm(xyz[:, None] - xyz[None], axis=2) <= tolerance
    number = np.full(len(xyz), -1)
    for seed in range(len(xyz)):
        open_points = [seed] if number[seed] < 0 else []
        while open_points:
            point = open_points.pop()
            number[point] = seed
            open_points += list(np.flatnonzero(near[point] & (number < 0)))
    return number


def same_partition(a: Numbers, b: Numbers) -> bool:
    n_pairs = len({*zip(a.tolist(), b.tolist(), strict=True)})
    return n_pairs == len({*a.tolist()}) == len({*b.tolist()})


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n_points=st.integers(1, 400),
    leaf=st.floats(0.01, 0.2),
    share=st.floats(0.3, 4),
    is_surface=st.booleans(),
)
def test_clusters_equal_those_of_a_tree(
    seed: int, n_points: int, leaf: float, share: float, is_surface: bool
) -> None:
    xyz = np.random.default_rng(seed).uniform(-1, 1, (n_points, 3))
    if is_surface:
        xyz[:, 2] = 0.3 * xyz[:, 0] + 2
    found = euclidean_clusters(xyz, leaf=leaf, tolerance=share * leaf)
    assert same_partition(found, clusters_by_tree(xyz, leaf, share * leaf))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 150))
def test_clusters_equal_brute_force_where_voxels_are_tiny(seed: int, n_points: int) -> None:
    xyz = np.random.default_rng(seed).uniform(-1, 1, (n_points, 3))
    found = euclidean_clusters(xyz, leaf=1e-6, tolerance=0.2)
    assert same_partition(found, clusters_by_flooding(xyz, 0.2))


@pytest.mark.parametrize("step", [0.1, 0.25])
def test_points_exactly_as_far_apart_as_the_tolerance_are_linked(step: float) -> None:
    xyz = np.zeros((50, 3))
    xyz[:, 1] = step * np.arange(50)
    gap = np.diff(xyz[:, 1]).max()
    assert set(euclidean_clusters(xyz, leaf=1e-3, tolerance=float(gap))) == {0}
    assert len(set(euclidean_clusters(xyz, leaf=1e-3, tolerance=0.99 * step))) == 50


def test_voxels_leave_clusters_as_they_are() -> None:
    rng = np.random.default_rng(SEED)
    xyz = rng.uniform(0, 0.2, (6000, 3)).astype(np.float32)
    xyz[:, 0] += np.repeat(np.float32([0.0, 0.32, 0.75]), 2000)
    found = euclidean_clusters(xyz, leaf=0.06, tolerance=0.10)
    np.testing.assert_array_equal(found, np.repeat([0, 1, 2], 2000))
    assert set(euclidean_clusters(xyz, leaf=0.06, tolerance=0.5)) == {0}


def test_no_point_has_no_cluster() -> None:
    assert euclidean_clusters(np.empty((0, 3)), leaf=0.02, tolerance=0.03).shape == (0,)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20))
def test_stacked_clusters_equal_the_components_of_a_graph(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = np.sort(rng.uniform(0, 1, (n, 3, 2)), axis=2)
    hovers, support = rng.random(n) < 0.5, rng.integers(0, 2, n)
    links = np.zeros((n, n), np.bool_)
    for upper, lower in np.ndindex(n, n):
        is_below = boxes[lower, 2, 0] < boxes[upper, 2, 0] < boxes[lower, 2, 1] + 0.2
        begin = np.maximum(boxes[upper, :2, 0], boxes[lower, :2, 0])
        end = np.minimum(boxes[upper, :2, 1], boxes[lower, :2, 1])
        meets = support[upper] == support[lower] and (begin - end < 0.05).all()
        links[upper, lower] = hovers[upper] and is_below and meets
    _, expected = connected_components(links, directed=False)
    found = join_stacked(boxes, hovers, support, reach=0.2, margin=0.05)
    assert same_partition(found, expected)
