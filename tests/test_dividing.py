"""Regions that are the learner's places."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from command import refusal, succeed
from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.tour import views_in_regions
from curiosight.experiments.dividing import choose_regions, learner_places
from curiosight.explorer.regions import make_regions
from recordings import truncate, write_folder
from test_places import N_HEADINGS, sights, without_pose  # noqa: F401 (a fixture)
from test_regions import ids, stand

PLACES = np.array([2, 0, 0, 2, -1, 0])


def test_places_are_regions_and_what_is_in_none_is_in_no_region() -> None:
    regions = make_regions("places", [None] * 6, ids(6), places=PLACES)
    assert regions.of_view.tolist() == [1, 0, 0, 1, -1, 0]
    assert (regions.names, regions.kind) == (("place 0", "place 2"), "places")


def test_places_are_divided_by_headings() -> None:
    poses = [stand(0, 0, heading) for heading in (0, 10, 190, 180, 90, 200, 15)]
    regions = make_regions("places:2", poses, ids(7), places=np.append(PLACES, 0))
    names = [regions.names[region] if region >= 0 else None for region in regions.of_view]
    assert [name and name[:7] for name in names] == [
        "place 2", "place 0", "place 0", "place 2", None, "place 0", "place 0",
    ]  # fmt: skip
    assert names[1] == names[6] != names[2] == names[5]
    assert names[0] != names[3]


@pytest.mark.parametrize(
    ("spec", "places", "complaint"),
    [
        ("places", None, "expected views with a place for `places`"),
        ("places", np.full(6, -1), "expected views with a place for `places`"),
        ("places:4", PLACES, "expected poses of all views for `places:4`"),
        ("places:0", PLACES, "expected auto"),
        ("auto:0", None, "expected auto"),
        ("auto", None, "expected poses of all views for `auto`"),
    ],
)
def test_places_that_are_not_known_are_refused(
    spec: str, places: np.ndarray | None, complaint: str
) -> None:
    with pytest.raises(ValueError, match=f"regions: {complaint}"):
        make_regions(spec, [None] * 6, ids(6), places=places)


@pytest.mark.parametrize("has_poses", [True, False])
def test_places_are_rooms(sights, has_poses: bool) -> None:  # noqa: F811
    rooms = np.array([room for room, _ in sights])
    seen = [sight if has_poses else without_pose(sight) for _, sight in sights]
    places = learner_places(load_config(), [None, *seen])
    assert places[0] == -1
    assert len(set(places[1:])) == 3
    assert len({*zip(places[1:], rooms, strict=True)}) == 3
    no_places = load_config(overrides={"learner.max_places": 0})  # of the learner's own
    assert (learner_places(no_places, seen[: 2 * N_HEADINGS]) >= 0).all()


def test_explore_goes_by_places(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_folder(tmp_path / "room", 8)
    truncate(tmp_path / "room/rgb/000003.png")
    options = ("--regions", "places", "--strategy", "sweep", "--steps", 4)
    said = succeed(capsys, "explore", tmp_path / "room", *options, "--out", tmp_path / "out").err
    assert "1 region (places)" in said
    facts = json.loads(
        succeed(capsys, "info", tmp_path / "room", "--regions", "places", "--json").out
    )
    assert facts["regions"]["frames"] == [7]
    line = refusal(capsys, "info", tmp_path / "room", "--regions", "places:x")
    assert "places:4" in line


def test_comparisons_have_the_same_places(tmp_path: Path) -> None:
    write_folder(tmp_path / "room", 9)
    named = {"explorer.regions": "places", "test.every": 4, "test.gap": 0}
    config = load_config(overrides=named)
    prepared = prepare(str(tmp_path / "room"), config, tmp_path / "prepared")
    _, regions = views_in_regions(prepared, config)
    dataset = open_dataset(tmp_path / "room")
    of_id = dict(zip(dataset.ids, choose_regions(config, dataset).of_view, strict=True))
    assert regions.of_view.tolist() == [of_id[id_] for id_ in prepared.ids]
