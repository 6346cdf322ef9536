"""The authors' region map and navigation graph, and ways that are measured while driving."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from command import refusal, succeed
from curiosight.config import load_config
from curiosight.datasets import open_dataset, write_rl_iac
from curiosight.datasets.layouts.rl_iac_tables import GraphNode, read_graph
from curiosight.errors import DataError
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.running import Run
from curiosight.explorer.ground import Floats, Ground
from curiosight.explorer.navigation import RegionWays, make_graph, shortest_seconds
from curiosight.explorer.outcome import Outcome
from curiosight.explorer.regions import make_regions
from curiosight.explorer.strategies import make_strategy
from curiosight.frame import Viewpoint
from recordings import write_folder
from test_strategies import make_views

Capsys = pytest.CaptureFixture[str]

# Three regions in a row, the third behind a door that is 16 away; up leads nowhere.
ROW = (
    GraphNode((0, 0, 0, 1, 0), (4, 4, 4, 8, 4)),
    GraphNode((1, 1, 0, 2, 1), (4, 4, 8, 16, 4)),
    GraphNode((2, 2, 1, 2, 2), (4, 4, 16, 4, 4)),
)
ROW_TEXT = """\
# region = [up, down, left, right, stay], [durations], [learner];
0 = [0,0,0,1,0], [4,4,4,8,4], [0];
1 = [1,1,0,2,1], [4,4,8,16,4], [0];
2 = [2,2,1,2,2], [4,4,16,4,4], [0];
"""


def test_ways_lead_through_regions_between() -> None:
    expected = [[4, 8, 24], [8, 4, 16], [24, 16, 4]]
    np.testing.assert_array_equal(shortest_seconds(ROW), expected)


def test_some_ways_lead_in_one_direction_only() -> None:
    nodes = (GraphNode((1,), (5,)), GraphNode((1,), (0,)))
    np.testing.assert_array_equal(shortest_seconds(nodes), [[0, 5], [np.inf, 0]])


def test_views_are_as_far_as_their_regions() -> None:
    seconds = RegionWays(shortest_seconds(ROW))
    views = [Viewpoint(index, region, None) for index, region in enumerate((0, 0, 1, 2, -1))]
    np.testing.assert_array_equal(seconds(views[0], views), [0, 4, 8, 24, 0])
    np.testing.assert_array_equal(seconds(views[4], views), [0, 0, 0, 0, 0])


def map_file(folder: Path, lines: str, graph: str | None = ROW_TEXT) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "input_region_map.dat").write_text(lines)
    if graph is not None:
        (folder / "region_map.dat").write_text(graph)
    return folder / "input_region_map.dat"


def test_region_map_of_the_authors_is_a_file_of_regions(tmp_path: Path) -> None:
    ids = ("a 1", "seq-01/x", "seq-02/x", "1305031229.5", "y")
    lines = (
        "# region of each image\n[image_data/a 1.png] = 2;\n\n[seq-02_x.png]=0\n"
        "[/home/me/seq-01/x.color.JPG] = 2\n[image_data/1305031229.5]=0\n[other.png] = 1\n"
    )
    regions = make_regions(str(map_file(tmp_path, lines)), [None] * 5, ids)
    assert regions.of_view.tolist() == [1, 1, 0, 0, -1]
    assert (regions.names, regions.kind) == (("0", "2"), "file")
    # From 0 to 2 through region 1, which none of the frames is in.
    np.testing.assert_array_equal(regions.seconds, [[4, 24], [24, 4]])
    alone = map_file(tmp_path / "alone", "\ufeff" + lines, graph=None)
    assert make_regions(str(alone), [None] * 5, ids).seconds is None


@pytest.mark.parametrize(
    ("lines", "graph", "complaint"),
    [
        ("[x.png] = 0\nx,1", ROW_TEXT, r'line 2 is "x,1"'),
        ("[x.png] = 0\n[a/x.png] = 1", ROW_TEXT, "line 2 gives 'x' two regions"),
        ("[z.png] = 0", ROW_TEXT, r"lists none of the frames; list them as \[image_data/x.png\]"),
        ("[x.png] = 3", ROW_TEXT, "lists 3 regions, but images are in region 3"),
        ("[x.png] = 0", "hello", 'line 1 is "hello"'),
        (
            "[x.png] = 0\n[y.png] = 1",
            "0=[0],[4],[0];\n1=[0],[4],[0];",
            "no way leads from region 0 to 1",
        ),
        (f"[x.png] = {'9' * 5000}", None, "line 1 is"),
    ],
)
def test_bad_maps_and_graphs_name_what_is_wrong(
    lines: str, graph: str | None, complaint: str, tmp_path: Path
) -> None:
    with pytest.raises(DataError, match=complaint):
        make_regions(str(map_file(tmp_path, lines, graph)), [None, None], ("x", "y"))


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 24), st.integers(0, 1000))
def test_every_region_can_be_reached_on_a_graph_that_is_made(n_regions: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform(-9, 9, (n_regions, 2)).round(1)
    places[: n_regions // 2] = places[0]  # clusters of headings stand at one place
    between = 2 * np.linalg.norm(places[:, None] - places, axis=2) + 1
    nodes = make_graph(between, np.full(n_regions, 3.2), places)
    seconds = shortest_seconds(nodes)
    assert np.isfinite(seconds).all()
    np.testing.assert_array_equal(seconds, seconds.T)
    assert (seconds.diagonal() == 3).all()
    for region, node in enumerate(nodes):
        assert (len(node.neighbours), node.neighbours[4]) == (5, region)
        for neighbour, duration in zip(node.neighbours, node.durations, strict=True):
            assert neighbour == region or duration == round(between[region, neighbour])


def test_moves_go_by_the_map() -> None:
    places = np.array([(0, 0), (0, 5), (0, -5), (-5, 1), (5, 1), (20, 0)], float)
    between = np.linalg.norm(places[:, None] - places, axis=2)
    nodes = make_graph(between, np.ones(6), places)
    assert nodes[0].neighbours == (1, 2, 3, 4, 0)  # up, down, left, right, stay
    assert nodes[0].durations == (5, 5, 5, 5, 1)
    assert 4 in nodes[5].neighbours


def long_ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
    """Return seconds: views are 1 apart, rooms 100."""
    return np.array([float(abs(goal.index - start.index)) for goal in goals])


def test_measured_ways_replace_the_estimates() -> None:
    ground = Ground(make_views(3, 3), long_ways)
    before = ground.between.copy()
    ground.note_way(0, 3, 130.0)  # a detour of 30 seconds
    np.testing.assert_array_equal(ground.seconds_from(1), [1, 0, 1, 129, 130, 131])
    np.testing.assert_array_equal(ground.seconds_from(4), [101, 100, 99, 1, 0, 1])
    np.testing.assert_array_equal(ground.between, before + np.array([[0, 30], [0, 0]]))
    for seconds in (100.0, 100.0, 0.0, float("nan")):  # the last two are not known
        ground.note_way(0, 3, seconds)
    np.testing.assert_array_equal(ground.between, before)  # the median of 30, 0 and 0


def test_slow_ways_inside_a_region_cost_no_look_from_the_same_place() -> None:
    ground = Ground(make_views(3, 1), long_ways)
    ground.note_way(0, 1, 6.0)
    np.testing.assert_array_equal(ground.seconds_from(0), [0, 6, 7, 100])
    np.testing.assert_array_equal(ground.inside, [6, 0])
    ground.note_way(0, 1, 0.5)
    ground.note_way(1, 0, 0.2)
    assert (ground.seconds_from(1) >= 0).all()


def test_ways_that_agree_change_nothing_to_the_last_bit() -> None:
    def third(start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
        return long_ways(start, goals) / 3

    ground, other = (Ground(make_views(4, 4), third) for _ in range(2))
    for start, goal in ((0, 1), (1, 6), (6, 2)):
        ground.note_way(start, goal, (1 + 1e-9) * float(other.seconds_from(start)[goal]))
    for view in range(8):
        np.testing.assert_array_equal(ground.seconds_from(view), other.seconds_from(view))
    np.testing.assert_array_equal(ground.between, other.between)


@pytest.mark.parametrize("name", ["sweep:1", "rl-iac", "coverage", "progress-rate"])
def test_without_ways_nothing_is_measured(name: str) -> None:
    """As documented: as if they took no time, whatever looks cost."""

    def chosen(seconds: float) -> list[int]:
        strategy = make_strategy(name, make_views(4, 4), np.random.default_rng(0))
        views = []
        for _ in range(20):
            views.append(strategy.choose())
            strategy.update(views[-1], Outcome(0.5, seconds=seconds))
        return [view.index for view in views]

    assert chosen(0.0) == chosen(9.0)


@pytest.mark.parametrize("name", ["sweep:1", "iac", "rl-iac", "error"])
def test_strategies_count_on_what_a_way_took_before(name: str) -> None:
    """From the first room to the second it takes 250 seconds instead of 100."""
    strategy = make_strategy(
        name, make_views(1, 1), np.random.default_rng(1), ways=long_ways, n_stay=1
    )
    seconds, here = [], None
    for _ in range(20):
        view = strategy.choose()
        decision = strategy.reasons()  # type: ignore[attr-defined]
        if decision is not None and here == 0:
            seconds += [one.seconds for one in decision.candidates if one.region == 1]
        is_slow = (here, view.region) == (0, 1)
        way = 250.0 if is_slow else 100.0 * (here not in (None, view.region))
        strategy.update(view, Outcome(0.5, seconds=way))
        here = view.region
    assert set(seconds) <= {100.0, 250.0}
    assert seconds[-1] == 250.0


@pytest.fixture
def authors_folder(tmp_path: Path) -> Path:
    """Write 9 frames in three regions with the graph of `ROW`; poses are lost there."""
    write_folder(tmp_path / "room", 9)
    regions = [0, 1, 2] * 3
    write_rl_iac(open_dataset(tmp_path / "room"), tmp_path / "authors", regions=regions, graph=ROW)
    return tmp_path / "authors"


def test_explore_goes_by_the_authors_regions_and_ways(
    authors_folder: Path, tmp_path: Path, capsys: Capsys
) -> None:
    options = ("--strategy", "sweep:1", "--steps", 6, "--out", tmp_path / "out")
    said = succeed(capsys, "explore", authors_folder, *options).err
    assert "3 regions (file)" in said
    with (tmp_path / "out/decisions.csv").open() as file:
        seconds = {float(row["seconds"]) for row in csv.DictReader(file)}
    assert {0.0} < seconds <= {0.0, 8.0, 16.0, 24.0}


def test_comparisons_go_by_them_too(authors_folder: Path, tmp_path: Path) -> None:
    config = load_config(overrides={"explorer.strategy": "sweep:1", "test.every": 4, "test.gap": 0})
    prepared = prepare(str(authors_folder), config, tmp_path / "prepared")
    run = Run(prepared, config, seed=0)
    assert run.regions.names == ("0", "1", "2")
    rows = list(run.looks(4))
    ways = shortest_seconds(ROW)
    travelled = [ways[a.region, b.region] for a, b in pairwise(rows)]
    assert rows[-1].seconds == pytest.approx(4 + sum(travelled))
    assert sum(travelled) > 0


def test_exported_recording_has_a_graph_of_its_ways(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 8)
    out = tmp_path / "out"
    succeed(capsys, "export", tmp_path / "room", "--regions", "time:4", "--out", out)
    assert np.isfinite(shortest_seconds(read_graph(out / "region_map.dat"))).all()
    # What was written divides the recording that it was written from.
    facts = succeed(
        capsys, "info", tmp_path / "room", "--regions", out / "input_region_map.dat", "--json"
    ).out
    assert json.loads(facts)["regions"]["frames"] == [2, 2, 2, 2]


def test_bad_map_is_one_line(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 3)
    path = map_file(tmp_path / "map", "[q.png] = 0")
    line = refusal(capsys, "explore", tmp_path / "room", "--regions", path, "--out", tmp_path / "o")
    assert "lists none of the frames" in line
