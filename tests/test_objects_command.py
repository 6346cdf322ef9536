"""`curiosight objects`, and docs/objects.md: its commands in turn, and its Python."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from command import call, files, interrupt_at, refusal, succeed
from curiosight.experiments.cataloguing import Cataloguing

Capsys = pytest.CaptureFixture[str]
DOCS = (Path(__file__).parent.parent / "docs/objects.md").read_text("utf-8")
KEYS = {
    "id",
    "place",
    "support",
    "T_world_centre",
    "size_m",
    "first_seen",
    "last_seen",
    "n_views",
    "confidence",
    "change",
}


def read(folder: Path) -> dict[str, list[dict[str, object]]]:
    return json.loads((folder / "objects.json").read_text("utf-8"))


def test_boxes_of_a_room_are_found_where_they_stand(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    told = succeed(capsys, "objects", model, room, "--out", tmp_path / "out", "--threshold", 0.5)
    assert files(tmp_path / "out") == {"objects.json", "objects.html", "config.toml"}
    content = read(tmp_path / "out")
    assert re.search(r"^  things +3$", told.out, re.MULTILINE)
    assert [one["id"] for one in content["objects"]] == [1, 2, 3]
    centres = np.array([np.array(one["T_world_centre"])[:3, 3] for one in content["objects"]])
    for true in ((0.0, 0.0, 0.15), (0.7, 0.2, 0.2), (-0.7, 0.3, 0.125)):
        assert np.linalg.norm(centres - true, axis=1).min() < 0.08
    for one in content["objects"]:
        assert one.keys() == KEYS
        assert (one["change"], one["support"]) == ("new", "floor")
    images = {image["id"]: image for image in content["images"]}
    assert sorted(images) == list(range(1, 9))
    for annotation in content["annotations"]:
        assert annotation["object_id"] in (1, 2, 3)
        image, segmentation = images[annotation["image_id"]], annotation["segmentation"]
        assert sum(segmentation["counts"]) == image["width"] * image["height"]
        assert sum(segmentation["counts"][1::2]) == annotation["area"]
    page = (tmp_path / "out/objects.html").read_text("utf-8")
    assert page.count('class="card new"') == 3
    assert "3 things are there." in page
    assert 'src="http' not in page


def test_same_room_twice_is_the_same(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ["--out", tmp_path / "out", "--threshold", 0.5, "--json"]
    told = json.loads(succeed(capsys, "objects", model, room, room, *options).out)
    changes = {change: told[change] for change in ("new", "moved", "gone", "same")}
    assert changes == {"new": 0, "moved": 0, "gone": 0, "same": 3}
    assert {image["visit"] for image in read(tmp_path / "out")["images"]} == {0, 1}
    assert 'id="show-gone"' in (tmp_path / "out/objects.html").read_text("utf-8")


def test_recording_without_poses_is_refused_in_a_line(
    model: Path, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    for name in ("rgb", "depth"):
        (tmp_path / "bare" / name).mkdir(parents=True)
        for path in (room / name).iterdir():
            (tmp_path / "bare" / name / path.name).write_bytes(path.read_bytes())
    (tmp_path / "bare/camera.json").write_bytes((room / "camera.json").read_bytes())
    line = refusal(capsys, "objects", model, tmp_path / "bare", "--out", tmp_path / "out")
    assert "bare: has no poses, and things are followed from view to view" in line
    assert not (tmp_path / "out").exists()
    line = refusal(capsys, "objects", model, room, "--out", tmp_path / "out", "--every", 0)
    assert line == "curiosight: every: expected 1 or more, got 0"


def test_ctrl_c_keeps_what_was_found(
    model: Path,
    room: Path,
    tmp_path: Path,
    capsys: Capsys,
    monkeypatch: pytest.MonkeyPatch,
    ctrl_c_as_usual: None,
) -> None:
    interrupt_at(monkeypatch, Cataloguing, "_take_in", 6)
    outcome = call(capsys, "objects", model, room, "--out", tmp_path / "out", "--threshold", 0)
    assert outcome.status == 130
    assert "these are kept" in outcome.err
    content = read(tmp_path / "out")
    assert 5 <= len(content["images"]) < 8
    assert content["objects"]


def test_documentation_does_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    first, merging = re.findall(r"```sh\n(.*?)```", DOCS, re.DOTALL)
    told = []
    shorter = (first + merging).replace("--views 20", "--views 6").replace("rooms=2", "rooms=1")
    for line in shorter.splitlines():
        program, command, *words = shlex.split(line)
        assert program == "curiosight"
        told.append((command, succeed(capsys, command, *words)))
    assert [command for command, _ in told][-3:] == ["objects", "learn", "merge"]
    assert {"objects.html", "objects.json"} <= files(Path("things"))
    assert {"model.npz"} <= files(Path("both"))
    (program,) = re.findall(r"```python\n(.*?)```", DOCS, re.DOTALL)
    names: dict[str, object] = {}
    capsys.readouterr()
    exec(compile(program, "docs/objects.md", "exec"), names)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(names["catalogue"].entries) > 0
