"""RL-IAC folders: read as their authors describe them, and written so that they come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from curiosight.datasets import (
    GraphNode,
    RlIac,
    RlIacWriter,
    check_dataset,
    open_dataset,
    write_rl_iac,
)
from curiosight.datasets.cameras import calibration
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.layouts import rl_iac_writer
from curiosight.datasets.layouts.rl_iac_tables import (
    format_graph,
    format_regions,
    read_graph,
    read_regions,
)
from curiosight.errors import DataError
from recordings import (
    SIZE,
    truncate,
    write_depth,
    write_folder,
    write_image,
    write_osd,
    write_seven_scenes,
)
from room import View, poses_around, render

GRAPH = """\
# region=[up, down, left, right, stay],[timeup, timedown,  ...],[modelidx]
#
# 0   1
# o---o

0 = [0,0,0,1,0], [4,4,4,8,4], [0];
1 = [1,1,0,1,1], [4,4,8,4,4], [1];
"""
NODES = (
    GraphNode((0, 0, 0, 1, 0), (4, 4, 4, 8, 4), 0),
    GraphNode((1, 1, 0, 1, 1), (4, 4, 8, 4, 4), 1),
)


def write_authors_folder(root: Path, n_frames: int = 3, *, with_depth: bool = True) -> list[View]:
    """Write image_data, the table of regions and the graph, as the authors' readme has them."""
    camera = scaled_camera(calibration.KINECT, SIZE)
    views = [render(camera, pose) for pose in poses_around(n_frames)]
    for number, view in enumerate(views):
        write_image(root / f"image_data/img{number}.png", view.rgb)
        write_image(root / f"image_data/img{number}_GT.png", view.ground_truth)
        if with_depth:
            write_depth(root / f"image_data/img{number}_depth.png", view.depth)
    lines = [f"[image_data/img{number}.png] = {number % 2}" for number in range(n_frames)]
    (root / "input_region_map.dat").write_text("\n".join(lines))
    (root / "region_map.dat").write_text(GRAPH)
    return views


def opened(path: Path) -> RlIac:
    dataset = open_dataset(path)
    assert isinstance(dataset, RlIac)
    return dataset


@pytest.mark.parametrize("folder", [".", "image_data"])
def test_folder_is_guessed_and_read(folder: str, tmp_path: Path) -> None:
    views = write_authors_folder(tmp_path, 11)
    dataset = opened(tmp_path / folder)
    assert dataset.name == "RL-IAC"
    assert dataset.ids == tuple(f"img{number}" for number in range(11))
    assert dataset.regions == (0, 1) * 5 + (0,)
    assert dataset.graph == NODES
    frame = dataset[10]
    assert frame.problem is None
    np.testing.assert_array_equal(frame.rgb, views[10].rgb)
    np.testing.assert_allclose(frame.depth, views[10].depth, atol=0.0006)
    np.testing.assert_array_equal(dataset.ground_truth(10), views[10].ground_truth)
    assert dataset.camera is not None
    assert dataset.camera.fx == 525 / 4
    assert any("Kinect are assumed" in remark for remark in dataset.remarks)
    assert any("authors' program may have written" in remark for remark in dataset.remarks)
    check_dataset(dataset)


def test_masks_are_read_as_the_program_reads_them(tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    mask = np.zeros((120, 160), np.uint8)
    mask[:20], mask[20:40], mask[40:60], mask[60:80] = 255, 1, 125, 75
    write_image(tmp_path / "image_data/img0_GT.png", mask)
    truth = opened(tmp_path).ground_truth(0)
    np.testing.assert_array_equal(truth, np.select([mask == 0, mask % 254 == 1], [0, 255], 125))


def test_frames_outside_the_table_are_left_out(tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    (tmp_path / "input_region_map.dat").write_text("# a comment\n[img2.png] = 1\n\n[ img0.png ]=0;")
    dataset = opened(tmp_path)
    assert dataset.ids == ("img0", "img2")
    assert dataset.regions == (0, 1)
    assert "1 images are not in input_region_map.dat: left out" in dataset.remarks


def test_without_tables_all_is_one_region(tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    for name in ("input_region_map.dat", "region_map.dat"):
        (tmp_path / name).unlink()
    dataset = opened(tmp_path)
    assert (dataset.regions, dataset.graph) == ((0, 0, 0), ())


def test_folder_without_depth_is_for_maps_only(tmp_path: Path) -> None:
    write_authors_folder(tmp_path, with_depth=False)
    dataset = opened(tmp_path)
    assert not dataset.has_depth
    assert len(dataset) == 3
    assert dataset.has_ground_truth(2)
    check_dataset(dataset)


def test_missing_depth_costs_one_frame(tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    (tmp_path / "image_data/img1_depth.png").unlink()
    (tmp_path / "image_data/img2_GT.png").unlink()
    dataset = opened(tmp_path)
    assert dataset[1].problem == "img1_depth.png is missing"
    assert dataset[2].problem is None
    assert [dataset.has_ground_truth(index) for index in range(3)] == [True, True, False]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("input_region_map.dat", "img0.png = 0", 'line 1 is "img0.png=0"'),
        ("input_region_map.dat", "[img0.png] = -1", "expected: [image_data/x.png] = 0"),
        ("input_region_map.dat", "[img0.png]=0\n[a/img0.png]=1", "line 2 gives img0.png two"),
        ("input_region_map.dat", "[x.png] = 0", "lists none of the images; list files such as"),
        ("input_region_map.dat", "[img0.png] = 2", "lists 2 regions, but images are in region 2"),
        ("region_map.dat", "hello", 'line 1 is "hello"'),
        ("region_map.dat", "0 = [0,1], [4], [0];", "expected: 0 = [up, down, left, right, stay]"),
        ("region_map.dat", "0 = [0], [4], [0,1];", "expected: 0 = [up"),
        ("region_map.dat", "0 = [0], [-4], [0];", "expected: 0 = [up"),
        ("region_map.dat", "1 = [0], [4], [0];", "expected region 0"),
        ("region_map.dat", "0 = [1], [4], [0];", "region 0 leads to 1, which is not listed"),
    ],
)
def test_malformed_tables(name: str, text: str, words: str, tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    (tmp_path / name).write_text(text)
    with pytest.raises(DataError) as caught:
        open_dataset(tmp_path)
    assert caught.value.path.parent == tmp_path
    assert words in str(caught.value)


def test_tables_that_are_no_text(tmp_path: Path) -> None:
    write_authors_folder(tmp_path)
    (tmp_path / "region_map.dat").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match=r"region_map\.dat: cannot be read as text"):
        open_dataset(tmp_path)


def test_recording_comes_back_as_it_was_written(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path / "kitchen")
    source = open_dataset(tmp_path / "kitchen")
    assert write_rl_iac(source, tmp_path / "out", regions=(0, 1, 0), graph=NODES) == 3
    copy = opened(tmp_path / "out")
    assert copy.ids == source.ids
    assert copy.regions == (0, 1, 0)
    assert copy.graph == NODES
    assert copy.camera == source.camera
    check_dataset(copy)
    for index in range(3):
        np.testing.assert_array_equal(copy[index].rgb, source[index].rgb)
        np.testing.assert_allclose(copy[index].depth, source[index].depth, atol=0.0006)
        assert copy.has_ground_truth(index) == source.has_ground_truth(index)
    np.testing.assert_array_equal(copy.ground_truth(2), source.ground_truth(2))


def test_files_are_those_of_the_authors_readme(tmp_path: Path) -> None:
    write_osd(tmp_path / "osd", 2)
    write_rl_iac(open_dataset(tmp_path / "osd"), tmp_path / "out", indices=[1], graph=NODES)
    written = {path.name for path in (tmp_path / "out/image_data").iterdir()}
    assert written == {"learn1.png", "learn1_depth.png", "learn1_GT.png"}
    table = (tmp_path / "out/input_region_map.dat").read_text()
    assert table == "[image_data/learn1.png] = 0\n"
    graph = (tmp_path / "out/region_map.dat").read_text()
    assert graph.splitlines()[1] == "0 = [0,0,0,1,0], [4,4,4,8,4], [0];"


def test_bad_frames_and_those_in_no_region_are_left_out(tmp_path: Path) -> None:
    write_folder(tmp_path / "room", 5)
    truncate(tmp_path / "room/depth/000001.png")
    truncate(tmp_path / "room/ground_truth/000004.png")
    writer = RlIacWriter(
        open_dataset(tmp_path / "room"), tmp_path / "out", regions=(0, 0, -1, 1, 1)
    )
    problems = [frame.problem for frame in writer]
    assert problems == [
        None,
        "000001.png is truncated",
        None,
        "ground truth: 000004.png is truncated",
    ]
    assert writer.finish() == 2
    copy = opened(tmp_path / "out")
    assert copy.ids == ("000000", "000003")
    assert copy.regions == (0, 1)


def test_ids_become_names_that_the_program_keeps_apart(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path / "kitchen", 1, sequence="seq-02")
    write_seven_scenes(tmp_path / "kitchen", 1, sequence="seq-10")
    write_rl_iac(open_dataset(tmp_path / "kitchen"), tmp_path / "out")
    assert opened(tmp_path / "out").ids == ("seq-02_frame-000000", "seq-10_frame-000000")


@given(st.lists(st.text("a_ [/.-]#=GTdepth", min_size=1, max_size=12), unique=True))
def test_names_never_hold_what_the_program_looks_for(ids: list[str]) -> None:
    try:
        names = rl_iac_writer._file_names(ids)
    except ValueError:
        return
    assert len(set(names)) == len(ids)
    for name in names:
        assert "_depth" not in name
        assert "_GT" not in name
        assert not set(name) & set(" []#=/")


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    write_folder(tmp_path / "room")
    room = open_dataset(tmp_path / "room")
    with pytest.raises(ValueError, match="regions: expected 3, one a frame, got 2"):
        write_rl_iac(room, tmp_path / "out", regions=(0, 0))
    with pytest.raises(ValueError, match="graph: expected a node for region 2, got 2"):
        write_rl_iac(room, tmp_path / "out", regions=(0, 1, 2), graph=NODES)
    with pytest.raises(ValueError, match="dataset: expected one with depth"):
        write_rl_iac(open_dataset(tmp_path / "room/rgb"), tmp_path / "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="cannot be written"):
        write_rl_iac(room, tmp_path / "file")


def test_far_depth_is_no_reading() -> None:
    depth = np.array([[np.nan, 0.4, 65.534, 65.535, 1e6]], np.float32)
    np.testing.assert_array_equal(rl_iac_writer._millimetres(depth), [[0, 400, 65534, 0, 0]])


@given(st.dictionaries(st.text("abc019_-.", min_size=1), st.integers(0, 999), min_size=1))
def test_regions_survive_their_table(
    tmp_path_factory: pytest.TempPathFactory, region_of_file: dict[str, int]
) -> None:
    path = tmp_path_factory.mktemp("regions") / "input_region_map.dat"
    path.write_text(format_regions(region_of_file))
    assert read_regions(path) == region_of_file
    # The program would take any other line for an image.
    assert all(line.startswith("[") for line in path.read_text().splitlines())


@given(st.lists(st.tuples(st.integers(0, 99), st.integers(0, 9)), min_size=1, max_size=5))
def test_graph_survives_its_table(
    tmp_path_factory: pytest.TempPathFactory, learners: list[tuple[int, int]]
) -> None:
    nodes = tuple(
        GraphNode((place, 0), (duration, 1), learner)
        for place, (duration, learner) in enumerate(learners)
    )
    path = tmp_path_factory.mktemp("graph") / "region_map.dat"
    path.write_text(format_graph(nodes))
    assert read_graph(path) == nodes


@pytest.mark.parametrize(
    ("values", "words"),
    [(((0, 1), (4,)), "durations: expected 2"), (((0,), (-1,)), "numbers of 0 or more")],
)
def test_impossible_nodes(values: tuple[tuple[int, ...], tuple[int, ...]], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GraphNode(*values)
