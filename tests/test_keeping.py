"""When a run under way writes its model: by looks or by time, and never for long."""

from __future__ import annotations

import pytest

from curiosight.experiments.keeping import Keeping


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def looks_written(clock: Clock, keeping: Keeping, n_looks: int, look_s: float, cost_s: float):
    """Return after which looks, from 1, the model was written."""
    written = []
    for look in range(1, n_looks + 1):
        clock.now += look_s
        if keeping.is_due():
            with keeping.writing():
                clock.now += cost_s
            written.append(look)
    return written


@pytest.mark.parametrize(
    ("look_s", "expected"),
    [(0.1, [50, 100, 150]), (1.0, [30, 60, 90, 120, 150]), (40.0, list(range(1, 161)))],
)
def test_after_fifty_looks_or_thirty_seconds(look_s: float, expected: list[int]) -> None:
    clock = Clock()
    assert looks_written(clock, Keeping(clock=clock), 160, look_s, 0.001) == expected


@pytest.mark.parametrize("cost_s", [0.05, 0.5, 5.0])
def test_writing_takes_a_fiftieth_of_the_time_at_most(cost_s: float) -> None:
    clock = Clock()
    written = looks_written(clock, Keeping(clock=clock, expected_s=cost_s), 20_000, 0.1, cost_s)
    assert written
    assert len(written) * cost_s <= 0.02 * clock.now


@pytest.mark.parametrize(
    ("setting", "value"), [("every_looks", 0), ("every_s", 0.0), ("max_share", 1.5)]
)
def test_settings_have_a_range(setting: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{setting}: expected"):
        Keeping(**{setting: value})
