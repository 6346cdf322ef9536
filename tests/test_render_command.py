"""curiosight render: what it writes, our loaders read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from command import call, interrupt_at, refusal, succeed
from curiosight.datasets import check_dataset, open_dataset
from curiosight.datasets.decoding import decode_unchanged
from curiosight.datasets.layouts.seven_scenes import COLOUR_FROM_DEPTH_METRES
from curiosight.experiments import rendering
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.rendering import render_room
from curiosight.rooms.settings import SensorName
from curiosight.rooms.views import RoomViews
from curiosight.worlds import open_source

Capsys = pytest.CaptureFixture[str]
ROOM = "room:5,sensor=perfect,views=3"


@pytest.fixture(scope="module")
def views() -> RoomViews:
    views = open_source(ROOM)
    assert isinstance(views, RoomViews)
    return views


def test_a_tum_recording_reads_back(views: RoomViews, tmp_path: Path, capsys: Capsys) -> None:
    succeed(capsys, "render", ROOM, "--layout", "tum", "--out", tmp_path / "tum")
    recording = open_dataset(tmp_path / "tum")
    check_dataset(recording)
    assert recording.name == "TUM RGB-D"
    assert len(recording) == 3
    for index in range(3):
        frame, look = recording[index], views.look(index)
        np.testing.assert_array_equal(frame.rgb, look.frame.rgb)
        np.testing.assert_allclose(frame.depth, look.true_depth, atol=2e-4)
        np.testing.assert_allclose(frame.T_world_camera, views.poses[index], atol=1e-8)
        np.testing.assert_array_equal(recording.ground_truth(index), look.truth)
    assert (tmp_path / "tum" / "room.txt").read_text() == f"{ROOM}\n"


def test_a_seven_scenes_recording_is_registered_when_read(
    views: RoomViews, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "render", ROOM, "--layout", "7scenes", "--out", tmp_path / "scene")
    recording = open_dataset(tmp_path / "scene")
    check_dataset(recording)
    assert recording.name == "7-Scenes"
    assert len(recording) == 3
    for index in range(3):
        frame = recording[index]
        assert frame.camera is not None
        np.testing.assert_allclose(frame.T_world_camera, views.poses[index], atol=1e-7)
        seen = views.renderer.render(frame.camera, views.poses[index])
        off = np.abs(frame.depth - seen.depth)
        assert np.isfinite(off).mean() > 0.7
        # Registration splats pixels: outlines are off by one.
        assert np.nanmedian(off) < 0.005
        assert np.mean(off[np.isfinite(off)] < 0.03) > 0.98
        truth = recording.ground_truth(index)
        assert truth is not None
        assert set(np.unique(truth)) <= {0, 125, 255}


def of_sensor(views: RoomViews, sensor: SensorName) -> RoomViews:
    """Return the same views by another sensor."""
    settings = replace(views.room.settings, sensor=sensor)
    others = RoomViews(replace(views.room, settings=settings))
    others.renderer = views.renderer
    return others


def check_plain(folder: Path, views: RoomViews, size: tuple[int, int], atol: float) -> None:
    """Check that a folder holds depth at its own size and is read as the room's own frames are."""
    recording = open_dataset(folder)
    check_dataset(recording)
    assert recording.name == "plain folder"
    assert len(recording) == len(views)
    for index in range(len(views)):
        stored = decode_unchanged(folder / "depth" / f"{recording.ids[index]}.png")
        assert (stored.shape, stored.dtype) == (size, np.uint16)
        frame, drawn = recording[index], views[index]
        np.testing.assert_array_equal(frame.rgb, drawn.rgb)
        np.testing.assert_allclose(frame.depth, drawn.depth, rtol=0, atol=atol)
        np.testing.assert_allclose(frame.T_world_camera, drawn.T_world_camera, atol=1e-8)
        np.testing.assert_array_equal(recording.ground_truth(index), views.ground_truth(index))


def test_a_phones_recording_keeps_its_small_depth_and_confidence(
    views: RoomViews, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "render", "room:5,sensor=lidar,views=3", "--out", tmp_path / "out")
    drawn = of_sensor(views, "lidar")
    check_plain(tmp_path / "out", drawn, (192, 256), atol=0)
    written = sorted((tmp_path / "out" / "confidence").iterdir())
    assert len(written) == 3
    for index, path in enumerate(written):
        np.testing.assert_array_equal(decode_unchanged(path), drawn.look(index).readings.confidence)


@pytest.mark.parametrize(("sensor", "atol"), [("stereo", 0.0), ("perfect", 6e-4)])
def test_a_plain_recording_reads_back(
    sensor: SensorName, atol: float, views: RoomViews, tmp_path: Path
) -> None:
    drawn = of_sensor(views, sensor)
    assert (
        len(list(render_room(drawn, "plain", OutputFolder(tmp_path, "render", Path("room:5")))))
        == 3
    )
    check_plain(tmp_path, drawn, (480, 640), atol)
    assert not (tmp_path / "confidence").exists()


def test_a_plain_recording_that_ends_early_is_one(views: RoomViews, tmp_path: Path) -> None:
    rendering_views = render_room(views, "plain", OutputFolder(tmp_path, "render", Path("room:5")))
    next(rendering_views)
    rendering_views.close()
    recording = open_dataset(tmp_path)
    assert len(recording) == 1
    assert recording[0].T_world_camera is not None


def test_depth_is_seen_from_beside_the_colour_camera(
    views: RoomViews, tmp_path: Path, capsys: Capsys
) -> None:
    succeed(capsys, "render", ROOM, "--layout", "7scenes", "--out", tmp_path / "scene")
    written = np.loadtxt(tmp_path / "scene/seq-01/frame-000000.pose.txt")
    beside = np.linalg.inv(views.poses[0]) @ written
    np.testing.assert_allclose(beside[:3, 3], COLOUR_FROM_DEPTH_METRES, atol=1e-7)


def test_chosen_places_are_looked_from(views: RoomViews, tmp_path: Path, capsys: Capsys) -> None:
    x, y = views.free_space.draw_places(1, np.random.default_rng(1))[0]
    succeed(capsys, "render", ROOM, "--pose", f"{x},{y},45", "--out", tmp_path / "out")
    recording = open_dataset(tmp_path / "out")
    assert len(recording) == 1
    pose = recording[0].T_world_camera
    assert pose is not None
    np.testing.assert_allclose(pose[:3, 3], (x, y, 1.0), atol=1e-6)
    assert np.degrees(np.arctan2(pose[1, 2], pose[0, 2])) == pytest.approx(45)


@pytest.mark.usefixtures("ctrl_c_as_usual")
@pytest.mark.parametrize("layout", ["tum", "7scenes"])
def test_interrupted_it_leaves_a_recording_of_what_is_written(
    layout: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, rendering, "_in_units", turn=2)
    outcome = call(capsys, "render", ROOM, "--layout", layout, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert "stopped after 2 views; these are kept" in outcome.err
    recording = open_dataset(tmp_path / "out")
    check_dataset(recording)
    assert len(recording) == 2


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["room:5", "--pose", "0.01,1,0"], "in a wall, in furniture or too close"),
        (["room:5", "--pose", "1,1"], "expected X,Y,HEADING"),
        (["room:5", "--pose", "1,1,nan"], "finite"),
        (["room:5", "--pose", "1,1,0", "--views", "3"], "--views or --pose"),
        (["room:5", "--views", "0"], "views: expected 1 to"),
        (["room:5", "--layout", "scannet"], "layout: expected 7scenes or tum"),
        (["room:5,sensor=lidar", "--layout", "tum"], "layout: expected plain for sensor=lidar"),
        (["room:5,over=table", "--pose", "0.01,0.01,0"], "expected a place on a table"),
        (["room:5,plan=round"], "plan: expected rect or l"),
        (["room:5,furniture=none.sh3f"], "none.sh3f: missing"),
        (["kitchen"], "expected room:SEED"),
    ],
)
def test_mistakes_are_one_line(
    arguments: list[str], complaint: str, tmp_path: Path, capsys: Capsys
) -> None:
    line = refusal(capsys, "render", *arguments, "--out", tmp_path / "out")
    assert complaint in line
    assert not (tmp_path / "out").exists()
