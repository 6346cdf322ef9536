"""Workers of a contest: in processes and on Ray, and what of Ray could make a difference."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import signal
import subprocess
import threading
import time
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import files, succeed, without_times
from curiosight.cli.app import run
from curiosight.config import Config
from curiosight.experiments.contest.contest import Contest
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.tasks import ONE_THREAD, work

Capsys = pytest.CaptureFixture[str]
# A strategy as a user names it, which writes down what it finds around itself.
SPY = """
import json, os
from pathlib import Path
import cv2, numba
from curiosight.explorer.unlearned import Random

class Spy(Random):
    def __init__(self, views, rng, *, ways=None):
        super().__init__(views, rng)
        threads = {"numba": numba.get_num_threads(), "cv2": cv2.getNumThreads()}
        text = json.dumps({"threads": threads, "environment": dict(os.environ)})
        path = Path(__file__).with_name(f"{os.getpid()}.part")
        path.write_text(text)
        path.rename(path.with_suffix(".json"))  # whole, though this process may be killed
"""


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a strategy of one's own."""
    folder = tmp_path_factory.mktemp("here")
    (folder / "spy.py").write_text(SPY)
    return folder


@dataclass(frozen=True)
class Made:
    """A contest that is whole, what the strategy found in each worker, and who was killed."""

    out: Path
    found: list[dict[str, Any]]
    killed: list[int] = field(default_factory=list)


@pytest.fixture(scope="module")
def by_processes(room: Path, here: Path) -> Made:
    """A contest that processes made; not to be written to."""
    length = ["--seeds", "2", "--steps", "4", "--quiet"]
    words = ["compare", str(room), "--strategies", "spy:Spy,random", *length, "--out", "made"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        assert run([*words, "--workers", "2"]) == 0
    return Made(here / "made", found_by_workers(here))


@pytest.fixture
def prepared_only(by_processes: Made, tmp_path: Path) -> Path:
    """The same, with no run made yet."""
    out = tmp_path / "out"
    out.mkdir()
    shutil.copy(by_processes.out / "compare.toml", out)
    shutil.copytree(by_processes.out / "prepared", out / "prepared")
    return out


@pytest.fixture
def by_ray(
    prepared_only: Path, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> Made:
    """The same, its runs made on a local Ray cluster, with one of its workers killed."""
    monkeypatch.chdir(here)
    killed: list[int] = []
    killer = threading.Thread(target=kill_worker, args=(prepared_only, killed))
    killer.start()
    options = ["--resume", "--backend", "ray", "--workers", 2]
    succeed(capsys, "compare", "--out", prepared_only, *options)
    killer.join()
    return Made(prepared_only, found_by_workers(here), killed)


def found_by_workers(here: Path) -> list[dict[str, Any]]:
    paths = [path for path in here.glob("*.json") if path.stem != str(os.getpid())]
    found = [json.loads(path.read_text()) for path in paths]
    for path in here.glob("*.json"):
        path.unlink()
    return found


def test_processes_have_one_thread_each(by_processes: Made) -> None:
    check_one_thread(by_processes.found)


def test_ray_makes_the_same_bytes_though_a_worker_is_killed(
    by_processes: Made, request: pytest.FixtureRequest
) -> None:
    ray = pytest.importorskip("ray")
    made: Made = request.getfixturevalue("by_ray")
    assert len(made.killed) == 1
    assert without_times(made.out) == without_times(by_processes.out)
    check_one_thread(made.found)
    # A worker gets the function's name, not a copy of the globals that it had at first.
    assert ray.cloudpickle.dumps(work) == pickle.dumps(work, protocol=5)


def check_one_thread(found: list[dict[str, Any]]) -> None:
    assert found
    for one in found:
        assert one["threads"] == {"numba": 1, "cv2": 1}
        assert ONE_THREAD.items() <= one["environment"].items()


def test_task_is_of_plain_settings_and_can_be_done_twice(
    by_processes: Made, prepared_only: Path
) -> None:
    source = next(iter(json.loads((by_processes.out / "table.json").read_text())["sources"]))
    tasks = Contest.resumed(prepared_only)._missing_runs(source)
    task = next(task for task in tasks if task.strategy == "random")
    # No array, which Ray would hand over read-only and a process as a copy.
    values = [getattr(task, field.name) for field in fields(task)]
    assert {type(value) for value in values} <= {str, int, float, type(None), Config}
    work(task)
    made = times_of(Path(task.folder))
    work(task)
    assert times_of(Path(task.folder)) == made
    assert not list(prepared_only.glob("runs/*/.*"))


def times_of(folder: Path) -> dict[str, int]:
    return {name: (folder / name).stat().st_mtime_ns for name in files(folder)}


def test_what_is_shared_cannot_be_written_to(by_processes: Made) -> None:
    prepared = Prepared(next((by_processes.out / "prepared").iterdir()))
    visit = prepared.phases[0].shown[0].visit
    shared = [prepared.metres, prepared.degrees, visit.rows, *visit.counts, visit.lesson.rows]
    assert [array.flags.writeable for array in map(np.asarray, shared)] == [False] * len(shared)


def kill_worker(out: Path, killed: list[int]) -> None:
    """Kill a worker of Ray that this process started while it is at its first run."""
    end = time.monotonic() + 60
    while not killed and time.monotonic() < end:
        time.sleep(0.01)
        if list(out.glob("runs/*/.*.partial")):
            found = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True)
            rows = [line.split(maxsplit=2) for line in found.stdout.splitlines()[1:]]
            parents = {int(pid): int(parent) for pid, parent, _ in rows}
            for pid, _, args in rows:
                if args.startswith("ray::work") and os.getpid() in ancestors(int(pid), parents):
                    os.kill(int(pid), signal.SIGKILL)
                    killed.append(int(pid))
                    break


def ancestors(pid: int, parents: dict[int, int]) -> set[int]:
    """Return the processes that started one, and those that started these."""
    found: set[int] = set()
    while (pid := parents.get(pid, 0)) and pid not in found:
        found.add(pid)
    return found
