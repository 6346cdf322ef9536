"""A run that continues another keeps regions, progress and memory where the rooms are the same."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import refusal, succeed
from curiosight.config import Config
from curiosight.errors import DataError
from curiosight.experiments.handing_on import (
    Continued,
    HandedOn,
    RecentLooks,
    Rooms,
    own_regions,
)
from curiosight.experiments.snapshot import STATE, Snapshot
from curiosight.explorer import Regions
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Pose, Viewpoint
from recordings import write_folder
from room import poses_around
from test_resume import EXPLORED, bytes_of, killed_at

Capsys = pytest.CaptureFixture[str]
POSES = poses_around(8)


class Views:
    """A dataset, as far as it tells which rooms it shows."""

    def __init__(
        self, path: str, poses: Sequence[Pose | None] = POSES, ids: Sequence[str] | None = None
    ) -> None:
        self.name, self.path, self.poses = "views", path, poses
        self.ids = ids or [str(number) for number in range(len(poses))]

    def __len__(self) -> int:
        return len(self.ids)


def regions_of(n: int, n_regions: int = 4) -> Regions:
    names = tuple(f"r{number}" for number in range(n_regions))
    return Regions(np.arange(n) * n_regions // n, names, "time:4")


def hand_on(run: Path, dataset: Any, *, spec: str = "") -> Path:
    """Write what a run over a dataset hands on; return its model file."""
    looks = RecentLooks()
    for number in range(20):
        looks.add(number % len(dataset), 1 - 0.04 * number if number % 5 else None)
    config = Config()
    if spec:
        config = replace(config, explorer=replace(config.explorer, regions=spec))
    rooms = Rooms.of(config, dataset, regions_of(len(dataset)))
    run.mkdir(exist_ok=True)
    Snapshot("1", dataset.ids, {}).write(run / STATE, {"a": HandedOn(rooms, looks, None), "b": 1})
    return run / "model.npz"


class Told:
    """A strategy that keeps what it is told."""

    def __init__(self) -> None:
        self.looks: list[tuple[int, Outcome]] = []

    def update(self, viewpoint: Viewpoint, outcome: Outcome) -> None:
        self.looks.append((viewpoint.index, outcome))


def told_to(continued: Continued, dataset: Any, regions: Regions, ways: Any = None) -> Told:
    views = [
        Viewpoint(index, int(region), dataset.poses[index])
        for index, region in enumerate(regions.of_view)
    ]
    strategy: Any = Told()
    continued.tell(strategy, views, ways)
    told: Told = strategy
    return told


def test_same_frames_have_the_same_regions_and_their_looks(tmp_path: Path) -> None:
    dataset: Any = Views("/there")
    continued = Continued(hand_on(tmp_path, dataset), Config(), dataset, "1")
    regions = continued.regions()
    assert regions is not None
    assert regions.of_view.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    assert regions.names == ("r0", "r1", "r2", "r3")

    def ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> Any:
        return np.array([abs(goal.index - start.index) * 2.0 for goal in goals])

    told = told_to(continued, dataset, regions, ways)
    assert [index for index, _ in told.looks] == [number % 8 for number in range(20)]
    assert [outcome.error for _, outcome in told.looks[:3]] == [None, 0.96, 0.92]
    assert [outcome.seconds for _, outcome in told.looks[6:10]] == [2.0, 2.0, 14.0, 2.0]
    assert continued.notes == [
        "4 regions are those of that run",
        "progress of regions goes on, by the last 20 looks",
    ]
    kept = own_regions(tmp_path / STATE, dataset)
    assert kept is not None
    assert kept.of_view.tolist() == regions.of_view.tolist()
    other: Any = Views("/there", POSES[:3])
    assert own_regions(tmp_path / STATE, other) is None


def test_same_home_in_another_light_from_other_views(tmp_path: Path) -> None:
    """Fewer views, in another order: each is of the region of the one beside it."""
    before: Any = Views("home:7,rooms=3")
    poses = [POSES[number] for number in (7, 3, 2)]
    now: Any = Views("home:7,rooms=3,lights=4,views=20", poses, ["a", "b", "c"])
    continued = Continued(hand_on(tmp_path, before), Config(), now, "1")
    regions = continued.regions()
    assert regions is not None
    assert regions.names == ("r1", "r3")
    assert regions.of_view.tolist() == [1, 0, 0]
    told = told_to(continued, now, regions)
    assert len(told.looks) == 20
    for number, (index, _) in enumerate(told.looks):
        pose = POSES[number % 8]
        apart = [
            np.hypot(*(np.linalg.norm(pose[:3, k] - other[:3, k]) for k in (2, 3)))
            for other in poses
        ]
        assert apart[index] == pytest.approx(min(apart))
        assert apart[index] < 1.5


@pytest.mark.parametrize(
    ("before", "now", "is_same"),
    [
        (Views("/a"), Views("/b"), True),  # by their poses, wherever they lie
        (Views("/a", [None] * 4), Views("/a", [None] * 4), True),
        (Views("/a", [None] * 4), Views("/b", [None] * 4), False),
        (Views("/a"), Views("/a", POSES[:5]), False),
        (Views("/a"), Views("/a", POSES[::-1]), False),
        (Views("home:7"), Views("home:7,rearrange=2", POSES[:5]), True),
        (Views("home:7"), Views("home:8", POSES[:5]), False),
        (Views("home:7"), Views("room:7", POSES[:5]), False),
        (Views("room:7,path=drive"), Views("room:7,lights=1", POSES[:5]), True),
        (Views("home:7"), Views("home:7,rooms=5", POSES[:5]), False),
    ],
)
def test_which_rooms_are_the_same(before: Any, now: Any, is_same: bool, tmp_path: Path) -> None:
    continued = Continued(hand_on(tmp_path, before), Config(), now, "1")
    assert (continued.notes == []) == is_same
    if not is_same:
        assert continued.regions() is None
        assert continued.notes == [
            "regions, their progress and the teacher's memory begin anew: "
            f"{before.path} shows other rooms"
        ]


def test_what_begins_anew_is_said(tmp_path: Path) -> None:
    dataset: Any = Views("home:7")
    model = hand_on(tmp_path, dataset, spec="time:4")
    config = Config()
    assert "they are of curiosight 1" in Continued(model, config, dataset, "2").notes[0]
    alone = Continued(tmp_path / "x.npz", config, dataset, "1")
    assert "has no state.npz beside it" in alone.notes[0]
    for spec, is_kept in (("time:4", True), ("", True), ("pose", False)):
        asked = replace(config, explorer=replace(config.explorer, regions=spec))
        continued = Continued(model, asked, dataset, "1")
        assert (continued.regions() is not None) == is_kept
        assert continued.notes == [
            "4 regions are those of that run"
            if is_kept
            else "regions begin anew: pose is asked for"
        ]
    far = POSES[0].copy()
    far[:3, 3] += 50
    elsewhere: Any = Views("home:7,lights=1", [POSES[1], far])
    continued = Continued(model, config, elsewhere, "1")
    assert continued.regions() is None
    assert continued.notes == ["regions begin anew: some views are of where there was none"]
    model.parent.joinpath(STATE).write_bytes(b"PK no zip")
    with pytest.raises(DataError, match="not a curiosight file, or a damaged one"):
        Continued(model, config, dataset, "1")


def test_recent_looks_are_the_last() -> None:
    looks = RecentLooks(3)
    for number in range(5):
        looks.add(number, None if number == 3 else number / 10, has_changed=number == 4)
    assert list(looks) == [(2, 0.2, False), (3, None, False), (4, 0.4, True)]


@pytest.mark.usefixtures("no_report")
def test_exploration_goes_on_where_the_rooms_are_the_same(
    room: Path, model: Path, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second, other = tmp_path / "first", tmp_path / "second", tmp_path / "other"
    words = ("explore", room, "--steps", 9, "--quiet")
    succeed(capsys, *words, "--regions", "time:3", "--out", first)
    again = ("explore", room, "--steps", 4, "--from", first, "--out")
    told = succeed(capsys, *again, second).err
    for said in (
        "goes on with the samples, trees and places of that model",
        "3 regions are those of that run",
        "progress of regions goes on, by the last 9 looks",
        "the teacher remembers what it did",
    ):
        assert said in told
    # What is handed on is handed on again; the progress is known from the first step on.
    steps = (second / "steps.csv").read_text().splitlines()
    assert all(line.split(",")[4] for line in steps[1:])
    third = succeed(
        capsys, "explore", room, "--steps", 1, "--from", second, "--out", tmp_path / "3"
    )
    assert "by the last 4 looks" in third.err
    write_folder(other, 5)
    told = succeed(
        capsys, "explore", other, "--steps", 2, "--from", first, "--out", tmp_path / "4"
    ).err
    assert f"begin anew: {room} shows other rooms" in told
    told = succeed(
        capsys, "explore", room, "--steps", 2, "--from", model, "--out", tmp_path / "5"
    ).err
    assert "has no state.npz beside it" in told
    # Killed, it goes on to the same bytes, though its own settings do not name the regions.
    out = tmp_path / "killed"
    killed_at(3, out, monkeypatch, room, "--steps", "4", "--from", str(first), every=2)
    shutil.rmtree(first)
    succeed(capsys, "explore", "--resume", out, "--quiet")
    assert bytes_of(out, EXPLORED) == bytes_of(second, EXPLORED)


@pytest.fixture
def no_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing at the end of a run, which takes longer than the run."""
    monkeypatch.setattr("curiosight.cli.explore.tell_run", lambda *_: None)


@pytest.mark.usefixtures("no_report")
def test_watch_goes_on_with_an_exploration_and_one_with_a_watch(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    explored, watched = tmp_path / "explored", tmp_path / "watched"
    words = ("explore", room, "--steps", 6, "--regions", "time:2", "--quiet", "--out", explored)
    succeed(capsys, *words)
    again = ("watch", room, "--learn", "--model", explored, "--seconds", 0.5, "--out", watched)
    told = succeed(capsys, *again).err
    assert "2 regions are those of that run" in told
    assert "progress of regions goes on, by the last 6 looks" in told
    assert "the teacher remembers what it did" in told
    words = ("explore", room, "--steps", 1, "--from", watched, "--out", tmp_path / "again")
    assert "2 regions are those of that run" in succeed(capsys, *words).err
    (watched / STATE).write_bytes(b"no state")
    assert "not a curiosight file" in refusal(capsys, *words[:-1], tmp_path / "x", "--quiet")
