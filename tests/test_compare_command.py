"""compare: strategies by sources by seeds; what is killed is resumed, with the same bytes."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from command import files, refusal, succeed, without_times
from curiosight.cli import compare
from curiosight.cli.app import run
from curiosight.config import load_config
from curiosight.errors import DataError
from curiosight.experiments import output
from curiosight.experiments.contest.contest import Contest, check_settings
from curiosight.experiments.contest.settings import ContestSettings
from curiosight.experiments.sole_writer import LOCK, sole_writer

Capsys = pytest.CaptureFixture[str]
N_LOOKS = 6
STRATEGIES = "random,sweep:2@time:3"
RUN_FILES = {"run.json", "looks.csv", "errors.npy", "timings.json"}
COSTS = {f"{unit}_to_{level}" for unit in ("seconds", "frames", "metres") for level in (90, 95)}


@pytest.fixture(scope="module")
def contest(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A contest that is whole; not to be written to."""
    out = tmp_path_factory.mktemp("contest") / "out"
    assert run([*arguments(room), "--out", str(out)]) == 0
    return out


@pytest.fixture
def copied(contest: Path, tmp_path: Path) -> Path:
    """A copy of it, without what is made of its runs."""
    out = tmp_path / "out"
    shutil.copytree(contest, out)
    (out / "table.json").unlink()
    return out


def arguments(source: Path) -> list[str]:
    length = ["--seeds", "2", "--steps", str(N_LOOKS), "--workers", "1", "--quiet"]
    return ["compare", str(source), "--strategies", STRATEGIES, *length]


def runs_of(out: Path) -> list[Path]:
    return sorted(path.parent for path in out.glob("runs/*/*/run.json"))


def test_table_has_every_figure_of_every_strategy(contest: Path, room: Path) -> None:
    table = json.loads((contest / "table.json").read_text())
    assert list(table) == ["sources"]
    assert list(table["sources"]) == [str(room)]
    source = table["sources"][str(room)]
    assert source["offline"]["f1"] == pytest.approx(1 - source["offline"]["error"])
    assert list(source["strategies"]) == STRATEGIES.split(",")
    means = COSTS | {"area_seconds", "area_frames", "final_error"}
    for figures in source["strategies"].values():
        assert set(figures) == means | {"n", "reached_90", "reached_95", "spread"}
        assert figures["n"] == 2
        for name in means:
            assert figures[name]["low"] <= figures[name]["mean"] <= figures[name]["high"]
    a, b = STRATEGIES.split(",")
    assert set(source["pairs"]) == {f"{a}/{b}", f"{b}/{a}"}
    pair = source["pairs"][f"{a}/{b}"]["frames_to_90"]
    costs = [source["strategies"][name]["frames_to_90"]["mean"] for name in (a, b)]
    assert pair["ratio"] == pytest.approx(costs[0] / costs[1])


def test_every_run_has_a_folder_of_its_own(contest: Path) -> None:
    runs = runs_of(contest)
    assert len(runs) == 4
    for folder in runs:
        assert files(folder) == RUN_FILES
        summary = json.loads((folder / "run.json").read_text())
        assert summary["measured"] == list(range(1, N_LOOKS + 1))
        assert len(np.load(folder / "errors.npy")) == N_LOOKS
        with (folder / "looks.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert [int(row["look"]) for row in rows] == list(range(1, N_LOOKS + 1))
        assert summary["regions"] == ("time:3" if "sweep" in folder.name else "time:5")
    assert {"report.html", "table.md", "compare.toml", "config.toml"} <= files(contest)
    drawn = {Path(name).name for name in files(contest) if name.startswith("figures/")}
    assert {"error-seconds.svg", "error-frames.png", "error-metres.png"} <= drawn
    assert "leaderboard.md" not in files(contest)


def test_resumed_contest_has_the_same_bytes(copied: Path, contest: Path, capsys: Capsys) -> None:
    shutil.rmtree(runs_of(copied)[1])
    leftover = copied / "runs" / runs_of(copied)[0].parent.name / ".random-1.abc.partial"
    leftover.mkdir()
    (leftover / "looks.csv").write_text("look\n")
    outcome = succeed(capsys, "compare", "--out", copied, "--resume", "--workers", 1)
    assert "compare 1/1" in outcome.err
    assert without_times(copied) == without_times(contest)


def test_finished_contest_only_writes_its_results_again(
    copied: Path, contest: Path, room: Path, capsys: Capsys
) -> None:
    before = {path: (path / "looks.csv").stat().st_mtime_ns for path in runs_of(copied)}
    succeed(capsys, *arguments(room), "--out", copied, "--resume")
    assert without_times(copied) == without_times(contest)
    assert before == {path: (path / "looks.csv").stat().st_mtime_ns for path in runs_of(copied)}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("source.json", None),
        ("source.json", b"{}"),
        ("source.json", b'{"visi'),
        ("metres.npy", b"\x93NUMPY"),
        ("phase0/shown-rows.npy", b""),
        ("phase0/shown-look-starts.npy", None),
    ],
)
def test_damaged_preparation_is_named(
    name: str, content: bytes | None, unfinished: Path, capsys: Capsys
) -> None:
    folder = next((unfinished / "prepared").iterdir())
    (folder / name).unlink()
    if content is not None:
        (folder / name).write_bytes(content)
    prepared = "remove this folder, and it is made again"
    line = refusal(capsys, "compare", "--out", unfinished, "--resume", "--workers", 1)
    assert f"{folder}: is not whole (" in line
    assert line.endswith(prepared)


def test_preparation_that_was_removed_is_made_again_the_same(
    copied: Path, contest: Path, capsys: Capsys
) -> None:
    shutil.rmtree(next((copied / "prepared").iterdir()))
    succeed(capsys, "compare", "--out", copied, "--resume", "--workers", 1)
    assert without_times(copied) == without_times(contest)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--seeds", "3"], "expected seeds as in compare.toml, 2; got 3"),
        (["--steps", "7"], "expected steps as in compare.toml, 6; got 7"),
        (["--seconds", "60"], "expected seconds as in compare.toml"),
        (["--strategies", "random"], "expected strategies as in compare.toml"),
        (["--regions", "time:2"], "expected regions as in compare.toml, none; got time:2"),
        (["--preset", "paper"], "expected preset as in compare.toml, default; got paper"),
        (["room:3"], "expected sources as in compare.toml"),
    ],
)
def test_other_settings_are_refused(
    options: list[str], named: str, contest: Path, capsys: Capsys
) -> None:
    assert named in refusal(capsys, "compare", "--out", contest, "--resume", *options)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--strategies", "rondom"], "did you mean random?"),
        (["--strategies", "random,random"], "got 'random' twice"),
        (["--strategies", "iac@bogus"], "got 'bogus', which is no file either"),
        (["--seeds", "0"], "seeds: expected 1 or more, got 0"),
        (["--steps", "3", "--seconds", "9"], "expected --steps or --seconds, got both"),
        (["--seconds", "nan"], "seconds: expected a positive number"),
        (["--backend", "threads"], "backend: expected processes or ray, got 'threads'"),
        (["--address", "auto"], "address: expected --backend ray, too"),
        (["--workers", "0"], "workers: expected 1 or more, got 0"),
        (["--workers", "1025"], "workers: expected 1 to 1024, got 1025"),
        (["--seeds", "10001"], "seeds: expected 1 to 10000, got 10001"),
        (["--steps", "10000001"], "steps: expected 1 to 10000000, got 10000001"),
        (["--seconds", "1e9"], "seconds: expected a positive number up to 10000000"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_anything_is_written(
    options: list[str], named: str, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    assert named in refusal(capsys, "compare", room, "--out", out, *options)
    assert not out.exists()


def test_source_under_two_names_is_refused(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    line = refusal(capsys, "compare", room, f"{room}/", "--out", tmp_path / "out")
    assert f"sources: expected each once, got '{room}' and '{room}/'" in line


@pytest.mark.parametrize("seeds", ["true", '"2"', "2.0"])
def test_settings_that_were_edited_are_refused(seeds: str, copied: Path, capsys: Capsys) -> None:
    text = (copied / "compare.toml").read_text()
    (copied / "compare.toml").write_text(text.replace("seeds = 2", f"seeds = {seeds}"))
    line = refusal(capsys, "compare", "--out", copied, "--resume")
    assert "seeds: expected a whole number, got" in line


def test_folder_that_is_not_empty_needs_resume(contest: Path, room: Path, capsys: Capsys) -> None:
    line = refusal(capsys, *arguments(room), "--out", contest)
    assert "exists and is not empty; choose another --out, or add --resume" in line


def test_there_must_be_something_to_resume(tmp_path: Path, capsys: Capsys) -> None:
    line = refusal(capsys, "compare", "--out", tmp_path, "--resume")
    assert "has no compare.toml to go on with" in line


def test_folder_that_another_writes_is_left_to_it(copied: Path, capsys: Capsys) -> None:
    with sole_writer(copied):
        before = files(copied)
        line = refusal(capsys, "compare", "--out", copied, "--resume")
        assert f"is being written by another command, process {os.getpid()}" in line
        assert files(copied) == before


def test_folder_that_another_has_begun_meanwhile_is_left_to_it(copied: Path) -> None:
    contest = Contest(Contest.resumed(copied).settings, copied)
    before = files(copied)
    with pytest.raises(DataError, match="has become another compare's"), contest.begun():
        pass
    assert files(copied) == before


def test_two_begun_in_the_same_second_have_folders_of_their_own(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(output, "datetime", Midnight)
    taken = Path("runs") / f"compare-{Midnight.now():%Y%m%d-%H%M%S}"
    monkeypatch.setattr(compare, "check_settings", lambda _: taken.mkdir(parents=True))
    monkeypatch.setattr(compare, "_follow", lambda *given: setattr(given[-1], "status", 130))
    assert run(arguments(room)) == 130
    assert list(taken.iterdir()) == []
    assert files(taken.with_name(f"{taken.name}-2")) == {"compare.toml"}


class Midnight:
    """A clock that stands."""

    @staticmethod
    def now() -> datetime:
        return datetime(2026, 1, 1)


def test_folder_of_other_files_is_nothing_to_resume(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    line = refusal(capsys, *arguments(room), "--out", tmp_path, "--resume")
    assert "has no compare.toml to go on with, but other files; choose another --out" in line
    assert files(tmp_path) == {"notes.txt"}


def test_compare_killed_at_its_start_is_begun_again(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    (tmp_path / LOCK).write_text("process 1 on nowhere\n")
    (tmp_path / ".compare.toml.1.partial").touch()
    assert "or add --resume" in refusal(capsys, *arguments(room), "--out", tmp_path)
    monkeypatch.setattr(compare, "_follow", lambda *given: setattr(given[-1], "status", 130))
    assert run([*arguments(room), "--out", str(tmp_path), "--resume"]) == 130
    assert files(tmp_path) == {"compare.toml"}


def test_home_must_change_before_a_run_is_over(tmp_path: Path, capsys: Capsys) -> None:
    home = "home:3,rooms=1,views=2,change=9:lights=1"
    line = refusal(capsys, "compare", home, "--steps", 9, "--out", tmp_path / "out")
    assert "steps: expected more than the 9 looks before" in line


def test_oracle_may_compete(room: Path) -> None:
    settings = ContestSettings((str(room),), ("oracle",), 1, 1, None, load_config())
    check_settings(settings)
    with pytest.raises(ValueError, match="oracle"):
        check_settings(replace(settings, strategies=("oracles",)))


@pytest.fixture
def unfinished(contest: Path, tmp_path: Path) -> Path:
    """A contest that is prepared, no more."""
    out = tmp_path / "unfinished"
    out.mkdir()
    shutil.copy(contest / "compare.toml", out)
    shutil.copytree(contest / "prepared", out / "prepared")
    return out


@pytest.fixture
def process(unfinished: Path) -> Iterator[subprocess.Popen[str]]:
    """The command that goes on with it, in a session of its own, its first run done."""
    # What runs in the background of a shell hands down an ignored Ctrl-C.
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "if __name__ == '__main__':\n    from curiosight.cli import main\n    main()"
    )
    script = unfinished.parent / "compare.py"
    script.write_text(program)
    command = [sys.executable, script, "compare", "--out", unfinished, "--resume", "--workers", "1"]
    with subprocess.Popen(
        command, start_new_session=True, stderr=subprocess.PIPE, text=True
    ) as started:
        end = time.monotonic() + 120
        while not runs_of(unfinished) and started.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
        yield started
        started.kill()


def test_killed_contest_is_resumed_with_the_same_bytes(
    process: subprocess.Popen[str], unfinished: Path, contest: Path, capsys: Capsys
) -> None:
    process.kill()
    process.wait()
    assert 1 <= len(runs_of(unfinished)) < 4
    assert (unfinished / LOCK).exists()
    succeed(capsys, "compare", "--out", unfinished, "--resume", "--workers", 1)
    assert without_times(unfinished) == without_times(contest)


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(
    process: subprocess.Popen[str], unfinished: Path
) -> None:
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert f"go on with curiosight compare --out {unfinished} --resume" in err
    assert "Traceback" not in err
    assert 1 <= len(runs_of(unfinished)) < 4
    assert not (unfinished / "table.json").exists()
