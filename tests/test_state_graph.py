"""State as JSON and arrays: what comes back is the same, and nothing else can come."""

from __future__ import annotations

import json
import random
from collections import Counter, OrderedDict, defaultdict, deque
from functools import partial
from typing import Any

import numpy as np
import pytest

from curiosight.experiments.state_graph import GraphReader, GraphWriter
from curiosight.explorer.decision import Candidate
from curiosight.explorer.progress_rate import ProgressRate
from curiosight.frame import Label, Viewpoint
from curiosight.learner.forest import Forest
from curiosight.learner.forest_trees import Tree


def there_and_back(one: Any, **outside: object) -> Any:
    writer = GraphWriter(outside)
    node = json.loads(json.dumps(writer.node(one)))
    return GraphReader(writer.arrays, outside).made(node)


@pytest.mark.parametrize(
    "one",
    [
        None, True, -7, 0.1, float("inf"), "ü", b"\0x", (), [1, [2]], {1: "a", (2, 3): None},
        {3, 1}, frozenset({2}), deque([1, 2, 3], maxlen=2), Counter("aab"), OrderedDict(b=1, a=2),
        defaultdict(list, {1: [2]}), np.float32(0.1), np.int64(-3), np.bool_(True), Label.SALIENT,
        Candidate(3, 0.5, 1.0, 0.25),
    ],
    ids=repr,
)  # fmt: skip
def test_comes_back_equal(one: Any) -> None:
    back = there_and_back(one)
    assert back == one
    assert type(back) is type(one)


def test_what_is_the_same_object_stays_so() -> None:
    rng, outside = np.random.default_rng(3), [1]
    ring: list[Any] = [outside]
    ring.append(ring)
    a, b, back, given = there_and_back([rng, rng, ring, outside], given=outside)
    assert a is b
    assert back[1] is back
    assert given is outside
    assert back[0] is outside


@pytest.mark.parametrize("name", ["PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64"])
def test_chance_goes_on_and_has_the_same_children(name: str) -> None:
    rng = np.random.Generator(getattr(np.random, name)(5))
    rng.spawn(2)
    rng.random(3)
    back = there_and_back(rng)
    assert back.random(4).tolist() == rng.random(4).tolist()
    assert back.spawn(1)[0].random() == rng.spawn(1)[0].random()
    usual = random.Random(7)
    assert there_and_back(usual).random() == usual.random()


def test_arrays_keep_type_layout_and_values() -> None:
    base = np.arange(24, dtype=np.float32).reshape(4, 6)
    arrays = [
        base, base.T, base[:, 1::2], base[::-1], np.broadcast_to(base[0], (3, 6)),
        np.empty((0, 3), np.uint8), np.array(5), np.array(["a", "bc"]),
        np.array([(1, 2.0)], [("a", "<i4"), ("b", "<f8")]),
    ]  # fmt: skip
    for array, back in zip(arrays, there_and_back(arrays), strict=True):
        np.testing.assert_array_equal(back, array)
        assert back.dtype == array.dtype
        if array.size > 1:
            assert back.strides == array.strides


def test_objects_of_ours() -> None:
    rng = np.random.default_rng(0)
    forest = Forest(n_features=3, n_trees=4, n_regrown=2, seed=rng)
    rows = rng.integers(0, 256, (60, 3)).astype(np.uint8)
    forest.update(rows, rows[:, 0] > 99)
    back = there_and_back(forest)
    for one in (forest, back):
        one.update(rows[::-1], rows[::-1, 1] > 20)
    assert np.array_equal(back.predict(rows), forest.predict(rows))
    assert isinstance(back._known.trees[0], Tree)
    views = [Viewpoint(i, i % 2, np.eye(4)) for i in range(6)]
    strategy = ProgressRate(views, rng, ways=None)
    again = there_and_back(strategy)
    assert again.choose().index == strategy.choose().index


@pytest.mark.parametrize(
    "one",
    [open, lambda: 0, json, np.array([None]), int, (i for i in ()), object()],
    ids=lambda one: type(one).__name__,
)
def test_what_is_more_than_state_cannot_be_kept(one: Any) -> None:
    with pytest.raises(ValueError, match="cannot be kept"):
        GraphWriter({}).node([one])
    if callable(one):
        with pytest.raises(ValueError, match="cannot be kept"):
            GraphWriter({}).node(partial(one))


@pytest.mark.parametrize(
    "node",
    [
        ["object", "os:system", None],
        ["object", "subprocess:Popen", {}],
        ["object", "curiosight.cli.talk:Talk", {}],
        ["object", "curiosight.learner.forest:ThreadPoolExecutor", {}],
        ["object", "curiosight.learner.forest:partial", {}],
        ["enum", "curiosight.learner.forest:Forest", "x"],
        ["named", "curiosight.learner.forest:Forest", []],
        ["object", "curiosight.explorer.strategies:make_strategy", None],
        ["partial", ["outside", "os.system"], ["tuple", []], ["dict", [], []]],
        ["array", 0, [1 << 40]],
        ["chance", "default_rng", None, None],
        ["same", 4],
        ["pickle", "x"],
    ],
    ids=str,
)
def test_foreign_node_makes_nothing(node: list[Any]) -> None:
    arrays = {"000000": np.arange(3)}
    with pytest.raises((ValueError, KeyError, IndexError, TypeError)):
        GraphReader(arrays, {}).made(node)
