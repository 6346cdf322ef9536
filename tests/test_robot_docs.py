"""docs/robot.md does what it says: its commands in turn, and its robot in a drawn room."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from command import files, succeed
from curiosight.learner.learner import SaliencyLearner
from room import kinect, poses_around, render

Capsys = pytest.CaptureFixture[str]
DOCS = (Path(__file__).parent.parent / "docs/robot.md").read_text("utf-8")
# A short one of each.
SHORTER = {"views=40": "views=3", "--seconds 60": "--seconds 2", "--page 8000": "--page 0"}


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", DOCS, re.DOTALL)
    assert found is not None
    return found[1]


def test_commands_lead_from_a_bag_to_a_model_to_maps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    text = block("sh")
    for long, short in SHORTER.items():
        assert text.count(long) == 1
        text = text.replace(long, short)
    extras, *lines = text.splitlines()
    assert extras == "pip install 'curiosight[bags,mcap]'"
    told = {}
    for line in lines:
        program, command, *words = shlex.split(line)
        assert program == "curiosight"
        told[command] = succeed(capsys, command, *words)
    assert list(told) == ["export", "info", "learn", "watch", "map"]
    assert re.search(r"^  poses +3 of 3$", told["info"].out, re.MULTILINE)
    learned, watched = SaliencyLearner.load("model"), SaliencyLearner.load("watched")
    assert watched.n_samples > learned.n_samples
    with Path("watched.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert "/saliency" in {channel.topic for channel in summary.channels.values()}
    assert len([name for name in files(Path("maps")) if name.endswith(".png")]) == 3


class Base:
    def __init__(self) -> None:
        self.place = -1

    def drive_to(self, place: int) -> None:
        self.place = place


class Camera:
    """A depth camera: millimetres in 16 bits, 0 = no reading."""

    def __init__(self, base: Base) -> None:
        self.base, self.lens = base, kinect(160, 120)

    def read(self) -> tuple[np.ndarray, ...]:
        pose = POSES[self.base.place]
        view = render(self.lens, pose)
        depth_mm = np.nan_to_num(1000 * view.depth).round().astype(np.uint16)
        K = np.array([[self.lens.fx, 0, self.lens.cx], [0, self.lens.fy, self.lens.cy], [0, 0, 1]])
        return view.rgb, depth_mm, K, pose


POSES = poses_around(6)


def test_robot_of_thirty_lines_learns_what_objects_look_like(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    code = block("python")
    assert len([line for line in code.splitlines() if line.strip()]) <= 30
    base = Base()
    given = {"base": base, "camera": Camera(base), "places": range(6), "poses": POSES}
    names: dict[str, object] = dict(given)
    exec(code.replace("n_steps=200", "n_steps=12"), names)
    steps = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [step[0] for step in steps] == [str(number) for number in range(12)]
    assert all(0 <= float(step[2]) < 1 for step in steps)
    view = render(kinect(160, 120), POSES[0])
    saliency = SaliencyLearner.load("robot.npz").saliency(view.rgb)
    is_object = view.ground_truth == 255
    assert saliency[is_object].mean() > saliency[~is_object].mean() + 0.4
