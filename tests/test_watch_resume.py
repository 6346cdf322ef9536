"""A watch that was killed goes on with all it had learned but one frame, and says what it lacks."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Outcome, call, files, refusal, succeed
from curiosight.experiments import camera_start
from curiosight.experiments.journal import JOURNAL, read_journal
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.watched import Watched
from curiosight.experiments.watching import Watching
from curiosight.learner.archive import read_archive
from curiosight.learner.drift import Alarm, Event
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.model_file import KIND
from curiosight.robot.cameras import opening
from curiosight.robot.watch import N_EVENTS, Watch
from curiosight.teacher import TemporalTeacher
from drawn_cameras import DrawnCamera, at_its_end
from kills import Killer, killer
from test_resume import OWN
from test_watch_command import KEPT, rows_of

Capsys = pytest.CaptureFixture[str]


class Killed(BaseException):
    """Stands for a kill: nothing that comes after it is done."""


@pytest.fixture(scope="module")
def kills() -> Iterator[Killer]:
    with killer() as one:
        yield one


def arrays_of(learner: SaliencyLearner, path: Path) -> dict[str, Any]:
    """Return all that a model is but its notes, which are made as it is written."""
    learner.save(path, is_packed=False)
    return without_notes(path)


def without_notes(path: Path) -> dict[str, Any]:
    header, arrays = read_archive(path, KIND)
    return {name: one.tobytes() for name, one in arrays.items()} | {
        name: one for name, one in header.items() if name != "notes"
    }


@pytest.fixture
def at_start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """What a watch knew as it began to watch; it then ends after one more look."""
    found: dict[str, Any] = {}
    run = Watching.run

    def looking(watching: Watching, seconds: object, is_wanted: object) -> Iterator[float]:
        found["model"] = arrays_of(watching.learner, tmp_path / "at-start.npz")
        found["chance"] = watching.learner.rng.bit_generator.state
        found["n_looks"] = watching.so_far.n_looks
        found["watching"] = watching
        return run(watching, None, lambda: watching.watch.looks.n <= found["n_looks"])

    monkeypatch.setattr(Watching, "run", looking)
    return found


def killed_at(
    look: int,
    out: Path,
    monkeypatch: pytest.MonkeyPatch,
    *words: str | Path,
    every: int = 4,
    then: Callable[[Watching], None] = lambda _: None,
) -> None:
    """Watch, and be ended without anything being written, once a look is kept."""
    copy, note, n_looks = out.with_name(f"{out.name}-killed"), Watching._note, Counter[int]()

    def is_due(keeping: Keeping) -> bool:
        n_looks[id(keeping)] += 1
        return n_looks[id(keeping)] % every == 0

    def noting(watching: Watching, one: Any) -> None:
        note(watching, one)
        if one.number == look:
            shutil.copytree(out, copy)
            (copy / ".curiosight.lock").unlink()
            then(watching)
            raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(Watching, "_note", noting)
        patch.setattr(Keeping, "is_due", is_due)
        with pytest.raises(Killed):
            run(["watch", *map(str, words), "--out", str(out), "--quiet"])
    shutil.rmtree(out)
    copy.rename(out)


def run(words: list[str]) -> int:
    from curiosight.cli.app import run as run_command

    return run_command(words)


def test_kill_at_any_moment_loses_one_frame_at_most(
    kills: Killer, room: Path, tmp_path: Path, capsys: Capsys, at_start: dict[str, Any]
) -> None:
    """The model that goes on is the one that was killed, or it before its last frame."""
    rng, n_killed = np.random.default_rng(17), 0
    for number in range(3):
        out, aside = tmp_path / f"run-{number}", tmp_path / f"aside-{number}"
        aside.mkdir()
        words = ("watch", room, "--learn", "--out", out, "--quiet")
        is_timed = number < 1
        after_s = float(rng.uniform(2, 5)) if is_timed else None
        at = None if is_timed else int(rng.integers(25, 120))
        assert kills.kill(*words, after_s=after_s, at=at, aside=aside)
        n_known = len(list(aside.glob("*.json")))
        if not (out / "command.json").exists():
            continue
        check_readable(out)
        succeed(capsys, "watch", "--resume", out, "--quiet")
        n_looks = at_start["n_looks"]
        assert n_known - 1 <= n_looks <= n_known
        if n_looks:
            n_killed += 1
            assert at_start["model"] == without_notes(aside / f"{n_looks - 1}.npz")
            chance = json.loads((aside / f"{n_looks - 1}.json").read_text())
            assert at_start["chance"] == chance
        looks = [int(row["look"]) for row in rows_of(out / "looks.csv")]
        assert looks == list(range(len(looks)))
        assert len(looks) > n_looks
    assert n_killed >= 2


def test_what_changed_before_a_kill_is_told_after_it(
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
    at_start: dict[str, Any],
) -> None:
    """From the state, and from the journal behind it; no more than the last ones."""
    out, known = tmp_path / "out", {}
    alarm = Alarm(-1, "tint", 0.1, 0.4, 7)

    def observe(learner: SaliencyLearner, *arguments: Any) -> Any:
        """As if each look showed that its place is another."""
        observation = OBSERVE(learner, *arguments)
        return replace(observation, change=observation.change._replace(alarm=alarm))

    def note(watching: Watching) -> None:
        known["events"] = watching.watch.events
        known["record"] = read_journal(out / JOURNAL).records[-1]

    monkeypatch.setattr(SaliencyLearner, "observe", observe)
    with monkeypatch.context() as patch:
        patch.setattr(Watching, "run", RUN)
        killed_at(10, out, monkeypatch, room, "--learn", then=note)
    events = [Event(look, event.id, alarm) for look, event in enumerate(known["events"])]
    assert list(known["events"]) == events
    assert len(events) == 11
    succeed(capsys, "watch", "--resume", out)
    watching: Watching = at_start["watching"]
    assert list(watching.watch.events)[:11] == events
    told = json.loads((out / "summary.json").read_text())["alarms"]
    assert told[:11] == [event.summary() for event in events]
    assert watching.shown.state()["alarms"] == told
    so_far = Watched()
    for number in range(N_EVENTS + 5):
        record = replace(known["record"], number=number, alarm=alarm if number % 2 else None)
        so_far.add(record, comes_again=True, is_learning=True)
        assert len(so_far.events) == min((number + 1) // 2, N_EVENTS)
    assert known["record"].alarm == alarm
    for number in range(2 * N_EVENTS):
        record = replace(known["record"], number=number)
        so_far.add(record, comes_again=True, is_learning=True)
    assert [event.look for event in so_far.events] == list(range(N_EVENTS, 2 * N_EVENTS))


def check_readable(out: Path) -> None:
    for name in ("command.json", "summary.json"):
        if (out / name).exists():
            json.loads((out / name).read_text())
    for name, kind in (("model.npz", KIND), ("state.npz", "state of a run")):
        if (out / name).exists():
            read_archive(out / name, kind)
    if (out / JOURNAL).exists():
        assert read_journal(out / JOURNAL).n_cut == 0
    for path in out.glob("*.csv"):
        assert path.read_bytes()[-1:] in (b"", b"\n")


def test_all_that_a_watch_had_come_to_goes_on(
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
    at_start: dict[str, Any],
) -> None:
    """Model, chance, regions, the strategy, the teacher's memory, counters and tables."""
    settings, out, known = tmp_path / "s.toml", tmp_path / "out", {}
    settings.write_text("[teacher]\ntemporal = true\n")

    def note(watching: Watching) -> None:
        known["model"] = arrays_of(watching.learner, tmp_path / "known.npz")
        known["regions"], known["curves"] = watching.advice.regions(), watching.advice.curves()
        known["why"], known["looks"] = watching.advice.why(), (out / "looks.csv").read_bytes()
        known["lessons"] = watching.lessons.summary()

    words = (room, "--learn", "--config", settings, "--seed", "3")
    with monkeypatch.context() as patch:
        patch.setattr(Watching, "run", RUN)
        killed_at(10, out, monkeypatch, *words, then=note)
    assert len(read_journal(out / JOURNAL).records) == 3  # of looks 8, 9 and 10
    last = read_journal(out / JOURNAL).records[-1]
    told = succeed(capsys, "watch", "--resume", out)
    assert "goes on after 11 looks" in told.err
    watching: Watching = at_start["watching"]
    assert at_start["n_looks"] == 11
    assert at_start["model"] == known["model"]
    assert (out / "looks.csv").read_bytes().startswith(known["looks"])
    teacher = watching.watch.teacher
    assert isinstance(teacher, TemporalTeacher)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["learned"] >= summary["looks"] >= 11
    assert summary["maps"] > last.counts.maps
    assert summary["seconds"] > last.seconds
    assert summary["seed"] == 3
    assert known["lessons"]["looks"] <= summary["taught_nothing"]["looks"]
    n_before = {one["id"]: one["n_looks"] for one in known["regions"]}
    assert sum(n_before.values()) == 11
    for one in summary["regions"]:
        assert one["n_looks"] >= n_before[one["id"]]
    errors = [value for _, value in watching.advice.curves()["error"]]
    assert errors[:11] == [value for _, value in known["curves"]["error"]]
    assert files(out) == KEPT | {"model.npz"}


RUN, OBSERVE = Watching.run, SaliencyLearner.observe


def test_teacher_remembers_each_frame_once(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    """Also one that it had labelled, but that was not learned from when the state was written."""
    settings, out, n_views = tmp_path / "s.toml", tmp_path / "out", []
    settings.write_text("[teacher]\ntemporal = true\n")
    for look in (7, 8):
        killed_at(look, out, monkeypatch, room, "--learn", "--config", settings)
        last = read_journal(out / JOURNAL).records
        with monkeypatch.context() as patch:
            patch.setattr(Watch, "start", lambda watch: n_views.append(views_of(watch)))
            patch.setattr(Watch, "wait", lambda *_: True)
            call(capsys, "watch", "--resume", out)
        n_taught = last[-1].verdict if last else look + 1
        assert n_taught <= n_views[-1] <= n_taught + 1
        shutil.rmtree(out)


def views_of(watch: Watch) -> int:
    teacher = watch.teacher
    assert isinstance(teacher, TemporalTeacher)
    assert teacher.votes._n_views == watch.n_taught
    return watch.n_taught


def resumed(capsys: Capsys, out: Path, *words: str | Path | int) -> Outcome:
    return succeed(capsys, "watch", "--resume", out, *words)


def test_watch_that_ended_by_itself_is_over(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = tmp_path / "out"
    succeed(capsys, "watch", room, "--learn", "--seconds", 1, "--out", out)
    before = {name: (out / name).read_bytes() for name in files(out)}
    n_looks = json.loads(before["summary.json"])["looks"]
    told = resumed(capsys, out)
    looks = "1 look" if n_looks == 1 else f"{n_looks} looks"
    assert told.err == (
        f"{out}: the watch is finished after {looks}: the seconds that it was to last are over\n"
    )
    assert told.out == ""
    assert {name: (out / name).read_bytes() for name in files(out)} == before


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("home:1",), "expected no SOURCE beside it"),
        (("--learn",), "expected no --learn beside it"),
        (("--seconds", 3), "expected no --seconds beside it"),
        (("--model", "x"), "expected no --model beside it"),
        (("--strategy", "iac"), "expected no --strategy beside it"),
        (("--out", "x"), "expected no --out beside it"),
        (("--seed", 3), "expected no --seed beside it"),
    ],
)
def test_other_settings_are_refused(
    words: tuple[Any, ...], named: str, tmp_path: Path, capsys: Capsys
) -> None:
    assert named in refusal(capsys, "watch", *words, "--resume", tmp_path)


def test_what_is_no_watch_is_refused(
    room: Path, model: Path, tmp_path: Path, capsys: Capsys
) -> None:
    assert "SOURCE: expected one, or --resume RUN" in refusal(capsys, "watch")
    assert "does not exist" in refusal(capsys, "watch", "--resume", tmp_path / "x")
    assert "holds no command.json" in refusal(capsys, "watch", "--resume", room)
    line = refusal(capsys, "watch", "--resume", model)
    assert "was written by " in line
    assert ", not by watch; " in line


def test_damage_is_told(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    """A record that a power cut left half is said; any other damage is refused in a line."""
    out, kept = tmp_path / "out", tmp_path / "kept"
    killed_at(6, out, monkeypatch, room, "--learn", "--seconds", "1000", every=1000)
    shutil.copytree(out, kept)
    journal, command = (out / JOURNAL).read_bytes(), (out / "command.json").read_bytes()

    def damaged(name: str, content: bytes) -> str:
        shutil.rmtree(out)
        shutil.copytree(kept, out)
        (out / name).write_bytes(content)
        return refusal(capsys, "watch", "--resume", out, "--quiet")

    middle = len(journal) // 2
    other = bytes(255 - one for one in journal[middle : middle + 4])
    found = damaged(JOURNAL, journal[:middle] + other + journal[middle + 4 :])
    assert f"{out / JOURNAL}: is damaged behind its record 3, and more follow" in found
    assert "journal.bin: is damaged, or no journal of ours" in damaged(JOURNAL, b"no" + journal)
    for seconds in (b"-1", b"true", b"NaN", b'"x"'):
        content = command.replace(b'"seconds": 1000.0', b'"seconds": ' + seconds)
        assert "command.json: is damaged" in damaged("command.json", content)
    state = (kept / "state.npz").read_bytes()
    assert "damaged" in damaged("state.npz", state[:-90] + b"\0" + state[-89:])
    looks = (kept / "looks.csv").read_bytes()
    assert "holds 4 bytes, not the" in damaged("looks.csv", looks[:4])
    start = journal.index(b"\xc5rec")
    second = journal.index(b"\xc5rec", start + 1)
    assert "lacks look 0, and goes on with 1" in damaged(
        JOURNAL, journal[:start] + journal[second:]
    )
    shutil.rmtree(out)
    shutil.copytree(kept, out)
    (out / JOURNAL).write_bytes(journal[:-100])
    with monkeypatch.context() as patch:
        patch.setattr(Watch, "wait", lambda *_: True)
        told = call(capsys, "watch", "--resume", out)
    assert "the journal's last record is not whole" in told.err
    assert "goes on after 6 looks" in told.err


def test_camera_goes_on_with_new_frames_in_the_same_regions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys, at_start: dict[str, Any]
) -> None:
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.3)
    monkeypatch.setitem(opening.OPENERS, "realsense", lambda which: DrawnCamera())
    out, known = tmp_path / "out", {}

    def note(watching: Watching) -> None:
        known["model"] = arrays_of(watching.learner, tmp_path / "known.npz")
        known["regions"] = watching.regions
        known["survey"] = watching.watch.teacher

    with monkeypatch.context() as patch:
        patch.setattr(Watching, "run", RUN)
        killed_at(5, out, monkeypatch, "realsense:", "--learn", then=note)
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 1000)  # it does not look round again
    told = resumed(capsys, out)
    assert "drawn: known from before" in told.err
    assert at_start["model"] == known["model"]
    assert at_start["n_looks"] == 6
    watching: Watching = at_start["watching"]
    assert np.array_equal(watching.regions.of_view, known["regions"].of_view)
    rows = rows_of(out / "looks.csv")
    assert len(rows) > 6
    assert watching.regions.kind == known["regions"].kind == "places"
    content = (out / "camera.npz").read_bytes()
    (out / "camera.npz").write_bytes(content[:400] + b"\0\0" + content[402:])
    (out / "summary.json").unlink()
    assert "camera.npz: not a curiosight file, or a damaged one" in refusal(
        capsys, "watch", "--resume", out, "--quiet"
    )


def test_camera_that_is_at_its_end_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.3)
    monkeypatch.setitem(
        opening.OPENERS, "realsense", lambda which: DrawnCamera(60, after=at_its_end())
    )
    out = tmp_path / "out"
    succeed(capsys, "watch", "realsense:", "--learn", "--out", out)
    assert resumed(capsys, out).err.endswith(": drawn is at its end\n")


def test_strategy_that_cannot_be_kept_begins_anew_and_all_else_goes_on(
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
    at_start: dict[str, Any],
) -> None:
    monkeypatch.chdir(tmp_path)
    held = OWN.replace("Mine", "Held").replace("Counter()\n", "Counter()\n        self.f = open\n")
    Path("held.py").write_text(held)
    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr(Watching, "run", RUN)
        killed_at(6, out, monkeypatch, room, "--learn", "--strategy", "held:Held")
    told = resumed(capsys, out)
    assert "builtins.builtin_function_or_method cannot be kept: with --resume the" in told.err
    assert "goes on after 7 looks" in told.err
    rows = rows_of(out / "looks.csv")
    # A recording is replayed on from the frame behind the last one.
    assert int(rows[7]["id"]) != int(rows[6]["id"])
    watching: Watching = at_start["watching"]
    assert watching.config.explorer.strategy == "held:Held"
    assert sum(one["n_looks"] for one in watching.advice.regions()) == len(rows)
