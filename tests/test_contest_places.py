"""What is left of places in a contest: by hand, and in the report of a recording of two."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from command import succeed, without_times
from curiosight.experiments.contest.places import (
    Left,
    has_several_places,
    mean_in_order,
    places_left,
)
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.forgetting import N_LOOKS
from curiosight.viewing.contest.tables import has_places_left, places_left_rows, qualities_rows
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
TESTED = np.array([0, 0, 1, -1])


def prepared(
    places: list[int], *, n_phases: int = 1, tested: np.ndarray = TESTED
) -> SimpleNamespace:
    phase = SimpleNamespace(first_look=0, scored_places=lambda: tested)
    ids = [f"{number}" for number in range(len(places))]
    known = {"ids": ids, "places": places, "knows_places": True}
    return SimpleNamespace(phases=[phase] * n_phases, **known)


def record(views: list[int], errors: dict[int, list[float]]) -> RunRecord:
    n_looks = len(views)
    return RunRecord(
        ids=[f"{view}" for view in views],
        regions=np.zeros(n_looks, np.int64),
        seconds=np.arange(n_looks, dtype=float),
        metres=np.arange(n_looks, dtype=float),
        measured=np.array(list(errors)),
        errors=np.array(list(errors.values())),
        region_names=["all"],
    )


def test_row_is_of_the_look_that_left_a_place() -> None:
    # Left for the other at look N_LOOKS + 1: half way between two that were measured.
    errors = {
        N_LOOKS: [0.4, 0.2, 0.9, 0.5],
        N_LOOKS + 2: [0.6, 0.4, 0.5, 0.5],
        2 * N_LOOKS: [0.5, 0.5, 0.3, 0.1],
    }
    run = record([0] * N_LOOKS + [1] * N_LOOKS, errors)
    left = places_left(prepared([0, 1]), run)  # type: ignore[arg-type]
    assert left is not None
    assert left.qualities == pytest.approx(np.array([[0.6], [0.5]]))
    assert left.average_quality == pytest.approx((0.5 + 0.7) / 2)
    assert left.backward_transfer == pytest.approx(-0.1)
    assert left.forgetting == pytest.approx(0.1)


def test_run_that_left_no_place_has_none() -> None:
    run = record([0] * (N_LOOKS - 1) + [1], {N_LOOKS: [0.5] * 4})
    assert places_left(prepared([0, 1]), run) is None  # type: ignore[arg-type]


def test_places_must_be_known_of_views_and_of_tests() -> None:
    assert has_several_places(prepared([0, 1]))  # type: ignore[arg-type]
    assert not has_several_places(prepared([0, -1]))  # type: ignore[arg-type]
    assert not has_several_places(prepared([0, 1], n_phases=2))  # type: ignore[arg-type]
    one = prepared([0, 1], tested=np.array([1, 1, -1]))
    assert not has_several_places(one)  # type: ignore[arg-type]
    unknown = prepared([0, 1])
    unknown.knows_places = False
    assert not has_several_places(unknown)  # type: ignore[arg-type]


def test_mean_is_over_the_places_that_all_runs_learned() -> None:
    two = np.array([[0.8, 0.1], [0.6, 0.5], [0.4, 0.3]])
    one = np.array([[0.4], [0.2]])
    mean = mean_in_order([Left(two, 0, 0, 0), Left(one, 0, 0, 0)])
    assert mean == pytest.approx(np.array([[0.6], [0.3]]))


def test_who_left_no_place_has_no_figures() -> None:
    figure = {"mean": -0.0312, "low": None, "high": None, "deviation": 0.01}
    names = ("average_quality", "backward_transfer", "forgetting")
    left = {"n": 1, "qualities": [[0.5], [0.4]], **dict.fromkeys(names, figure)}
    rows = {"reached_90": 0, "seconds_to_90": {"mean": 1.0}, "n": 2}
    table = {"strategies": {"a": {**rows, "places_left": left}, "b": {**rows, "places_left": None}}}
    assert has_places_left(table)
    columns, told = places_left_rows(table)
    assert len(columns) == 4
    assert told["a"] == ["1 of 2", *["-.031 ± .010"] * 3]
    assert told["b"] == ["0 of 2", "–", "–", "–"]
    assert qualities_rows(table, "b") is None
    matrix = (["place 1"], {"after place 1": ["0.50"], "at the end": ["0.40"]})
    assert qualities_rows(table, "a") == matrix


def test_report_of_a_recording_of_two_places_tells_it(tmp_path: Path, capsys: Capsys) -> None:
    source, out = tmp_path / "source", tmp_path / "out"
    write_folder(source, 32)
    ids = sorted(path.stem for path in (source / "rgb").iterdir())
    lines = [f"{id} {int(number >= 16)}\n" for number, id in enumerate(ids)]
    (source / "places.txt").write_text("".join(lines))
    settings = tmp_path / "settings.toml"
    settings.write_text("[test]\nevery = 4\ngap = 0\n")
    length = ("--seeds", 2, "--steps", 24, "--workers", 1, "--config", settings)
    told = ("compare", source, "--strategies", "chronological,random", *length)
    succeed(capsys, *told, "--out", out)
    rows = json.loads((out / "table.json").read_text())["sources"][str(source)]["strategies"]
    left = rows["chronological"]["places_left"]
    assert left["n"] == 2
    qualities = np.array(left["qualities"])
    assert qualities.shape == (2, 1)
    assert left["backward_transfer"]["mean"] == pytest.approx(
        qualities[1, 0] - qualities[0, 0], abs=2e-6
    )
    assert left["forgetting"]["deviation"] >= 0
    for name in ("report.html", "table.md"):
        text = (out / name).read_text()
        assert "What is left of places" in text
        assert "after place 1" in text
    whole = without_times(out)
    shutil.rmtree(next((out / "runs").glob("*/random-1")))
    (out / "table.json").unlink()
    succeed(capsys, "compare", "--out", out, "--resume", "--workers", 1)
    assert without_times(out) == whole
    (source / "places.txt").unlink()
    succeed(capsys, *told, "--out", tmp_path / "other")
    table = json.loads((tmp_path / "other" / "table.json").read_text())
    assert "places_left" not in table["sources"][str(source)]["strategies"]["random"]
    assert "What is left of places" not in (tmp_path / "other" / "report.html").read_text()
