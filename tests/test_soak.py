"""A soak: many looks at small frames in ever new space, and what memory does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from command import refusal, succeed
from curiosight import open_dataset
from curiosight.config import load_config
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.soaking import STEP_METRES, SmallFrames, Soak, resident_mb
from recordings import write_folder


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recordings") / "room"
    write_folder(path, 6)
    return path


def test_frames_are_small_and_see_the_same(room: Path) -> None:
    dataset = open_dataset(room)
    small = SmallFrames(dataset)
    assert len(small) == 6
    assert small[2].rgb.shape == (60, 80, 3)
    camera, whole = small[2].camera, dataset[2].camera
    assert camera is not None
    assert whole is not None
    assert camera.fx == pytest.approx(whole.fx / 2)
    assert np.nanmedian(small[2].depth) == pytest.approx(np.nanmedian(dataset[2].depth), rel=0.02)


def test_each_round_is_elsewhere(room: Path, tmp_path: Path) -> None:
    out = OutputFolder(tmp_path / "run", "soak", tmp_path / "none")
    soak = Soak(load_config(), open_dataset(room), out, 20)
    world = soak._run.world
    places = []
    for n_done in (0, 6, 12):
        soak.n_done = n_done
        world.move_to(world.views[0])
        pose = world.capture().T_world_camera
        assert pose is not None
        places.append(pose[0, 3])
    assert np.allclose(np.diff(places), STEP_METRES)
    soak.n_done = 0
    assert list(soak) == list(range(1, 21))


def test_command(room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = succeed(capsys, "bench", room, "--soak", 40, "--json", tmp_path / "soak.json").out
    figures = json.loads((tmp_path / "soak.json").read_text())
    assert figures["looks"] == 40
    assert [look for look, _ in figures["resident_mb"]] == list(range(1, 41))
    assert 50 < figures["resident_mb"][-1][1] <= resident_mb() * 2
    assert {"model.npz", "steps.csv", "config.toml"} <= set(figures["bytes"])
    assert figures["bytes_a_look"]["steps.csv"] == pytest.approx(
        figures["bytes"]["steps.csv"] / 40, abs=0.1
    )
    assert "deviation" in said
    assert not list(tmp_path.glob("runs"))


def test_too_few_looks_are_refused(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "expected 10 looks" in refusal(capsys, "bench", room, "--soak", 3)
    assert "--stage" in refusal(capsys, "bench", room, "--soak", 30, "--stage", "map")
