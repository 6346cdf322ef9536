"""Bodies against plain references."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.teacher.cloud.planes import Plane
from curiosight.teacher.settings import TABLE
from curiosight.teacher.supports.supports import Support
from curiosight.teacher.things.bodies import Bodies, beside_table

Mask = npt.NDArray[np.bool_]


def beside_by_loop(body: npt.NDArray[np.int32], table: Support) -> Mask:
    """Apply the definition of `beside_table` body by body."""
    assert table.extent is not None
    beside = np.zeros(body.shape, np.bool_)
    for number in range(1, int(body.max()) + 1):
        part = body == number
        inside = table.extent[part].mean()
        heights = table.heights[part]
        crosses = min(np.mean(heights > 0.03), np.mean(heights < -0.03)) > 0.05
        is_beyond_core = table.core is not None and table.core[part].mean() < 0.3
        beside[part] = inside > 0 and (inside < 0.5 or (crosses and is_beyond_core))
    return beside


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_bodies_beside_a_table_are_as_defined(seed: int, has_core: bool) -> None:
    rng = np.random.default_rng(seed)
    body = np.repeat(np.arange(12, dtype=np.int32), 20).reshape(12, 20)
    heights = rng.normal(rng.uniform(-0.1, 0.1, (12, 1)), 0.05, body.shape).astype(np.float32)
    extent = rng.random(body.shape) < rng.random((12, 1))
    core = extent & (rng.random(body.shape) < 0.5) if has_core else None
    plane = Plane(np.array([0.0, -1.0, 0.0]), 1.0, np.zeros(body.shape, np.bool_))
    table = Support(plane, TABLE, heights, extent, core, extent if has_core else None)
    is_beside = beside_table(Bodies(body, 12), table)
    np.testing.assert_array_equal(is_beside[body], beside_by_loop(body, table))
