"""curiosight watch, as a user calls it: what it keeps, what it refuses, what its page answers."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from command import call, files, refusal, succeed
from curiosight.experiments import driving
from curiosight.experiments.driving import DrawnDrive, parse_drawn, plan_drive
from curiosight.experiments.watching import Watching
from curiosight.frame import Frame
from curiosight.learner.learner import SaliencyLearner
from curiosight.robot.state import KEYS
from curiosight.robot.watch import Watch
from curiosight.rooms import DrawnViews
from room import kinect, poses_around

Capsys = pytest.CaptureFixture[str]
KEPT = {"command.json", "config.toml", "looks.csv", "decisions.csv", "state.npz", "summary.json"}


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


class Visitor(threading.Thread):
    """Somebody who looks at a page, from its first answer on, until it is gone.

    presses: buttons and values, pressed in turn once maps are there.
    """

    def __init__(self, port: int, presses: tuple[tuple[str, Any], ...] = ()) -> None:
        super().__init__(daemon=True)
        self.url = f"http://127.0.0.1:{port}"
        self.presses = list(presses)
        self.states: list[dict[str, Any]] = []
        self.said: list[dict[str, Any]] = []
        self.html = self.jpeg = b""

    def run(self) -> None:
        until = time.monotonic() + 60
        while time.monotonic() < until:
            try:
                self.look()
            except (OSError, urllib.error.URLError):
                if self.states:
                    return
            time.sleep(0.02)

    def look(self) -> None:
        state = json.loads(self.ask("/state.json"))
        self.states.append(state)
        if state["map_hz"] is None:
            return
        self.html = self.html or self.ask("/")
        self.jpeg = self.jpeg or self.ask("/saliency.jpg")
        if self.presses and state["goal"] is not None:
            name, value = self.presses.pop(0)
            self.said.append(json.loads(self.ask(f"/{name}", json.dumps(value).encode())))

    def ask(self, path: str, body: bytes | None = None) -> bytes:
        with urllib.request.urlopen(self.url + path, body, timeout=20) as answer:
            content: bytes = answer.read()
        return content


@contextmanager
def visiting(*presses: tuple[str, Any]) -> Iterator[tuple[Visitor, int]]:
    port = free_port()
    visitor = Visitor(port, presses)
    visitor.start()
    yield visitor, port
    visitor.join(30)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_it_learns_while_its_page_tells(capsys: Capsys, room: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    presses = (("pin", 0), ("save", None), ("freeze", True), ("pause", True), ("pause", False))
    with visiting(*presses) as (visitor, port):
        told = succeed(
            capsys, "watch", room, "--learn", "--page", port, "--seconds", 3, "--out", out, "--json"
        )
    assert all(tuple(state) == KEYS for state in visitor.states)
    first, last = visitor.states[0], visitor.states[-1]
    assert first == {**dict.fromkeys(KEYS), "state": "preparing"}
    assert last["goal"] == 0
    assert last["why"]["text"] == "pinned by hand"
    assert last["learn_hz"] is not None
    assert b"<title>curiosight watch</title>" in visitor.html
    image = cv2.imdecode(np.frombuffer(visitor.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (120, 160, 3)
    assert [said["done"] for said in visitor.said] == [
        "pinned region 0",
        f"saved to {out / 'model.npz'}",
        "the model stays as it is",
        "paused",
        "goes on",
    ]
    summary = json.loads(told.out)
    assert summary["out"] == str(out)
    assert summary["seconds"] >= 3
    assert summary["maps"] > 10
    assert summary["learned"] > 0
    assert files(out) == KEPT | {"model.npz"}
    looks = rows_of(out / "looks.csv")
    assert len(looks) == summary["looks"] == sum(one["n_looks"] for one in summary["regions"])
    assert json.loads((out / "summary.json").read_text())["maps"] == summary["maps"]
    learner = SaliencyLearner.load(out)
    assert learner.is_trained
    assert learner.n_samples == int(looks[-1]["samples"])


def test_it_goes_on_with_a_model_and_leaves_that_as_it_was(
    capsys: Capsys, room: Path, model: Path, tmp_path: Path
) -> None:
    before, n_samples = (model / "model.npz").read_bytes(), SaliencyLearner.load(model).n_samples
    out = tmp_path / "run"
    succeed(capsys, "watch", room, "--model", model, "--learn", "--seconds", 0.5, "--out", out)
    assert (model / "model.npz").read_bytes() == before
    assert SaliencyLearner.load(out).n_samples > n_samples


@pytest.mark.parametrize("given", [(), ("--learn",)])
def test_model_in_the_folder_that_is_overwritten_is_not_lost(
    capsys: Capsys,
    room: Path,
    model: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    given: tuple[str, ...],
) -> None:
    """Not where nothing is learned, and not where the watch ends before it could write another."""
    out = tmp_path / "run"
    shutil.copytree(model, out)

    def failing(*_: object, **__: object) -> None:
        raise OSError(5, "Input/output error", "the disk")

    monkeypatch.setattr(SaliencyLearner, "save", failing)
    call(
        capsys,
        *("watch", room, "--model", out, *given, "--seconds", 0.2),
        *("--out", out, "--overwrite"),
    )
    assert (out / "model.npz").read_bytes() == (model / "model.npz").read_bytes()
    assert "looks.csv" in files(out)


def test_settings_name_the_strategy(capsys: Capsys, room: Path, tmp_path: Path) -> None:
    settings = tmp_path / "settings.toml"
    settings.write_text('[explorer]\nstrategy = "sweep"\n')
    strategies = {}
    for name, given in {"set": ("--config", settings), "open": ()}.items():
        told = succeed(
            capsys,
            *("watch", room, "--learn", *given, "--seconds", 0.2),
            *("--out", tmp_path / name, "--json"),
        )
        strategies[name] = json.loads(told.out)["strategy"]
    assert strategies == {"set": "sweep", "open": "progress-rate"}


def test_without_learn_it_maps_by_a_model_and_compares(
    capsys: Capsys, room: Path, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    with visiting(("save", None)) as (visitor, port), pytest.MonkeyPatch.context() as patch:
        patch.setattr(Visitor, "ask", _also_refused(Visitor.ask))
        told = succeed(
            capsys,
            *("watch", room, "--model", model, "--page", port, "--seconds", 1.5),
            *("--out", out, "--json"),
        )
    summary = json.loads(told.out)
    assert (summary["learned"], summary["learn_hz"]) == (0, 0)
    assert summary["looks"] > 0
    assert files(out) == KEPT
    errors = [float(row["error"]) for row in rows_of(out / "looks.csv") if row["error"]]
    assert np.mean(errors) < 0.5  # the model knows the room
    assert visitor.said == [
        {"error": "save: expected a watch that learns; this one changes no model"}
    ]


def _also_refused(ask: Any) -> Any:
    """Return what asks, and takes a refusal for an answer."""

    def asked(*arguments: Any) -> bytes:
        try:
            content: bytes = ask(*arguments)
        except urllib.error.HTTPError as refused:
            content = refused.read()
        return content

    return asked


def test_colour_alone_is_mapped_by_a_model(
    capsys: Capsys, room: Path, model: Path, tmp_path: Path
) -> None:
    told = succeed(
        capsys,
        *("watch", room / "rgb", "--model", model, "--seconds", 0.5),
        *("--out", tmp_path / "run", "--json"),
    )
    summary = json.loads(told.out)
    assert summary["maps"] > 3
    assert summary["looks"] == 0
    line = refusal(capsys, "watch", room / "rgb", "--learn", "--out", tmp_path / "no")
    assert "has no depth to learn from" in line


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_ctrl_c_keeps_everything(
    capsys: Capsys, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = Watch.wait
    turns = iter(range(1000))

    def pressed(watch: Watch, timeout_s: float) -> bool:
        if watch.lessons.n > 3 and next(turns) == 0:
            signal.raise_signal(signal.SIGINT)
        return original(watch, timeout_s)

    monkeypatch.setattr(Watch, "wait", pressed)
    out = tmp_path / "run"
    ended = call(capsys, "watch", room, "--learn", "--out", out)
    assert ended.status == 130
    assert "what was learned is kept" in ended.err
    assert files(out) == KEPT | {"model.npz"}
    assert SaliencyLearner.load(out).n_samples == int(rows_of(out / "looks.csv")[-1]["samples"])


@pytest.mark.parametrize("given", [("--learn", "--page", "0"), ("--learn", "--seconds", "20")])
def test_failure_under_way_is_told_and_what_was_learned_is_kept(
    capsys: Capsys,
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    given: tuple[str, ...],
) -> None:
    original = Watching._note

    def failing(watching: Watching, look: Any) -> None:
        original(watching, look)
        if look.number == 4:
            raise OSError(5, "Input/output error", "the camera")

    monkeypatch.setattr(Watching, "_note", failing)
    out = tmp_path / "run"
    ended = call(capsys, "watch", room, *given, "--out", out)
    assert ended.status == 2
    assert ended.err.splitlines()[-1] == (
        "curiosight: the camera: Input/output error; check path and rights"
    )
    assert files(out) == KEPT | {"model.npz"}
    assert len(rows_of(out / "looks.csv")) == 5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--learn", "--seconds", "0"), "seconds: expected more than 0, got 0"),
        (("--learn", "--seconds", "nan"), "seconds: expected more than 0, got nan"),
        (("--learn", "--seconds", "-3"), "seconds: expected more than 0, got -3"),
        ((), "model: expected --model RUN, --learn, or both; got neither"),
        (("--model", "nowhere"), "nowhere: does not exist; give the folder of a run"),
        (("--learn", "--page", "99999"), "page: expected a port from 0 to 65535, got 99999"),
        (("--learn", "--page", "-1"), "page: expected a port from 0 to 65535, got -1"),
        (("--learn", "--host", "0.0.0.0"), "host: expected --page PORT too"),
        (("--learn", "--page", "0", "--host", "192.0.2.1"), "host: expected an address of this"),
        (("--learn", "--strategy", "iacc"), "did you mean iac?"),
        (("--learn", "--strategy", "oracle"), "oracle"),
    ],
)
def test_what_cannot_be_watched_is_refused_before_anything_is_written(
    capsys: Capsys, room: Path, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    out = tmp_path / "run"
    assert message in refusal(capsys, "watch", room, *arguments, "--out", out)
    assert not out.exists()


def test_living_regions_and_a_port_in_use_are_refused(
    capsys: Capsys, room: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    settings = tmp_path / "settings.toml"
    settings.write_text('[explorer]\nregions = "growing"\n')
    line = refusal(capsys, "watch", room, "--learn", "--config", settings, "--out", out)
    assert "regions: expected some that stay, got 'growing'" in line
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        line = refusal(capsys, "watch", room, "--learn", "--page", port, "--out", out)
    assert f"page: port {port} is in use" in line
    assert not out.exists()


def test_missing_source_is_refused(capsys: Capsys, tmp_path: Path) -> None:
    line = refusal(capsys, "watch", tmp_path / "no", "--learn", "--page", 0)
    assert "does not exist; check the path" in line
    assert "seed: expected a whole number" in refusal(capsys, "watch", "room:x", "--learn")


@pytest.mark.parametrize(
    ("source", "n"), [("room:7,views=15", 15), ("room:7,path=orbit,views=5", 12)]
)
def test_drive_has_as_many_frames_as_it_must(source: str, n: int) -> None:
    views, _ = plan_drive(parse_drawn(source), least=12)
    assert len(views) == n
    assert driving.LEAST_FRAMES == 300


def test_small_home_is_driven_round_again() -> None:
    views, _ = plan_drive(parse_drawn("home:3,rooms=1"), least=1000)
    assert len(views) == 1000


def test_drive_through_a_home_goes_through_all_rooms() -> None:
    views, said = plan_drive(parse_drawn("home:3,rooms=2"), least=40)
    assert len(views) == 40
    assert "times as fast" in said
    home = views.home  # type: ignore[attr-defined]
    rooms = {home.place_of(pose[:2, 3]) for pose in views.poses}
    assert rooms >= {0, 1}


def test_drawn_drive_is_kept_to_the_bit() -> None:
    camera = kinect(8, 6)
    rng = np.random.default_rng(0)
    poses = poses_around(3)

    class Views:
        name, path, remarks = "room", "room:0", ()
        ids = ("a", "b", "c")

        def __init__(self) -> None:
            self.camera, self.poses = camera, poses
            self.frames = []
            for id, pose in zip(self.ids, poses, strict=True):
                rgb = rng.integers(0, 256, (6, 8, 3), np.uint8)
                depth = rng.random((6, 8), np.float32)
                depth[0] = np.nan
                self.frames.append(Frame(id, rgb, depth, camera, pose, stamp_ns=5))

        def __getitem__(self, index: int) -> Frame:
            return self.frames[index]

    views = Views()
    stand_in: DrawnViews = views  # type: ignore[assignment]
    drive = DrawnDrive(stand_in)
    with pytest.raises(ValueError, match="index: expected a frame that was drawn, got 0"):
        drive[0]
    assert list(drive.draw()) == [0, 1, 2]
    for drawn, kept in zip(views.frames, drive, strict=False):
        assert (kept.id, kept.stamp_ns) == (drawn.id, None)
        assert np.array_equal(kept.rgb, drawn.rgb)
        assert drawn.depth is not None
        assert kept.depth is not None
        assert np.array_equal(kept.depth, drawn.depth, equal_nan=True)
        assert np.array_equal(kept.T_world_camera, drawn.T_world_camera)
    drive.close()


@pytest.mark.parametrize("more", [(), ("--learn",)])
def test_model_that_it_begins_with_is_there_all_along(
    more: tuple[str, ...],
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capsys,
) -> None:
    run = tmp_path / "run"
    succeed(capsys, "watch", room, "--learn", "--seconds", 0.7, "--out", run)
    learned = (run / "model.npz").read_bytes()
    found: list[bytes] = []
    start = Watch.start

    def look_and_start(watch: Watch) -> None:
        found.append((run / "model.npz").read_bytes())
        start(watch)

    monkeypatch.setattr(Watch, "start", look_and_start)
    again = ("watch", room, "--model", run, "--out", run, "--overwrite", "--seconds", 0.2)
    succeed(capsys, *again, *more)
    assert found == [learned]
    assert more or (run / "model.npz").read_bytes() == learned
