"""Cameras as live sources: the newest frame, what is said when there is none, watching one."""

from __future__ import annotations

import builtins
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from command import call, files, refusal, succeed
from curiosight.experiments import camera_start
from curiosight.experiments.camera_start import FirstFrames
from curiosight.robot.cameras import opening
from curiosight.robot.cameras.camera import CameraFeed, Device
from curiosight.robot.cameras.opening import OPENERS, open_camera
from curiosight.robot.cameras.pairing import Pairing
from curiosight.robot.feed import EndedError
from curiosight.worlds.sources import CAMERAS
from drawn_cameras import DrawnCamera, at_its_end, room_views, shots_of
from scan_writers import write_video
from test_watch_command import KEPT, rows_of

Capsys = pytest.CaptureFixture[str]


def test_newest_wins_and_only_what_is_asked_for_is_decoded() -> None:
    device = DrawnCamera(12, after=at_its_end())
    feed = CameraFeed(device)
    first = feed.newest(1.0)
    assert first is not None
    time.sleep(0.3)
    second = feed.newest(0.0)
    assert second is not None
    assert int(first.frame.id) - int(second.frame.id) > 3
    assert second.taken_at > first.taken_at
    rest, end = shots_of(feed)
    assert isinstance(end, EndedError)
    assert (rest or [second])[-1].frame.id == "0"  # what came before the end is given
    assert device.n_decoded == 2 + len(rest)
    assert feed.n_missed == 12 - device.n_decoded
    feed.close()
    feed.close()
    assert device.is_closed


def test_silent_camera_is_said_and_is_no_hang() -> None:
    feed = CameraFeed(DrawnCamera(2), silent_s=0.3)
    shots, end = shots_of(feed)
    assert shots
    assert str(end) == (
        "drawn: has given no frame for 0.3 s (it was drawn so); see that it is plugged in, and "
        "start again"
    )
    feed.close()


def test_what_was_seen_at_one_moment_is_paired() -> None:
    pairs = Pairing[float](lambda one, other: abs(one - other), 0.6)
    told = [(1, 0.0), (1, 1.0), (0, 1.1), (0, 2.0), (0, 3.2), (1, 3.0), (1, 4.1), (0, 4.9)]
    assert [pairs.add(stream, at) for stream, at in told] == [
        *[None, None, (1.1, 1.0)],
        *[None, None, (3.2, 3.0)],
        *[None, None],
    ]


def refusal_after_notes(capsys: Capsys, *arguments: Any) -> str:
    """Run a command that says what it sees before it fails; return its last line."""
    outcome = call(capsys, *arguments)
    assert outcome.status == 2
    assert outcome.out == ""
    return outcome.err.splitlines()[-1]


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("video") / "room.mp4"
    write_video(path, [view.rgb for view in room_views()] * 25)
    return path


def test_video_stands_in_for_a_camera_at_its_own_pace(video: Path) -> None:
    feed = open_camera(f"camera:{video}")
    fps = cv2.VideoCapture(str(video)).get(cv2.CAP_PROP_FPS)
    shots = [shot for _ in range(8) if (shot := feed.newest(1.0)) is not None]
    stamps = np.array([shot.frame.stamp_ns for shot in shots], float) / 1e9
    taken = np.array([shot.taken_at for shot in shots])
    assert np.allclose(np.round(stamps * fps), stamps * fps, atol=1e-6)
    assert taken[-1] - taken[0] > stamps[-1] - stamps[0] - 0.05  # never faster
    view = room_views()[round(stamps[-1] * fps) % len(room_views())]
    assert np.abs(shots[-1].frame.rgb.astype(int) - view.rgb).mean() < 8
    time.sleep(0.8)  # nobody asks: it waits
    shot = feed.newest(1.0)
    assert shot is not None
    assert shot.frame.stamp_ns is not None
    assert shot.frame.stamp_ns / 1e9 - stamps[-1] < 0.75
    feed.close()


def test_kinds_of_cameras_are_known_by_all() -> None:
    assert tuple(f"{kind}:" for kind in OPENERS) == CAMERAS
    with pytest.raises(ValueError, match="expected one of realsense, oak, camera, got 'kinect'"):
        open_camera("kinect:1")


def test_there_is_no_such_camera(capsys: Capsys, model: Path, tmp_path: Path) -> None:
    nothing = tmp_path / "nothing.mp4"
    nothing.write_text("no video")
    watch = "watch", "--model", model
    line = refusal(capsys, *watch, "camera:77")
    assert line.startswith("curiosight: camera:77: there is no camera 77 (looked for /dev/video77)")
    assert "no such device or video" in refusal(capsys, *watch, f"camera:{tmp_path / 'x.mp4'}")
    assert "is no video" in refusal(capsys, *watch, f"camera:{nothing}")


@pytest.mark.parametrize(("kind", "package"), [("realsense", "pyrealsense2"), ("oak", "depthai")])
def test_missing_extra_is_named(
    capsys: Capsys, monkeypatch: pytest.MonkeyPatch, kind: str, package: str
) -> None:
    usual = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == package:
            raise ModuleNotFoundError(name)
        return usual(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    line = refusal(capsys, "watch", f"{kind}:", "--learn")
    assert line == (
        f"curiosight: {kind}: needs {package}, which is missing; pip install 'curiosight[{kind}]'"
    )


def test_missing_library_of_the_system_is_named(
    capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "pyrealsense2":
            raise ImportError("libusb-1.0.so.0: cannot open shared object file")
        return usual(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    assert refusal(capsys, "watch", "realsense:", "--learn") == (
        "curiosight: realsense: pyrealsense2 cannot be loaded (libusb-1.0.so.0: cannot open shared "
        "object file); install that library; libusb is libusb-1.0-0 on Debian and Ubuntu"
    )


def test_only_watch_takes_a_camera(capsys: Capsys) -> None:
    for command in ("info", "segment"):
        line = refusal(capsys, command, "camera:0")
        assert "the live camera camera:0, which `curiosight watch` looks through" in line


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Callable[[Device], None]:
    """Put a camera in the place of all, which needs less time to look round."""
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.3)

    def put(device: Device) -> None:
        monkeypatch.setitem(opening.OPENERS, "realsense", lambda which: device)

    return put


def test_camera_is_watched_and_learned_from(
    capsys: Capsys, drawn: Callable[[Device], None], tmp_path: Path
) -> None:
    device = DrawnCamera()
    drawn(device)
    out = tmp_path / "run"
    told = succeed(capsys, "watch", "realsense:", "--learn", "--seconds", 1, "--out", out, "--json")
    summary = json.loads(told.out)
    assert summary["source"] == "drawn"
    assert summary["learned"] > 0
    assert summary["maps"] > 3
    assert summary["strategy"] == "iac"
    assert summary["goal"] in {region["id"] for region in summary["regions"]}
    assert summary["why"]["text"]
    assert files(out) == KEPT | {"camera.npz", "model.npz"}
    assert {row["region"] for row in rows_of(out / "looks.csv")} <= {
        str(region["id"]) for region in summary["regions"]
    }
    assert device.is_closed


@pytest.mark.parametrize("after", [None, at_its_end()])
def test_camera_that_is_gone_ends_it_and_all_is_kept(
    capsys: Capsys,
    drawn: Callable[[Device], None],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    after: Exception | None,
) -> None:
    device = DrawnCamera(60, after=after)
    drawn(device)
    monkeypatch.setattr(opening, "CameraFeed", lambda device: CameraFeed(device, silent_s=0.5))
    out = tmp_path / "run"
    told = call(capsys, "watch", "realsense:", "--learn", "--out", out)
    assert files(out) == KEPT | {"camera.npz", "model.npz"}
    assert "written to" in told.out
    if after is None:
        assert told.status == 2
        last = told.err.splitlines()[-1]
        assert last.startswith("curiosight: drawn: has given no frame for 0.5 s")
    else:
        assert told.status == 0
        assert "drawn is at its end" in told.err


def test_camera_that_never_gives_a_frame_is_refused(
    capsys: Capsys, drawn: Callable[[Device], None], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    drawn(DrawnCamera(0, after=at_its_end()))
    assert "drawn: has no frames" in refusal(capsys, "watch", "realsense:", "--learn")
    assert list(tmp_path.iterdir()) == []


def test_video_that_ends_while_it_looks_round_is_refused(
    capsys: Capsys, drawn: Callable[[Device], None], tmp_path: Path
) -> None:
    drawn(DrawnCamera(5, after=at_its_end()))
    line = refusal_after_notes(capsys, "watch", "realsense:", "--learn", "--out", tmp_path / "run")
    assert line == ("curiosight: drawn: was at its end before the first map; give a longer one")


def test_colour_alone_is_mapped_and_teaches_nothing(
    capsys: Capsys, monkeypatch: pytest.MonkeyPatch, model: Path, video: Path, tmp_path: Path
) -> None:
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.3)
    source, out = f"camera:{video}", tmp_path / "run"
    line = refusal(capsys, "watch", source, "--learn", "--model", model)
    assert line == (
        f"curiosight: learn: expected a camera with depth, {source} sees colour alone: it is "
        "mapped, with --model RUN"
    )
    told = succeed(
        capsys, "watch", source, "--model", model, "--seconds", 0.5, "--out", out, "--json"
    )
    summary = json.loads(told.out)
    assert summary["maps"] > 0
    assert summary["looks"] == 0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--teacher", "masks:there"), "teacher: expected depth for a camera"),
        (("--depth-scale", 0.001), "reading: expected nothing of a live camera"),
    ],
)
def test_what_no_camera_can_follow_is_refused(
    capsys: Capsys, given: tuple[Any, ...], said: str
) -> None:
    assert said in refusal(capsys, "watch", "realsense:", "--learn", *given)


def test_frames_are_recognised_by_their_look(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.1)
    feed = CameraFeed(DrawnCamera(30, after=at_its_end()))
    first = FirstFrames(feed, 4)
    assert len({frame.id for frame in (first[number] for number in range(4))}) == 4
    assert len(first) == 4
    shots, _ = shots_of(first.rest)
    for shot in shots:
        assert shot.index is not None
        assert int(shot.frame.id) % 4 == int(first[shot.index].id) % 4
    feed.close()
