"""A run that was killed goes on to the same bytes, and says what it cannot go on with."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from command import call, files, interrupt_at, refusal, succeed
from curiosight.cli.app import run
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.keeping import Keeping
from curiosight.learner.archive import read_archive
from curiosight.learner.learner import SaliencyLearner
from kills import Killer, killer
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
# All that a run says but its times.
EXPLORED = ("model.npz", "steps.csv", "decisions.csv", "config.toml", "summary.json")
LEARNED = ("model.npz", "config.toml", "summary.json")
STEPS = 8


class Killed(BaseException):
    """Stands for a kill: nothing that comes after it is done."""


@pytest.fixture
def no_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing at the end of a run, which takes longer than the run."""
    monkeypatch.setattr("curiosight.cli.explore.tell_run", lambda *_: None)


def bytes_of(folder: Path, names: tuple[str, ...]) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in names if (folder / name).exists()}


@pytest.fixture(scope="module")
def kills() -> Iterator[Killer]:
    with killer() as one:
        yield one


@pytest.fixture(scope="module")
def explored(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nothing interrupted."""
    path = tmp_path_factory.mktemp("runs") / "whole"
    assert run(["explore", str(room), "--steps", str(STEPS), "--out", str(path), "--quiet"]) == 0
    return path


def killed_at(
    step: int, out: Path, monkeypatch: pytest.MonkeyPatch, *words: str | Path, every: int = 1
) -> None:
    """Explore, and be killed in a step; the state was written every so many before."""
    note, n_due = Exploration._note, iter(range(1, 1000))

    def killing(self: Exploration, done: object) -> object:
        if done.index == step:
            raise Killed
        return note(self, done)

    with monkeypatch.context() as patch:
        patch.setattr(Exploration, "_note", killing)
        patch.setattr(Keeping, "is_due", lambda _: next(n_due) % every == 0)
        with pytest.raises(Killed):
            run(["explore", *map(str, words), "--out", str(out), "--quiet"])


def check_readable(out: Path) -> None:
    """Read every file that there is as its readers do."""
    for path in out.glob("*.json"):
        json.loads(path.read_text())
    for name, kind in (("model.npz", "saliency model"), ("state.npz", "state of a run")):
        if (out / name).exists():
            read_archive(out / name, kind)
    for path in out.glob("*.csv"):
        assert path.read_bytes()[-1:] in (b"", b"\n")


def test_kills_at_random_moments_lose_nothing(
    kills: Killer, explored: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    """Also between files: at a change of a file, just before or just after it."""
    rng, out = np.random.default_rng(16), tmp_path / "out"
    words = ("explore", room, "--steps", STEPS, "--out", out, "--quiet")
    n_killed = 0
    for number in range(3):
        is_timed = number < 1
        n_killed += kills.kill(
            *words,
            after_s=float(rng.uniform(0.3, 1.5)) if is_timed else None,
            at=None if is_timed else int(rng.integers(30, 90)),
        )
        check_readable(out)
        if (out / "command.json").exists():
            succeed(capsys, "explore", "--resume", out, "--quiet")
            assert bytes_of(out, EXPLORED) == bytes_of(explored, EXPLORED)
            assert "report.html" in files(out)
        shutil.rmtree(out, ignore_errors=True)
    assert n_killed >= 2  # the one by the clock may come too late


@pytest.mark.usefixtures("no_report")
def test_killed_twice(
    kills: Killer, explored: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    assert kills.kill("explore", room, "--steps", STEPS, "--out", out, "-q", at=45)
    assert kills.kill("explore", "--resume", out, "-q", at=20)
    check_readable(out)
    succeed(capsys, "explore", "--resume", out)
    assert bytes_of(out, EXPLORED) == bytes_of(explored, EXPLORED)


def test_learn_goes_on(
    kills: Killer, model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    """Killed in the first pass, and in the second."""
    out = tmp_path / "out"
    for at in (20, 67):
        assert kills.kill("learn", room, "--out", out, "--quiet", at=at)
        check_readable(out)
        succeed(capsys, "learn", "--resume", out, "--quiet")
        assert bytes_of(out, LEARNED) == bytes_of(model, LEARNED)
        assert files(out) == {*LEARNED, "command.json"}
        shutil.rmtree(out)


@pytest.mark.usefixtures("no_report")
@pytest.mark.parametrize(
    "options",
    [
        ("--strategy", "progress-rate", "--regions", "growing"),
        ("--strategy", "own:Mine"),
        ("--strategy", "rl-iac", "--config", "backward.toml"),
    ],
    ids=" ".join,
)
def test_any_strategy_goes_on(
    options: tuple[str, ...],
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(OWN)
    Path("backward.toml").write_text('[explorer]\nprogress = "backward"\n')
    words = (room, *options, "--steps", "14")
    assert run(["explore", *map(str, words), "--out", "whole", "--quiet"]) == 0
    killed_at(12, tmp_path / "out", monkeypatch, *words, every=11)
    succeed(capsys, "explore", "--resume", "out", "--quiet")
    assert bytes_of(tmp_path / "out", EXPLORED) == bytes_of(tmp_path / "whole", EXPLORED)


OWN = '''
from collections import Counter, deque


class Mine:
    """Looks anywhere, and where errors were large again."""

    def __init__(self, views, rng, *, ways=None):
        if not views:
            raise ValueError("views: expected some")
        self._views, self._rng, self._ways = list(views), rng, ways
        self._last, self._n = deque(maxlen=4), Counter()

    def choose(self):
        if self._last and self._rng.random() < 0.5:
            return max(self._last, key=lambda told: told[1] or 0.0)[0]
        return self._views[self._rng.integers(len(self._views))]

    def update(self, viewpoint, outcome):
        self._last.append((viewpoint, outcome.error))
        self._n[viewpoint.index] += 1

    def upcoming(self):
        return ()

    def progress_of(self, region):
        return None
'''


@pytest.mark.usefixtures("no_report")
def test_run_from_a_model_in_its_own_folder_goes_on(
    room: Path, explored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    """The model that it began with is overwritten meanwhile, and not needed any more."""
    results = []
    for name in ("whole", "out"):
        out = tmp_path / "runs" / name
        shutil.copytree(explored, out)
        words = (room, "--steps", "5", "--test-every", "3", "--gap", "0", "--overwrite")
        words = (*words, "--seed", "4", "--from", str(out))
        if name == "whole":
            assert run(["explore", *map(str, words), "--out", str(out), "--quiet"]) == 0
        else:
            killed_at(4, out, monkeypatch, *words, every=2)
            succeed(capsys, "explore", "--resume", out, "--quiet")
        found = bytes_of(out, EXPLORED)
        found["summary.json"] = found["summary.json"].replace(str(out).encode(), b"RUN")
        results.append(found)
    assert results[0] == results[1]


@pytest.mark.usefixtures("no_report")
def test_after_ctrl_c_a_run_goes_on(
    room: Path, explored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        interrupt_at(patch, SaliencyLearner, "learn", turn=5)
        outcome = call(capsys, "explore", room, "--steps", STEPS, "--out", out)
    assert outcome.status == 130
    assert f"go on with curiosight explore --resume {out}" in outcome.err
    assert "goes on after 5 steps" in succeed(capsys, "explore", "--resume", out).err
    assert bytes_of(out, EXPLORED) == bytes_of(explored, EXPLORED)


def test_finished_run_is_finished(explored: Path, model: Path, capsys: Capsys) -> None:
    before = bytes_of(explored, tuple(files(explored)))
    for command, path, n_done in (("explore", explored, "8 steps"), ("learn", model, "8 frames")):
        outcome = succeed(capsys, command, "--resume", path)
        assert outcome.err == f"{path}: the run is finished after {n_done}\n"
        assert outcome.out == ""
    assert bytes_of(explored, tuple(files(explored))) == before


def test_report_is_made_again(
    explored: Path, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    """Of a finished run it is the same page; of a killed one it tells of what was kept."""
    whole, out = tmp_path / "whole", tmp_path / "out"
    shutil.copytree(explored, whole)
    page = (whole / "report.html").read_bytes()
    (whole / "report.html").unlink()
    shutil.rmtree(whole / "figures")
    succeed(capsys, "report", whole)
    assert files(whole) == files(explored)
    assert without_took((whole / "report.html").read_bytes()) == without_took(page)
    killed_at(7, out, monkeypatch, room, "--steps", "12", every=3)
    before = bytes_of(out, tuple(files(out)))
    assert "6 of 12 steps" in succeed(capsys, "report", out).out
    assert "looked at 6 frames" in (out / "report.html").read_text()
    assert bytes_of(out, tuple(before)) == before


def without_took(page: bytes) -> bytes:
    """Return a page without the sentence of how long its run took."""
    before, _, after = page.partition(b"It took ")
    return before + after.partition(b".")[2]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--seed", "3"), "expected no --seed beside it"),
        (("--out", "x"), "expected no --out beside it"),
        (("--min-confidence", "2"), "expected no --min-confidence beside it"),
        (("home:1",), "expected no SOURCE beside it"),
    ],
)
@pytest.mark.parametrize("command", ["explore", "learn"])
def test_other_settings_are_refused(
    command: str, words: tuple[str, ...], named: str, explored: Path, capsys: Capsys
) -> None:
    assert named in refusal(capsys, command, "--resume", explored, *words)


def test_what_is_no_run_is_refused(
    explored: Path, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    assert "does not exist" in refusal(capsys, "explore", "--resume", tmp_path / "x")
    assert "holds no command.json" in refusal(capsys, "explore", "--resume", room)
    assert "was written by explore" in refusal(capsys, "learn", "--resume", explored)
    assert "expected one, or --resume RUN" in refusal(capsys, "learn")
    out = tmp_path / "out"
    killed_at(4, out, monkeypatch, room, "--steps", "5")
    for name, found in (("state.npz", "damaged"), ("command.json", "is damaged")):
        content = (out / name).read_bytes()
        (out / name).write_bytes(content[:-90] + b"\0" + content[-89:])
        assert found in refusal(capsys, "explore", "--resume", out)
        (out / name).write_bytes(content)
    steps = (out / "steps.csv").read_bytes()
    (out / "steps.csv").write_bytes(steps[:40])
    assert "holds 40 bytes, not the" in refusal(capsys, "explore", "--resume", out)


def test_other_frames_than_before_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    source, out = tmp_path / "source", tmp_path / "out"
    write_folder(source, 8)
    killed_at(4, out, monkeypatch, source, "--steps", "5")
    write_folder(source, 9)
    assert "over other frames than the source" in refusal(capsys, "explore", "--resume", out)


@pytest.mark.usefixtures("no_report")
def test_strategy_that_cannot_be_kept_is_told_of(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    held = OWN.replace("Mine", "Held").replace("Counter()\n", "Counter()\n        self.f = open\n")
    Path("held.py").write_text(held)
    monkeypatch.setattr(Keeping, "is_due", lambda _: True)
    words = ("explore", room, "--strategy", "held:Held", "--steps", "3", "--out", "out")
    outcome = succeed(capsys, *words)
    assert "builtins.builtin_function_or_method cannot be kept: --resume would" in outcome.err
    assert SaliencyLearner.load("out/model.npz").is_trained
