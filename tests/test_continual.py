"""Places one after the other: what is left of the first, by hand and by the command."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import call, files, refusal, succeed
from curiosight.config import Config
from curiosight.experiments.changes import day_of
from curiosight.experiments.continual import episodes_of
from curiosight.experiments.transfer import transfer
from curiosight.viewing.continual import draw_changes
from curiosight.viewing.paper import HUES
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
NAN = np.nan
QUALITIES = np.array([[0.6, 0.1, 0.0], [0.7, 0.5, 0.2], [0.4, 0.6, 0.8]])


def test_transfer_is_what_the_matrix_says() -> None:
    assert transfer(QUALITIES) == {
        "average_quality": pytest.approx((0.4 + 0.6 + 0.8) / 3, abs=1e-6),
        "backward_transfer": pytest.approx((-0.2 + 0.1) / 2),
        "forgetting": pytest.approx((0.3 + 0.0) / 2),
    }


def test_only_episodes_that_are_done_count() -> None:
    some = QUALITIES.copy()
    some[2] = NAN
    assert transfer(some) == {
        "average_quality": pytest.approx(0.6),
        "backward_transfer": pytest.approx(0.1),
        "forgetting": 0.0,
    }
    some[1] = NAN
    assert transfer(some)["average_quality"] == 0.6
    assert transfer(some)["forgetting"] is None
    assert set(transfer(np.full((2, 2), NAN)).values()) == {None}


def test_rooms_of_a_home_are_its_episodes() -> None:
    episodes = episodes_of(["home:7,rooms=3,views=4"], Config())
    assert [episode.name for episode in episodes] == ["room 0", "room 1", "room 2"]
    assert [list(episode.training) for episode in episodes] == [
        [4 * room + view for view in range(4)] for room in range(3)
    ]
    assert all(len(episode.tests) == 12 for episode in episodes)
    assert episodes[0].test_set.ids != episodes[0].dataset.ids


def test_a_day_is_four_episodes_of_one_home() -> None:
    day = day_of("home:7,rooms=3,views=4", Config())
    assert [(one.name, one.change) for one in day] == [
        ("morning", ""),
        ("evening", "light"),
        ("rearranged", "things"),
        ("a new room", ""),
    ]
    assert [list(one.training) for one in day] == [list(range(8))] * 3 + [[8, 9, 10, 11]]
    assert [len(one.tests) for one in day] == [24, 24, 24, 12]
    # Light leaves things where they are; what moves them leaves the light.
    morning, evening, rearranged, new = (str(one.dataset.settings) for one in day)  # type: ignore[attr-defined]
    assert "lights" not in morning
    assert ("lights=1" in evening, "rearrange" in evening) == (True, False)
    assert ("lights=1" in rearranged, "rearrange=1" in rearranged) == (True, True)
    assert new == rearranged


@pytest.mark.parametrize("source", ["room:7", "home:7,rooms=1", "home:7,rooms=2,lights=3"])
def test_what_has_no_day_is_refused(source: str) -> None:
    with pytest.raises(ValueError, match="sources: expected"):
        day_of(source, Config())


def test_more_than_one_source_has_no_day(capsys: Capsys) -> None:
    assert "one home" in refusal(capsys, "continual", "home:7", "home:8", "--changes")


def test_figure_of_a_day(tmp_path: Path) -> None:
    names = ["morning", "evening", "rearranged"]
    alarms = [(14, "tint"), (22, "gone"), (23, "errors")]
    for name in ("a.png", "b.png"):
        draw_changes(QUALITIES, names, [10, 10, 10], alarms, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    picture = cv2.imread(str(tmp_path / "a.png"))
    assert picture.shape[0] > 400
    # All three causes are there, each in its colour.
    for colour in (HUES[4], HUES[1], HUES[3]):
        bgr = [int(colour[at : at + 2], 16) for at in (5, 3, 1)]
        assert (picture == bgr).all(axis=2).sum() > 50


def test_command(tmp_path: Path, capsys: Capsys) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    write_folder(first, 16)
    write_folder(second, 12)
    outs = [tmp_path / "a", tmp_path / "b"]
    for out in outs:
        succeed(capsys, "continual", first, second, "--out", out)
    assert files(outs[0]) == {
        *("config.toml", "model.npz", "summary.json"),
        *("qualities.csv", "qualities.png", "qualities.svg", "alarms.csv"),
    }
    assert all(
        (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes() for name in files(outs[0])
    )
    with (outs[0] / "qualities.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["after", "first", "second"]
    assert [row[0] for row in rows[1:]] == ["first", "second"]
    summary = json.loads((outs[0] / "summary.json").read_text())
    assert summary["qualities"] == [[float(q) for q in row[1:]] for row in rows[1:]]
    assert 0 < summary["average_quality"] <= 1
    assert summary["looks"] > 10


def test_what_is_no_row_of_places_is_refused(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "one", 2)
    assert "several sources" in refusal(capsys, "continual", tmp_path / "one")
    assert "does not exist" in refusal(capsys, "continual", tmp_path / "one", tmp_path / "none")
    assert call(capsys, "continual").status == 2
