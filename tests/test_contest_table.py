"""The figures of a contest, on runs that can be counted by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from curiosight.experiments.contest.prepared import Phase
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.contest.series import band_of
from curiosight.experiments.contest.settings import folder_name
from curiosight.experiments.contest.table import Curve, curve_of, error_at, looks_until_back, spread
from curiosight.viewing.contest.tables import BOARDS, cost, leaderboard, ranked


def record(errors: dict[int, list[float]], seconds: list[float]) -> RunRecord:
    n_looks = len(seconds)
    return RunRecord(
        ids=[f"{look:06}" for look in range(n_looks)],
        regions=np.zeros(n_looks, np.int64),
        seconds=np.array(seconds),
        metres=np.array(seconds) / 2,
        measured=np.array(list(errors)),
        errors=np.array(list(errors.values())),
        region_names=["all"],
    )


def curve(errors: list[float], seconds: list[float]) -> Curve:
    return Curve(np.array(errors), np.array(seconds), np.array(seconds) / 2)


def test_error_is_straight_between_the_looks_that_were_measured() -> None:
    run = record({1: [0.8, 1.0], 4: [0.3, np.nan]}, [1, 5, 8, 12])
    made = curve_of(run)
    assert made.errors == pytest.approx([0.9, 0.7, 0.5, 0.3])
    assert made.seconds == pytest.approx([1, 5, 8, 12])


def test_all_counts_from_a_change_on() -> None:
    run = record({1: [0.8], 2: [0.1], 3: [0.6], 4: [0.4]}, [1, 5, 8, 12])
    made = curve_of(run, first_look=2)
    assert made.errors == pytest.approx([0.6, 0.4])
    assert made.seconds == pytest.approx([3, 7])
    assert made.metres == pytest.approx([1.5, 3.5])
    with pytest.raises(ValueError, match="expected more than 4 looks, got 4"):
        curve_of(run, first_look=4)


def test_cost_is_that_of_the_first_look_that_gets_there_or_all() -> None:
    made = curve([0.9, 0.5, 0.6, 0.4], [1, 5, 8, 12])
    assert made.cost("seconds", 0.5) == 5
    assert made.cost("frames", 0.5) == 2
    assert made.cost("metres", 0.45) == 6
    assert made.reached(0.3) is None
    assert made.cost("seconds", 0.3) == 12
    assert error_at(90, 0.7) == pytest.approx(0.37)


def test_mean_over_seconds_holds_an_error_until_the_next_look_is_over() -> None:
    made = curve([0.8, 0.4], [2, 6])
    assert made.mean_over_seconds(6) == pytest.approx((2 * 1 + 4 * 0.8) / 6)
    assert made.mean_over_seconds(4) == pytest.approx((2 * 1 + 2 * 0.8) / 4)


def test_spread_is_averaged_over_looks_from_the_twentieth_on() -> None:
    early = [1.0] * 19
    two = [curve([*early, 0.4, 0.4], list(range(1, 22))), curve([0.0] * 19 + [0.6, 0.8], [1] * 21)]
    assert spread(two) == pytest.approx((0.2 + 0.4) / 2 / np.sqrt(2))
    assert spread(two[:1]) is None


def test_band_ends_where_the_first_seed_does() -> None:
    band = band_of([curve([0.8, 0.4], [2, 6]), curve([0.6, 0.2], [1, 9])], "seconds")
    assert (band.x[0], band.x[-1]) == (2, 6)
    assert band.mean[-1] == pytest.approx((0.4 + 0.35) / 2)


def row(mean: float, reached: int) -> dict[str, object]:
    figure = {"mean": mean, "low": mean - 1, "high": mean + 1}
    return {"n": 2, "reached_90": reached, "seconds_to_90": figure}


def test_lower_bounds_are_marked_and_who_never_gets_there_is_last() -> None:
    table = {"strategies": {"never": row(5, 0), "slow": row(20, 2), "some": row(10, 1)}}
    assert ranked(table) == ["some", "slow", "never"]
    assert cost(table["strategies"]["some"], "seconds", 90) == "≥ 10 [9, 11]"
    assert cost(table["strategies"]["slow"], "seconds", 90) == "20 [19, 21]"


def test_leaderboard_is_ordered_by_the_geometric_mean_of_ratios() -> None:
    def of(x: tuple[float, int], y: tuple[float, int], f1: float) -> dict[str, object]:
        offline = {"error": 1 - f1, "f1": f1}
        return {"offline": offline, "strategies": {"x": costs(*x), "y|z": costs(*y)}}

    sources = {"a": of((10, 2), (40, 2), 0.8), "b": of((200, 2), (100, 1), 0.7)}
    text = leaderboard({"sources": sources})
    assert text.startswith("# Leaderboard\n\n2 sources, 2 seeds each.")
    assert "| a | 0.800 | x |\n| b | 0.700 | y\\|z |\n" in text
    boards = text.split("## ")[1:]
    assert [board.splitlines()[0] for board in boards] == [title for title, _, _ in BOARDS]
    for board in boards:
        rows = [line for line in board.splitlines() if line.startswith("| ")][2:]
        assert rows == [
            "| x | 1.41 | 10 [9, 11] | 200 [199, 201] |",
            "| y\\|z | ≥ 2.00 | 40 [39, 41] | ≥ 100 [99, 101] (1 of 2) |",
        ]


def test_who_never_gets_there_does_not_lead_by_short_runs() -> None:
    rows = {"short": costs(3, 0), "slow": costs(20, 1), "fast": costs(10, 2)}
    table = {"offline": {"error": 0.2, "f1": 0.8}, "strategies": rows}
    board = leaderboard({"sources": {"a": table, "b": table}}).split("## ")[1]
    first = [line.split(" | ")[:2] for line in board.splitlines() if line.startswith("| ")][2:]
    assert first == [["| fast", "1.00"], ["| slow", "≥ 2.00"], ["| short", "≥ 0.30"]]


def costs(mean: float, reached: int) -> dict[str, object]:
    figure = {"mean": mean, "low": mean - 1, "high": mean + 1}
    rows = {f"{unit}_to_{level}": figure for _, unit, level in BOARDS}
    return {"n": 2, "reached_90": reached, "reached_95": reached, **rows}


def test_folder_names_differ_and_are_plain() -> None:
    names = ["random", "iac@auto:4", "iac@auto_4", "../up", "a/b", "a_b", "x" * 300]
    folders = [folder_name(name) for name in names]
    assert len(set(folders)) == len(names)
    assert folders[0] == "random"
    assert all("/" not in name and ".." not in name and len(name) < 80 for name in folders)


@pytest.mark.parametrize(("changed", "expected"), [([1], 3), (None, 2), ([0], 1)])
def test_looks_until_the_changed_rooms_are_known_again(
    changed: list[int] | None, expected: int
) -> None:
    def phase(first_look: int) -> Phase:
        views = [SimpleNamespace(salient=np.array([n])) for n in (1, 0, 1)]  # the second has no F1
        return Phase(first_look, None, views, [0, 0, 1], {})  # type: ignore[arg-type]

    prepared = SimpleNamespace(phases=[phase(0), phase(2)], meta={"changed": changed})
    errors = {1: [0.9, 0.9], 2: [0.3, 0.3], 3: [0.3, 0.9], 4: [0.1, 0.5], 5: [0.3, 0.34]}
    run = record(errors, [1, 2, 3, 4, 5])
    assert looks_until_back(prepared, run) == expected  # type: ignore[arg-type]
