"""decisions.csv: what was weighed when a strategy chose a region, the same bytes every time."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from command import succeed
from curiosight.experiments.deciding import COLUMNS, N_LAST, DecisionsFile
from curiosight.explorer.decision import Candidate, Decision
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recordings") / "room"
    write_folder(path, 12)
    return path


def read(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


class Explaining:
    """Decides at every second look."""

    def __init__(self) -> None:
        self.n_looks = 0
        self.decision: Decision | None = None

    def reasons(self) -> Decision | None:
        if self.n_looks % 2:
            candidates = Candidate(0, None, 2.0, 0.25), Candidate(4, 0.125, -0.0, 0.75)
            self.decision = Decision(candidates, 4 * (self.n_looks % 4 == 1), 'said "so, so"')
        self.n_looks += 1
        return self.decision


def test_each_candidate_of_each_decision_has_a_line(tmp_path: Path) -> None:
    file = DecisionsFile(tmp_path / "decisions.csv", Explaining())  # type: ignore[arg-type]
    for step in range(4):
        file.add(step)
    file.close()
    rows = read(tmp_path / "decisions.csv")
    assert tuple(rows[0]) == COLUMNS
    assert [list(row.values()) for row in rows] == [
        ["1", "0", "", "2.000000", "0.250000", "0", ""],
        ["1", "4", "0.125000", "0.000000", "0.750000", "1", 'said "so, so"'],
        ["3", "0", "", "2.000000", "0.250000", "1", 'said "so, so"'],
        ["3", "4", "0.125000", "0.000000", "0.750000", "0", ""],
    ]
    assert [step for step, _ in file.last] == [1, 3]


def test_only_the_last_are_kept(tmp_path: Path) -> None:
    file = DecisionsFile(tmp_path / "decisions.csv", Explaining())  # type: ignore[arg-type]
    for step in range(10 * N_LAST):
        file.add(step)
    file.close()
    assert len(file.last) == N_LAST
    assert len(read(tmp_path / "decisions.csv")) == 10 * N_LAST


@pytest.mark.parametrize("strategy", ["iac", "rl-iac", "sweep:2"])
def test_a_run_tells_its_decisions_the_same_each_time(
    strategy: str, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    for name in ("a", "b"):
        options = ("--strategy", strategy, "--regions", "time:2", "--steps", 7)
        succeed(capsys, "explore", room, *options, "--out", tmp_path / name)
    written = [(tmp_path / name / "decisions.csv").read_bytes() for name in ("a", "b")]
    assert written[0] == written[1]
    rows = read(tmp_path / "a" / "decisions.csv")
    region_of = {row["step"]: row["region"] for row in read(tmp_path / "a" / "steps.csv")}
    chosen = [row for row in rows if row["chosen"] == "1"]
    assert chosen
    for row in chosen:
        assert region_of[row["step"]] == row["region"]
        assert row["text"]
    assert any(float(row["seconds"]) > 0 for row in rows), "the poses are known"
    page = (tmp_path / "a" / "report.html").read_text("utf-8")
    assert "Why it went there" in page
    assert chosen[-1]["text"] in page


def test_decisions_of_an_earlier_run_do_not_stay(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    few = ("--regions", "time:2", "--steps", 5, "--out", out, "--overwrite")
    succeed(capsys, "explore", room, "--strategy", "sweep:2", *few)
    assert (out / "decisions.csv").exists()
    succeed(capsys, "explore", room, "--strategy", "random", *few)
    assert not (out / "decisions.csv").exists()
