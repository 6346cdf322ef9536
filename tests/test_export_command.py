"""curiosight export: a recording becomes an RL-IAC folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from command import call, files, interrupt_at, refusal, succeed
from curiosight.datasets import GraphNode, RlIac, RlIacWriter, open_dataset, write_rl_iac
from recordings import truncate, write_folder

Capsys = pytest.CaptureFixture[str]


def opened(path: Path) -> RlIac:
    dataset = open_dataset(path)
    assert isinstance(dataset, RlIac)
    return dataset


def test_recording_becomes_an_rl_iac_folder(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = tmp_path / "out"
    options = ("--every", 2, "--regions", "time:4", "--json", "--out", out)
    facts = json.loads(succeed(capsys, "export", room, *options).out)
    assert facts == {"frames": 4, "regions": 4, "problems": {}, "out": str(out)}
    names = [f"{number:06d}{kind}" for number in (0, 2, 4, 6) for kind in ("", "_depth", "_GT")]
    images = {f"image_data/{name}.png" for name in names}
    assert files(out) == {"input_region_map.dat", "region_map.dat", "camera.json"} | images
    assert opened(out).regions == (0, 1, 2, 3)


def test_an_rl_iac_folder_keeps_its_regions_and_graph(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    nodes = (GraphNode((1, 0), (8, 4)), GraphNode((0, 1), (8, 4), learner=1))
    regions = (1, 0) * 4
    write_rl_iac(open_dataset(room), tmp_path / "one", regions=regions, graph=nodes)
    succeed(capsys, "export", tmp_path / "one", "--out", tmp_path / "two")
    assert opened(tmp_path / "two").regions == regions
    assert opened(tmp_path / "two").graph == nodes
    succeed(capsys, "export", tmp_path / "one", "--regions", "time:1", "--out", tmp_path / "three")
    assert opened(tmp_path / "three").regions == (0,) * 8


def test_what_is_not_written_is_told(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 4)
    truncate(tmp_path / "room/rgb/000001.png")
    (tmp_path / "regions.csv").write_text("000000,a\n000001,a\n000002,b")
    options = ("--regions", tmp_path / "regions.csv", "--out", tmp_path / "out")
    said = succeed(capsys, "export", tmp_path / "room", *options).err
    assert "1 of 3 frames were not written: bad frame, first 000001" in said
    assert "1 frame in no region: not written" in said
    assert opened(tmp_path / "out").ids == ("000000", "000002")


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_it_keeps_what_is_written(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, RlIacWriter, "_write", turn=3)
    outcome = call(capsys, "export", room, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert "stopped after 3 frames; these are kept" in outcome.err
    assert len(opened(tmp_path / "out")) == 3


def test_refusals_leave_nothing_behind(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = tmp_path / "out"
    assert "every: expected 1 or more" in refusal(
        capsys, "export", room, "--every", 0, "--out", out
    )
    assert "has no depth" in refusal(capsys, "export", room / "rgb", "--out", out)
    assert not out.exists()
