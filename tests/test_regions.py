"""Regions by pose, by time and from a file."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.errors import DataError
from curiosight.explorer.from_above import seen_from_above
from curiosight.explorer.grouping import MAX_GROUPED, group_by_ways
from curiosight.explorer.region_files import file_regions
from curiosight.explorer.regions import (
    make_regions,
    pose_regions,
    time_regions,
)
from curiosight.frame import Pose

UP = (0.0, 0.0, 1.0)  # the rooms of these tests have z up, as on a map


def stand(x: float, y: float, heading_deg: float, z: float = 1.0) -> Pose:
    """Return the pose of an upright camera at (x, y, z) that looks along a heading."""
    heading = np.radians(heading_deg)
    T_world_camera = np.eye(4)
    forward = np.array([np.cos(heading), np.sin(heading), 0])
    down = np.array([0, 0, -1])
    T_world_camera[:3, :3] = np.stack([np.cross(down, forward), down, forward], axis=1)
    T_world_camera[:3, 3] = x, y, z
    return T_world_camera


def room(n_views: int = 320, seed: int = 0) -> list[Pose]:
    rng = np.random.default_rng(seed)
    positions, headings = rng.uniform(-2, 2, (n_views, 2)), rng.uniform(0, 360, n_views)
    return [stand(x, y, heading) for (x, y), heading in zip(positions, headings, strict=True)]


def ids(n_views: int) -> list[str]:
    return [f"frame-{view:06d}" for view in range(n_views)]


def test_from_above_sees_positions_and_headings() -> None:
    for up in (UP, None):
        above = seen_from_above([stand(1, 2, 30), None, stand(-1, 0, -90)], up)
        np.testing.assert_allclose(above.positions, [(1, 2), (np.nan, np.nan), (-1, 0)])
        np.testing.assert_allclose(np.degrees(above.headings), [30, np.nan, -90])


def test_paper_grid_has_sixteen_regions_of_equal_size() -> None:
    regions = pose_regions(room(320))
    assert regions.n_regions == 16
    assert set(np.bincount(regions.of_view)) == {20}
    assert regions.kind == "pose:2x2x4"
    assert regions.names[5] == "x0 y1 heading 1"


def test_regions_are_compact_in_position_and_heading() -> None:
    poses = room(320)
    regions = pose_regions(poses)
    above = seen_from_above(poses)
    for region in range(16):
        inside = regions.of_view == region
        towards = np.exp(1j * above.headings[inside])
        assert np.ptp(above.positions[inside], axis=0).max() < 2.6  # of 4 metres
        assert np.abs(np.angle(towards / towards.mean())).max() < np.radians(75)


def test_quadrants_about_the_middle_of_the_map() -> None:
    corners = [(0, 0), (0, 3), (4, 0), (4, 3)]
    poses = [stand(x + 0.1 * step, y, 0) for x, y in corners for step in range(3)]
    poses += [stand(0.5, 0.5, 0)] * 20  # where many stand does not move the middle
    regions = pose_regions(poses, orientations=1, position_split="midpoint")
    assert list(regions.of_view) == [0] * 3 + [1] * 3 + [2] * 3 + [3] * 3 + [0] * 20


def test_sectors_of_a_quarter_turn_are_centred_on_the_axes() -> None:
    headings = [0, 44, -44, 46, 90, 134, 136, 180, -136, -134, -90, -46]
    poses = [stand(0, 0, heading) for heading in headings]
    regions = pose_regions(poses, positions=(1, 1), orientation_split="sector", up=UP)
    assert list(regions.of_view) == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]


def test_circle_of_headings_is_cut_at_its_largest_gap() -> None:
    headings = [170, 175, -175, -170, 20, 25, 30, 35]
    poses = [stand(0, 0, heading) for heading in headings]
    regions = pose_regions(poses, positions=(1, 1), orientations=2, up=UP)
    assert list(regions.of_view) == [1, 1, 1, 1, 0, 0, 0, 0]


def test_still_camera_makes_regions_by_heading_alone() -> None:
    regions = pose_regions([stand(1, 1, heading) for heading in range(0, 300, 5)], up=UP)
    assert regions.n_regions == 4
    assert set(np.bincount(regions.of_view)) == {15}


def test_other_grids_and_missing_poses() -> None:
    poses = [None, *room(240), None]
    regions = make_regions("pose:3x2x4", poses, ids(242))
    assert regions.n_regions == 24
    assert set(np.bincount(regions.of_view[1:-1])) == {10}
    assert (regions.of_view[0], regions.of_view[-1]) == (-1, -1)


def test_empty_regions_are_left_out() -> None:
    poses = [stand(0, 0, 0), stand(4, 4, 0)]
    regions = pose_regions(poses, position_split="midpoint", orientation_split="sector", up=UP)
    assert list(regions.of_view) == [0, 1]
    assert regions.names == ("x0 y0 heading 0", "x1 y1 heading 0")


@settings(deadline=None)
@given(st.integers(1, 60), st.integers(1, 3), st.integers(1, 3), st.integers(1, 5), st.data())
def test_every_posed_view_is_in_a_region_and_none_is_empty(
    n_views: int, n_x: int, n_y: int, n_orientations: int, data: st.DataObject
) -> None:
    poses: list[Pose | None] = list(room(n_views, seed=n_views))
    for view in data.draw(st.sets(st.integers(0, n_views - 1), max_size=n_views - 1)):
        poses[view] = None
    regions = pose_regions(
        poses,
        positions=(n_x, n_y),
        orientations=n_orientations,
        position_split=data.draw(st.sampled_from(["median", "midpoint"])),
        orientation_split=data.draw(st.sampled_from(["count", "sector"])),
    )
    is_posed = np.array([pose is not None for pose in poses])
    np.testing.assert_array_equal(regions.of_view >= 0, is_posed)
    assert set(regions.of_view[is_posed]) == set(range(regions.n_regions))
    assert regions.n_regions <= n_x * n_y * n_orientations


def test_headings_do_not_depend_on_the_axes_of_the_world() -> None:
    poses = room(40)
    turned = [stand(0, 0, 0) @ pose for pose in poses]
    before = pose_regions(poses, positions=(1, 1))
    after = pose_regions(turned, positions=(1, 1))
    same = before.of_view[:, None] == before.of_view
    np.testing.assert_array_equal(same, after.of_view[:, None] == after.of_view)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"positions": (0, 2)}, "positions"),
        ({"orientations": 0}, "orientations"),
        ({"position_split": "mean"}, "position_split"),
        ({"orientation_split": "even"}, "orientation_split"),
        ({"up": (0, 0, 0)}, "up"),
        ({"up": (0, 1)}, "up"),
    ],
)
def test_bad_options_are_named(options: dict, name: str) -> None:
    with pytest.raises(ValueError, match=rf"{name}.*: expected"):
        pose_regions(room(20), **options)


def home_ways(n_rooms: int, n_views: int) -> tuple[list[Pose], np.ndarray]:
    """Return poses in rooms beside each other, and ways that lead through a door of each."""
    rng = np.random.default_rng(0)
    room = np.repeat(np.arange(n_rooms), n_views)
    places = rng.uniform(0, 4, (len(room), 2)) + np.stack([4.2 * room, 0 * room], axis=1)
    doors = np.stack([4.2 * room + 2, np.full(len(room), -0.5)], axis=1)
    straight = np.linalg.norm(places[:, None] - places[None], axis=2)
    to_door = np.linalg.norm(places - doors, axis=1)
    corridor = np.linalg.norm(doors[:, None] - doors[None], axis=2)
    through = to_door[:, None] + corridor + to_door[None]
    metres = np.where(room[:, None] == room[None], straight, through)
    poses = []
    for x, y in places:
        pose = np.eye(4)
        # Level, looking anywhere.
        angle = rng.uniform(0, 2 * np.pi)
        pose[:3, 2] = [np.cos(angle), np.sin(angle), 0]
        pose[:3, 1] = [0, 0, -1]
        pose[:3, 0] = np.cross(pose[:3, 1], pose[:3, 2])
        pose[:2, 3] = x, y
        poses.append(pose)
    return poses, metres


def test_rooms_are_told_apart_by_the_ways_between_them() -> None:
    poses, metres = home_ways(6, 25)
    ids = [f"{number}" for number in range(len(poses))]
    for spec in ("auto", None):
        regions = make_regions(spec, poses, ids, metres=metres)
        assert regions.kind == "auto"
        np.testing.assert_array_equal(regions.of_view, np.repeat(np.arange(6), 25))
    by_heading = make_regions("auto:4", poses, ids, metres=metres)
    assert by_heading.n_regions == 24
    assert np.bincount(by_heading.of_view).min() >= 5


def test_of_thousands_of_views_few_ways_are_asked_for() -> None:
    _, metres = home_ways(6, 150)
    asked: set[int] = set()

    class Rows:
        def __len__(self) -> int:
            return len(metres)

        def __getitem__(self, view: int, /) -> np.ndarray:
            asked.add(view)
            return metres[view]

    found = group_by_ways(Rows())
    np.testing.assert_array_equal(found, np.repeat(np.arange(6), 150))
    assert len(asked) == MAX_GROUPED < len(metres)


def test_one_room_is_not_told_apart_from_others() -> None:
    poses, metres = home_ways(1, 60)
    ids = [f"{number}" for number in range(60)]
    assert make_regions(None, poses, ids, metres=metres).kind == "pose:2x2x4"
    assert make_regions("auto", poses, ids, metres=metres).n_regions <= 2
    with pytest.raises(ValueError, match="regions: expected the ways between views for `auto`"):
        make_regions("auto", poses, ids)


def test_time_slices_are_equal_and_in_order() -> None:
    regions = time_regions(11, 5)
    assert list(regions.of_view) == [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert regions.names == ("slice 0", "slice 1", "slice 2", "slice 3", "slice 4")


@pytest.mark.parametrize("spec", ["time:0", "time:6"])
def test_slices_must_not_be_empty(spec: str) -> None:
    with pytest.raises(ValueError, match=f"time:1 to time:5 for 5 frames, got {spec}"):
        make_regions(spec, [None] * 5, ids(5))


def test_default_is_by_pose_where_there_are_enough() -> None:
    assert make_regions(None, room(40), ids(40)).kind == "pose:2x2x4"
    half: list[Pose | None] = [*room(20), *[None] * 20]
    assert make_regions(None, half, ids(40)).kind == "pose:2x2x4"
    assert make_regions(None, [*half, None], ids(41)).kind == "time:5"
    assert make_regions(None, room(16), ids(16)).kind == "time:5"
    assert make_regions(None, [None] * 3, ids(3)).kind == "time:3"


def test_asking_for_poses_where_there_are_none_is_an_error() -> None:
    with pytest.raises(ValueError, match="regions: expected poses for `pose`, got none"):
        make_regions("pose", [None] * 20, ids(20))
    with pytest.raises(ValueError, match="poses: expected"):
        pose_regions([None] * 20)


@pytest.mark.parametrize("spec", ["poses", "pose:3x2", "time", "time:-1", "missing.csv", ""])
def test_other_specs_name_what_is_accepted(spec: str) -> None:
    with pytest.raises(ValueError, match=r"pose:3x2x4, time:5, or the path"):
        make_regions(spec, room(20), ids(20))


def test_regions_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "rooms.csv"
    lines = "# who where\n\nframe-000002, room 10\nframe-000000,room 2 # first\n"
    path.write_text(lines, encoding="utf-8-sig")  # as spreadsheets write it
    regions = make_regions(str(path), [None] * 4, ids(4))
    assert list(regions.of_view) == [0, -1, 1, -1]
    assert regions.names == ("room 2", "room 10")
    assert regions.kind == "file"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("frame-000000,1\nframe-000001 1\n", "line 2 is 'frame-000001 1'"),
        ("frame-000000,\n", "line 1 is"),
        (",3\n", "line 1 is"),
        ("\nframe-9,1\n", "line 2 names the unknown frame 'frame-9'"),
        ("frame-000000,1\nframe-000000,2\n", "line 2 gives 'frame-000000' two regions"),
        ("# nothing\n", "no frame is in any region"),
        (b"\xff\xfe\x00", "cannot be read as text"),
    ],
)
def test_bad_region_files_name_the_line(tmp_path: Path, text: str | bytes, complaint: str) -> None:
    path = tmp_path / "regions.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DataError, match=complaint):
        file_regions(path, ids(3))


def test_kitchen_divides_into_sixteen_even_regions() -> None:
    root = os.environ.get("CURIOSIGHT_TEST_DATA")
    if not root:
        pytest.skip("CURIOSIGHT_TEST_DATA is not set")
    paths = sorted((Path(root) / "data/redkitchen/seq-01").glob("*.pose.txt"))
    assert len(paths) == 500, f"no recording in {root}"
    regions = make_regions(None, [np.loadtxt(path) for path in paths], ids(500))
    assert regions.n_regions == 16
    assert set(np.bincount(regions.of_view)) == {31, 32}
    # A hand-held camera moves on smoothly: neighbours mostly share a region.
    assert np.count_nonzero(np.diff(regions.of_view)) < 60
