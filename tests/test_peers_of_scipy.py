"""What the base install does without SciPy is what SciPy does: to the bit, ties included."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.ndimage import distance_transform_edt, find_objects
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree
from scipy.spatial.distance import squareform
from scipy.spatial.transform import Rotation, Slerp

from curiosight.evaluation.nearest import nearest_marked
from curiosight.frame.assignment import best_pairs
from curiosight.frame.boxes import boxes_of
from curiosight.frame.linkage import AverageLinkage
from curiosight.frame.rotations import between, matrix_of, quaternion_about, quaternion_of
from curiosight.rooms.shortest_ways import shortest_ways
from curiosight.teacher.things.nearest_points import nearest_points

seeds = st.integers(0, 10**6)
PEER = settings(max_examples=40, deadline=None)


def test_rotations_are_the_same() -> None:
    rng = np.random.default_rng(0)
    quaternions, vectors = rng.standard_normal((500, 4)), rng.standard_normal((500, 3))
    vectors[:2] = [[0, 0, 0], [1e-9, 0, 0]]
    theirs = Rotation.from_quat(quaternions)
    assert (matrix_of(quaternions) == theirs.as_matrix()).all()
    noisy = theirs.as_matrix() + rng.normal(0, 1e-4, (500, 3, 3))
    np.testing.assert_allclose(
        quaternion_of(noisy), Rotation.from_matrix(noisy).as_quat(), atol=1e-14
    )
    np.testing.assert_allclose(
        matrix_of(quaternion_about(vectors)), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-14
    )
    for one, other, share in zip(quaternions, quaternions[1:], rng.random(499), strict=False):
        mixed = Slerp([0, 1], Rotation.from_quat([one, other]))(share).as_matrix()
        np.testing.assert_allclose(matrix_of(between(one, other, share)), mixed, atol=1e-14)


def test_quaternion_without_length_is_refused() -> None:
    with pytest.raises(ValueError, match="quaternions: expected lengths above 0"):
        matrix_of([0, 0, 0, 0])


@PEER
@given(seed=seeds, n=st.integers(2, 40), is_tied=st.booleans())
def test_groups_are_the_same(seed: int, n: int, is_tied: bool) -> None:
    rng = np.random.default_rng(seed)
    distances = rng.integers(0, 6, (n, n)) / 5 if is_tied else rng.random((n, n))
    distances = (distances + distances.T) / 2
    np.fill_diagonal(distances, 0)
    theirs, ours = linkage(squareform(distances), "average"), AverageLinkage(distances)
    for height in (0.0, float(rng.choice(theirs[:, 2])), float(rng.random())):
        assert (ours.within(height) == fcluster(theirs, height, "distance") - 1).all()
    if n > 2:
        n_groups = int(rng.integers(1, n - 1))
        assert (ours.at_most(n_groups) == fcluster(theirs, n_groups, "maxclust") - 1).all()


@PEER
@given(seed=seeds, size=st.tuples(st.integers(1, 9), st.integers(1, 9)), is_tied=st.booleans())
def test_pairs_are_the_same(seed: int, size: tuple[int, int], is_tied: bool) -> None:
    rng = np.random.default_rng(seed)
    gains = rng.integers(0, 4, size).astype(float) if is_tied else rng.standard_normal(size)
    for ours, theirs in zip(best_pairs(gains), linear_sum_assignment(-gains), strict=True):
        assert ours.tolist() == theirs.tolist()


@PEER
@given(seed=seeds, size=st.tuples(st.integers(1, 30), st.integers(1, 30)))
def test_nearest_marked_pixel_is_the_same(seed: int, size: tuple[int, int]) -> None:
    rng = np.random.default_rng(seed)
    is_marked = rng.random(size) < rng.choice([0.02, 0.3])
    is_marked.flat[rng.integers(is_marked.size)] = True
    _, places = distance_transform_edt(~is_marked, return_indices=True)
    assert (nearest_marked(is_marked) == np.ravel_multi_index(tuple(places), size)).all()


@PEER
@given(seed=seeds)
def test_boxes_and_nearest_points_are_the_same(seed: int) -> None:
    rng = np.random.default_rng(seed)
    numbers = rng.integers(0, 9, (8, 11)) * (rng.random((8, 11)) < 0.2)
    assert boxes_of(numbers) == find_objects(numbers)
    xyz, wanted = rng.standard_normal((50, 3)), rng.standard_normal((20, 3))
    metres, places = nearest_points(xyz, wanted)
    theirs = cKDTree(xyz).query(wanted)
    np.testing.assert_allclose(metres, theirs[0], atol=1e-12)
    assert (places == theirs[1]).all()


@PEER
@given(seed=seeds, has_corners=st.booleans(), longest=st.sampled_from([np.inf, 0.6]))
def test_ways_are_as_long(seed: int, has_corners: bool, longest: float) -> None:
    is_free = np.pad(np.random.default_rng(seed).random((9, 12)) < 0.8, 1)
    is_free[3, 3] = True
    cells = np.argwhere(is_free)
    apart = np.abs(cells[:, None] - cells)
    one, other = np.nonzero((apart.max(2) == 1) & (has_corners | (apart.sum(2) == 1)))
    lengths = np.hypot(*apart[one, other].T) * 0.05
    graph = coo_array((lengths, (one, other)), (len(cells),) * 2).tocsr()
    first = int(np.flatnonzero((cells == 3).all(1))[0])
    theirs = dijkstra(graph, indices=first, limit=longest)
    metres, before = shortest_ways(
        is_free, (3, 3), side=0.05, has_corners=has_corners, longest=longest
    )
    assert (metres[is_free] == theirs).all()
    assert np.isinf(metres[~is_free]).all()
    reached = np.isfinite(metres)
    reached[3, 3] = False
    v, u = np.divmod(before[reached], is_free.shape[1])
    steps = np.hypot(*(np.argwhere(reached) - np.stack([v, u], 1)).T) * 0.05
    np.testing.assert_allclose(metres[v, u] + steps, metres[reached], atol=1e-12)
