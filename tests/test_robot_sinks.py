"""A watch's log and viewer: what was told is in the file, and neither ever holds up the watch."""

from __future__ import annotations

import base64
import json
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from scipy.spatial.transform import Rotation

from command import call, files, interrupt_at, refusal, succeed
from curiosight.experiments.live_log import live_log
from curiosight.experiments.watching import Watching
from curiosight.frame import Viewpoint
from curiosight.robot.sinks import mcap_log, recorder
from curiosight.robot.sinks.foxglove import SCHEMAS
from curiosight.robot.sinks.mcap_log import McapLog
from curiosight.robot.sinks.recorder import Recorder
from curiosight.robot.sinks.sink import Moment
from curiosight.robot.watch import Look
from test_robot_advice import NAMES
from test_robot_watch import CAMERA, FRAMES, POSES, TRUTHS, VIEWS, Knowing, wait_for, watching

Capsys = pytest.CaptureFixture[str]
TOPICS = {
    "/camera/colour": "foxglove.CompressedImage",
    "/camera/calibration": "foxglove.CameraCalibration",
    "/tf": "foxglove.FrameTransform",
    "/saliency": "foxglove.CompressedImage",
    "/labels": "foxglove.CompressedImage",
    "/regions": "foxglove.SceneUpdate",
    "/why": "foxglove.Log",
    "/looks": "curiosight.Look",
    "/state": "curiosight.State",
}
Messages = dict[str, list[dict[str, Any]]]


def row_of(look: Look) -> dict[str, Any]:
    told = {"look": look.number, "seconds": look.seconds, "error": look.error}
    return {**told, "id": look.verdict.shot.frame.id}


def record(
    sink: Any, n_looks: int, then: Callable[[], None] | None = None
) -> tuple[list[dict[str, Any]], dict[str, int]]:
    """Record a watch of so many looks, do what is to be done then; return these, and the counts."""
    looks: list[dict[str, Any]] = []
    recorders: list[Recorder] = []

    def note(look: Look) -> None:
        looks.append(row_of(look))
        for one in recorders:
            one.note(looks[-1])

    with watching(Knowing(), on_look=note) as (watch, shown):
        one = Recorder(watch, shown, sink, rate_hz=50)
        recorders.append(one)
        one.start("a room", VIEWS)
        wait_for(lambda: len(looks) >= n_looks)
        watch.stop()
        if then is not None:
            then()
        one.stop()
        assert one.problem is None
    return looks, one.counts()


def read(path: Path) -> Messages:
    found: Messages = defaultdict(list)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert schema.name == TOPICS[channel.topic]
            content = json.loads(message.data)
            check(content, json.loads(schema.data))
            if "timestamp" in content:
                assert stamp_of(content) == message.log_time
            found[channel.topic].append(content)
    return found


def check(content: Any, schema: dict[str, Any]) -> None:
    """Check that content has the fields of a schema, and no others."""
    if schema["type"] == "array":
        for item in content:
            check(item, schema["items"])
    elif "properties" in schema:
        assert set(content) == set(schema["properties"]), schema["title"]
        for name, part in schema["properties"].items():
            check(content[name], part)
    else:
        kinds = {"string": str, "number": float, "integer": int, "boolean": bool, "object": dict}
        assert type(content) is kinds[schema["type"]], (content, schema)


def stamp_of(content: dict[str, Any]) -> int:
    return int(content["timestamp"]["sec"] * 10**9 + content["timestamp"]["nsec"])


def image(content: dict[str, Any]) -> np.ndarray:
    assert content["frame_id"] == "camera"
    data = np.frombuffer(base64.b64decode(content["data"], validate=True), np.uint8)
    return cv2.imdecode(data, cv2.IMREAD_UNCHANGED)


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any, Any]:
    """A log of some looks, these, and how much was written."""
    path = tmp_path_factory.mktemp("logs") / "new/a.mcap"
    began_ns = time.time_ns()
    told = record(live_log(path, Path("elsewhere")), 12)
    assert all(began_ns <= stamp_of(one) <= time.time_ns() for one in read(path)["/camera/colour"])
    return path, *told


def test_log_holds_frames_with_their_camera_and_pose(logged: tuple[Path, Any, Any]) -> None:
    found = read(logged[0])
    assert set(found) == set(TOPICS)
    for colour, saliency, told, camera in zip(
        found["/camera/colour"],
        found["/saliency"],
        found["/tf"],
        found["/camera/calibration"],
        strict=True,
    ):
        assert colour["timestamp"] == saliency["timestamp"] == told["timestamp"]
        assert (colour["format"], saliency["format"]) == ("jpeg", "png")
        assert (told["parent_frame_id"], told["child_frame_id"]) == ("world", "camera")
        rotation = Rotation.from_quat([told["rotation"][axis] for axis in "xyzw"]).as_matrix()
        translation = [told["translation"][axis] for axis in "xyz"]
        poses = [np.allclose(pose[:3, 3], translation) for pose in POSES]
        number = poses.index(True)
        np.testing.assert_allclose(rotation, POSES[number][:3, :3], atol=1e-9)
        rgb = image(colour)[..., ::-1].astype(int)
        assert np.abs(rgb - FRAMES[number].rgb).mean() < 12  # JPEG's loss
        assert image(saliency).shape == (60, 80)
        assert (camera["width"], camera["height"], camera["K"][0], camera["P"][2]) == (
            80,
            60,
            CAMERA.fx,
            CAMERA.cx,
        )


def test_log_holds_labels_looks_regions_and_why(logged: tuple[Path, Any, Any]) -> None:
    path, looks, counts = logged
    found = read(path)
    truths = {truth.tobytes() for truth in TRUTHS.values()}
    assert {image(one).tobytes() for one in found["/labels"]} <= truths
    assert found["/looks"] == looks[-counts["looks"] :]
    assert counts["looks"] >= 12
    assert counts["looks_lost"] == 0
    assert counts["maps"] == len(found["/saliency"]) > 2
    assert {one["message"].partition(": ")[2] for one in found["/why"]} >= {"in turn"}
    assert found["/state"][-1]["state"] in ("running", "ended")
    entities = {one["id"]: one for one in found["/regions"][-1]["entities"]}
    assert set(entities) == {"region 0", "region 1", "region 2"}
    middle = np.mean([pose[:3, 3] for pose in POSES[2:4]], axis=0)
    ball = entities["region 1"]["spheres"][0]["pose"]["position"]
    np.testing.assert_allclose([ball[axis] for axis in "xyz"], middle)
    assert entities["region 1"]["texts"][0]["text"].startswith(f"{NAMES[1]}: looks ")


def test_schemas_are_called_as_foxglove_calls_them() -> None:
    for name, schema in SCHEMAS.items():
        assert schema["title"] == name
    assert set(SCHEMAS["foxglove.FrameTransform"]["properties"]) == {
        *("timestamp", "parent_frame_id", "child_frame_id", "translation", "rotation"),
    }
    entity = SCHEMAS["foxglove.SceneUpdate"]["properties"]["entities"]["items"]
    # As https://docs.foxglove.dev/docs/sdk/schemas/scene-entity has them.
    assert set(entity["properties"]) == {
        *("timestamp", "frame_id", "id", "lifetime", "frame_locked", "metadata", "arrows"),
        *("cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"),
    }


def test_killed_watch_leaves_what_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_log, "CHUNK_BYTES", 20_000)
    path = tmp_path / "a.mcap"
    monkeypatch.setattr("mcap.writer.Writer.finish", lambda _: None)
    _, counts = record(live_log(path, tmp_path / "elsewhere"), 20)
    topics = []
    with path.open("rb") as file, suppress(EndOfFile):
        for _, channel, _ in NonSeekingReader(file).iter_messages(log_time_order=False):
            topics.append(channel.topic)
    n_maps = topics.count("/saliency")
    assert counts["maps"] - 10 <= n_maps <= counts["maps"]
    assert n_maps > 0


class Slow:
    """A sink that takes nothing before it is let go."""

    name = "slow"

    def __init__(self) -> None:
        self.is_let_go = threading.Event()
        self.moments: list[Moment] = []

    def begin(self, title: str, views: Sequence[Viewpoint]) -> None: ...

    def write(self, moment: Moment) -> None:
        self.is_let_go.wait(60)
        self.moments.append(moment)

    def close(self) -> None: ...


def test_sink_that_is_slow_holds_up_nothing_and_what_it_missed_is_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(recorder, "N_WAITING", 5)
    slow = Slow()
    looks, counts = record(slow, 30, then=slow.is_let_go.set)
    assert counts["looks_lost"] > 0
    assert counts["looks"] == sum(len(moment.looks) for moment in slow.moments)
    assert counts["looks"] + counts["looks_lost"] <= len(looks)
    assert counts["maps_left_out"] > 0


def watched(room: Path, tmp_path: Path, *more: str | Path) -> tuple[str | Path | float, ...]:
    return ("watch", room, "--learn", "--seconds", 0.7, "--out", tmp_path / "run", *more)


def test_command_writes_a_log_that_no_bag_reader_takes_for_a_recording(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    path = tmp_path / "a.mcap"
    told = succeed(capsys, *watched(room, tmp_path, "--mcap", path, "--json"))
    counts = json.loads(told.out)["recorded"][str(path)]
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert {one.topic for one in summary.channels.values()} >= {"/saliency", "/looks", "/why"}
    found = defaultdict(list)
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            found[channel.topic].append(json.loads(message.data))
    assert [len(found["/saliency"]), len(found["/looks"])] == [counts["maps"], counts["looks"]]
    line = refusal(capsys, "info", path)
    assert "holds no messages of ROS, but " in line
    assert "/camera/colour (foxglove.CompressedImage)" in line


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_ctrl_c_ends_the_log(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Watching, "_note", turn=1)  # in another thread: the signal is ours
    path = tmp_path / "a.mcap"
    ended = call(capsys, *watched(room, tmp_path, "--mcap", path))
    assert ended.status == 130
    with path.open("rb") as file:
        assert make_reader(file).get_summary() is not None


def test_log_that_is_there_stays_unless_told(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"mine")
    line = refusal(capsys, *watched(room, tmp_path, "--mcap", path))
    assert "exists; choose another --mcap, or add --overwrite" in line
    assert "is a folder; name a file" in refusal(
        capsys, *watched(room, tmp_path, "--mcap", tmp_path)
    )
    inside = room / "a.mcap"
    assert "lies inside the recording" in refusal(
        capsys, *watched(room, tmp_path, "--mcap", inside)
    )
    assert (files(tmp_path), path.read_bytes()) == ({"a.mcap"}, b"mine")
    succeed(capsys, *watched(room, tmp_path, "--mcap", path, "--overwrite"))
    with path.open("rb") as file:
        assert make_reader(file).get_summary() is not None


def test_log_that_cannot_be_written_is_told_before_the_watch(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"mine")
    line = refusal(capsys, *watched(room, tmp_path, "--mcap", file / "new/a.mcap"))
    assert "a.mcap: cannot be written (Not a directory); check the folder and its rights" in line
    assert (files(tmp_path), file.read_bytes()) == ({"file"}, b"mine")


@pytest.mark.parametrize("module", ["mcap", "mcap.writer"])
def test_without_mcap_the_extra_is_named(
    module: str, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    line = refusal(capsys, *watched(room, tmp_path, "--mcap", tmp_path / "a.mcap"))
    assert (
        "cannot be written without mcap, which is missing; pip install 'curiosight[mcap]'" in line
    )
    assert not files(tmp_path)


def test_log_that_fails_is_warned_of_once_and_the_watch_goes_on(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    def failing(self: McapLog, moment: Moment) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(McapLog, "write", failing)
    path = tmp_path / "a.mcap"
    told = succeed(capsys, *watched(room, tmp_path, "--mcap", path, "--json"))
    warnings = [line for line in told.err.splitlines() if line.startswith("warning: ")]
    problem = "[Errno 28] No space left on device"
    assert warnings == [f"warning: {path} is told no more, the watch goes on: {problem}"]
    assert json.loads(told.out)["seconds"] >= 0.7
    assert json.loads(told.out)["recorded"][str(path)]["maps"] == 0


def test_without_rerun_the_watch_goes_on_with_a_warning(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    told = succeed(capsys, *watched(room, tmp_path, "--viz", "open"))
    assert "warning: no viewer: " in told.err
    assert "pip install 'curiosight[viz]'" in told.err
    assert "model.npz" in files(tmp_path / "run")


def test_rerun_is_told_the_newest_pictures_and_curves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Into a file instead of a viewer: what is there to be shown."""
    pytest.importorskip("rerun", exc_type=ImportError)
    from curiosight.robot.sinks.rerun_view import RerunView

    path = tmp_path / "a.rrd"
    monkeypatch.setattr(RerunView, "_connect", lambda self: self._stream.save(path))
    _, counts = record(RerunView(), 12)
    assert counts["maps"] > 2
    content = path.read_bytes()
    assert content.startswith(b"RRF2")
    for entity in (b"camera/colour", b"camera/saliency", b"camera/labels", b"error", b"regions"):
        assert entity in content
