"""What is measured while it runs: rates, ages, curves, and how long learning rests."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.robot.gauges import Ages, Curve, Governor, Rate
from test_robot_feed import Clock


def test_rate_is_of_the_last_five_seconds() -> None:
    clock = Clock()
    rate = Rate(clock)
    assert rate.per_second() is None
    rate.start()
    assert rate.per_second() == 0
    for _ in range(20):  # ten a second
        clock.now += 0.1
        rate.note()
    assert rate.per_second() == pytest.approx(10)
    clock.now += 3.95  # 5.95 s after the start: those of the first 0.95 s no longer count
    assert rate.per_second() == pytest.approx(11 / 5)
    clock.now += 10
    assert rate.per_second() == 0
    assert rate.n == 20


def test_percentiles_are_those_of_all_ages() -> None:
    ages = Ages()
    assert ages.percentile_ms(50) is None
    for ms in range(1, 101):
        ages.note(ms / 1000)
    assert [ages.percentile_ms(p) for p in (1, 50, 99, 100)] == [1, 50, 99, 100]
    ages.note(3600)
    assert ages.percentile_ms(100) == 10_000
    with pytest.raises(ValueError, match="percent: expected more than 0, up to 100, got 0"):
        ages.percentile_ms(0)


def test_curve_keeps_its_shape_in_few_points() -> None:
    curve = Curve(most=8)
    for x in range(1000):
        curve.add(float(x), 2.0 * x)
    points = np.array(curve.points())
    assert 4 <= len(points) < 8
    assert points[:, 1] == pytest.approx(2 * points[:, 0])
    assert points[0, 0] == pytest.approx(63.5)  # the mean of the first 128
    with pytest.raises(ValueError, match="most: expected an even number from 2, got 3"):
        Curve(most=3)


def test_learning_rests_the_longer_the_more_maps_are_late() -> None:
    governor = Governor(late_s=0.05, most_s=0.5)
    governor.note(0.04)
    assert governor.rest_s == 0
    rests = []
    for _ in range(20):
        governor.note(0.2)
        rests.append(governor.rest_s)
    assert rests[0] == pytest.approx(0.01)
    assert rests == sorted(rests)
    assert rests[-1] == 0.5
    for _ in range(100):
        governor.note(0.02)
    assert governor.rest_s == 0
