"""The catalogue: one entry a thing, and what became of it between visits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.catalogue import Catalogue, Entry, Thing, Visit, find_detections, find_things
from curiosight.catalogue.boxes import upright_box
from curiosight.catalogue.confidence import (
    WEIGHTS,
    confidence_of,
    measure_things,
    odds_of,
    share_of,
)
from curiosight.catalogue.detection import Detection
from curiosight.catalogue.glimpses import Glimpses
from curiosight.catalogue.grouping import group_detections
from curiosight.catalogue.hues import N_BANDS, N_BINS, N_HUES
from curiosight.catalogue.matching import Appearance, match_things, weigh_pairs
from curiosight.catalogue.voxels import SIDE, centres_of, grown, share_in, voxels_of
from curiosight.frame import Camera, Frame, Label
from curiosight.teacher import Segmentation

UP = np.array([0.0, 0.0, 1.0])
CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
RED, GREEN, BLUE, YELLOW = (200, 30, 30), (30, 160, 30), (30, 30, 200), (190, 180, 30)
# x, y, colour of boxes on a table: 16 x 16 x 10 cm.
Box = tuple[float, float, tuple[int, int, int]]
BEFORE: tuple[Box, ...] = ((-0.45, 0.0, RED), (0.0, -0.2, GREEN), (0.45, 0.0, BLUE))
AFTER: tuple[Box, ...] = ((-0.45, 0.0, RED), (0.0, 0.25, GREEN), (0.2, -0.25, YELLOW))
HIGH = 0.1


def look_down(boxes: tuple[Box, ...], x: float, id: str, *, blind: bool = False) -> Frame:
    """Return a view straight down from 1.5 m over (x, 0); blind: nothing is read right of it."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = x, 0.0, 1.5
    v, u = np.mgrid[:120, :160]
    rgb, depth = np.full((120, 160, 3), 128, np.uint8), np.full((120, 160), 1.5, np.float32)
    for box_x, box_y, colour in boxes:
        at_x = x + (u - CAMERA.cx) / CAMERA.fx * (1.5 - HIGH)
        at_y = -(v - CAMERA.cy) / CAMERA.fy * (1.5 - HIGH)
        here = (np.abs(at_x - box_x) < 0.08) & (np.abs(at_y - box_y) < 0.08)
        rgb[here], depth[here] = colour, 1.5 - HIGH
    if blind:
        depth[:, 80:] = np.nan
    return Frame(id, rgb, depth, CAMERA, pose)


def told(frame: Frame) -> Segmentation:
    """Label what rises over the table salient, as masks would."""
    assert frame.depth is not None
    is_high = frame.depth < 1.5 - HIGH / 2
    return Segmentation.of_labels(
        np.where(is_high, Label.SALIENT, Label.NOT_SALIENT).astype(np.uint8)
    )


def visit(boxes: tuple[Box, ...], *, blind: bool = False) -> Visit:
    made = Visit("table", UP)
    for number, x in enumerate((-0.1, -0.05, 0.0, 0.05, 0.1)):
        frame = look_down(boxes, x, f"{number}", blind=blind)
        made.add(frame, told(frame), place=3)
    return made


def near(entries: list[Entry], x: float, y: float) -> Entry:
    """Return the one entry within 3 cm."""
    places = [np.hypot(*(one.T_world_centre[:2, 3] - (x, y))) for one in entries]
    assert sum(place < 0.03 for place in places) == 1, places
    return entries[int(np.argmin(places))]


def test_views_of_a_thing_are_one_entry_with_its_place_and_size() -> None:
    entries = Catalogue().add(visit(BEFORE))
    assert [one.id for one in entries] == [1, 2, 3]
    for x, y, _ in BEFORE:
        entry = near(entries, x, y)
        assert entry.n_views == 5
        assert (entry.change, entry.place) == ("new", 3)
        assert np.allclose(entry.size_m[:2], 0.16, atol=0.075)
        assert abs(entry.T_world_centre[2, 3] - HIGH) < SIDE
        assert np.allclose(entry.T_world_centre[:3, 2], UP)
        assert 0.85 < entry.confidence < 1


def test_new_moved_gone_and_same_between_two_visits() -> None:
    catalogue = Catalogue()
    before = {one.id: one for one in catalogue.add(visit(BEFORE))}
    after = catalogue.add(visit(AFTER))
    found = {one.change: one for one in after}
    assert len(after) == len(found) == 4
    assert found["same"] is near(after, -0.45, 0.0)
    assert found["moved"] is near(after, 0.0, 0.25)
    assert found["gone"] is near(after, 0.45, 0.0)
    assert found["new"] is near(after, 0.2, -0.25)
    moved = found["moved"]
    assert moved.id == near(list(before.values()), 0.0, -0.2).id
    assert moved.T_world_before is not None
    assert np.allclose(moved.T_world_before[:2, 3], (0.0, -0.2), atol=0.03)
    assert moved.n_views == 10
    assert found["new"].id == 4
    assert found["gone"].seen[-1].visit == 0


def test_what_was_not_looked_at_again_is_not_gone() -> None:
    catalogue = Catalogue()
    catalogue.add(visit(BEFORE))
    after = catalogue.add(visit(AFTER, blind=True))
    assert near(after, 0.45, 0.0).change == "same"


def test_what_is_gone_comes_back_under_a_new_number() -> None:
    catalogue = Catalogue()
    for boxes in (BEFORE, BEFORE[:2], BEFORE):
        entries = catalogue.add(visit(boxes))
    here = [one for one in entries if np.hypot(*(one.T_world_centre[:2, 3] - (0.45, 0))) < 0.03]
    assert [one.change for one in here] == ["gone", "new"]


def test_a_camera_without_pose_and_an_empty_visit_are_refused() -> None:
    frame = replace(look_down(BEFORE, 0.0, "7"), T_world_camera=None)
    with pytest.raises(ValueError, match=r"frame: expected one with a pose, got 7 without"):
        find_detections(frame, told(frame))
    with pytest.raises(ValueError, match="visit: expected one with frames, got none"):
        Catalogue().add(Visit())
    with pytest.raises(ValueError, match=r"min_confidence: expected a number in \[0, 1\], got 2"):
        Catalogue(min_confidence=2)
    whole = look_down(BEFORE, 0.0, "8")
    with pytest.raises(ValueError, match=r"saliency: expected \(120, 160\) like the frame"):
        Visit().add(whole, told(whole), np.zeros((3, 3), np.float32))


def blob(x: float, width: float) -> Detection:
    """Return a detection of a plate of so many metres, 12 cm deep."""
    xs, ys = np.meshgrid(np.arange(x, x + width, 0.01), np.arange(0, 0.12, 0.01))
    points = np.stack([xs.ravel(), ys.ravel(), np.full(xs.size, 0.005)], axis=1)
    nothing = np.zeros(N_HUES, np.float32)
    mask = np.ones((12, round(100 * width)), np.bool_)
    size = (0, 0, mask.shape[1], 12)
    return Detection(size, mask, voxels_of(points), nothing, 0.0, "table", 1.0, True, np.nan)


def test_a_view_in_which_two_things_are_one_joins_them_not() -> None:
    left, right, both = blob(0.0, 0.15), blob(0.21, 0.15), blob(0.0, 0.36)
    views, shown = [0, 0, 1, 1, 2, 2, 3], [left, right, left, right, left, right, both]
    groups = group_detections(views, shown)
    of = {member: number for number, group in enumerate(groups) for member in group}
    assert of[0] == of[2] == of[4] != of[1] == of[3] == of[5]
    things = find_things(list(zip(views, shown, strict=True)))
    assert len(things) == 2
    centres = sorted(float(thing.box(UP)[0][0, 3]) for thing in things)
    assert np.allclose(centres, (0.075, 0.285), atol=0.05)


def upright(low: float, high: float, width: float, x: float = 0.0) -> Detection:
    """Return a detection of a square pillar over a floor at 0, metres."""
    sides = np.arange(-width / 2, width / 2 + 0.01, 0.015)
    points = np.stack(np.meshgrid(sides + x, sides, np.arange(low, high, 0.015)), axis=-1)
    flat = replace(blob(0.0, 0.12), voxels=voxels_of(points.reshape(-1, 3)))
    return replace(flat, support="floor")


@pytest.mark.parametrize(
    ("upper", "n_things"),
    [
        (upright(0.42, 0.8, 0.5), 1),  # a seat over its foot, which views show apart
        (upright(0.42, 0.8, 0.3, 0.6), 2),  # beside it: of something else that is not known
        (upright(0.7, 0.9, 0.3), 2),  # on a board high over it
        (replace(upright(0.42, 0.8, 0.5), base=0.42), 2),  # on a support of its own
        (replace(upright(0.42, 0.8, 0.5), base=np.nan), 2),
    ],
)
def test_what_hangs_in_the_air_is_one_with_what_is_under_it(
    upper: Detection, n_things: int
) -> None:
    foot = upright(0.0, 0.36, 0.4)
    seen = [(view, one) for view in range(4) for one in (foot, upper)]
    things = find_things(seen, UP)
    assert len(things) == n_things
    if n_things == 1:
        pose, size = things[0].box(UP)
        assert np.allclose([pose[2, 3], size[2]], [0.4, 0.8], atol=0.04)
    assert {view for thing in things for view in thing.views} == {0, 1, 2, 3}


def test_of_a_long_visit_every_few_views_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("curiosight.catalogue.things.MAX_DETECTIONS", 5)
    (thing,) = find_things([(view, blob(0.0, 0.15)) for view in range(20)])
    assert sorted(thing.views) == [0, 4, 8, 12, 16]
    assert find_things([]) == []


def test_voxels_are_where_the_points_are_and_grow_by_one() -> None:
    points = np.array([[0.001, 0.001, 0.001], [0.002, 0.002, 0.002], [-5.0, 7.0, 0.4]])
    voxels = voxels_of(points)
    assert len(voxels) == 2
    distances = np.abs(centres_of(voxels)[:, None] - points[None]).max(-1).min(1)
    assert (distances <= SIDE / 2 + 1e-9).all()
    assert len(grown(voxels)) == 54
    assert share_in(voxels, grown(voxels)) == 1
    assert share_in(voxels, voxels[:1]) == 0.5
    assert share_in(voxels[:0], voxels) == 0


def test_box_is_upright_and_turned_as_the_thing_is() -> None:
    rng = np.random.default_rng(0)
    turn = np.deg2rad(30)
    along = np.array([np.cos(turn), np.sin(turn), 0])
    across = np.cross(UP, along)
    inside = rng.uniform(-0.5, 0.5, (5000, 3)) * (0.4, 0.1, 0.2)
    points = inside @ np.stack([along, across, UP]) + (2.0, -1.0, 0.5)
    pose, size = upright_box(points, UP)
    assert np.allclose(pose[:3, 3], (2.0, -1.0, 0.5), atol=0.01)
    assert np.allclose(size, (0.1, 0.4, 0.2), atol=0.02)
    assert abs(pose[:3, 1] @ along) > 0.99
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3))
    assert np.linalg.det(pose[:3, :3]) > 0
    stands, (*_, height) = upright_box(points, UP, 0.0)
    assert abs(height - 0.6) < 0.02
    assert abs(stands[2, 3] - 0.3) < 0.01


def test_one_thing_is_matched_once_and_by_its_hue() -> None:
    def looks(hue: int, x: float) -> Appearance:
        hues = np.zeros((N_BANDS, N_BINS, N_BINS))
        hues[:, hue, hue] = 1 / N_BANDS
        surface = voxels_of(np.array([[x, 0.0, 0.0], [x + 0.1, 0.0, 0.0]]))
        return Appearance(np.array([x, 0, 0]), (0.1, 0.1, 0.2), hues.ravel(), surface)

    before = [looks(2, 0.0), looks(8, 1.0), looks(5, 2.0)]
    after = [looks(8, 1.6), looks(2, 0.0)]
    assert sorted(match_things(before, after)) == [(0, 1, True), (1, 0, False)]
    assert match_things([], after) == []


def test_a_pair_is_less_likely_in_another_place_on_another_level_or_where_one_is_doubtful() -> None:
    def thing(**changes: object) -> Appearance:
        surface = voxels_of(np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))
        hues = np.full(N_HUES, 1 / N_HUES)
        made = Appearance(np.zeros(3), (0.1, 0.1, 0.2), hues, surface, 0.0, 1, 9, 0.95)
        return replace(made, **changes)

    elsewhere = voxels_of(np.array([[3.0, 0.0, 0.0]]))
    moved = {"centre": np.array([3.0, 0, 0]), "voxels": elsewhere}
    others = [{}, {"place": 2}, {"place": None}, {"bottom": 0.8}, {"confidence": 0.2}]
    odds, is_same = weigh_pairs([thing()], [thing(**(moved | other)) for other in others])
    assert not is_same.any()
    alike, in_other_place, in_no_place, on_table, doubtful = odds[0]
    assert in_no_place == alike
    assert max(in_other_place, on_table, doubtful) < alike - 1


def plate(z: float, label: Label) -> Glimpses:
    """Return five views straight down on a plate as large as the image, told to be something."""
    glimpses = Glimpses()
    for x in (-0.1, -0.05, 0.0, 0.05, 0.1):
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = x, 0.0, 1.5
        depth = np.full((120, 160), 1.5 - z, np.float32)
        glimpses.add(depth, CAMERA, pose, np.full((120, 160), label, np.uint8))
    return glimpses


def test_a_floor_where_a_flat_thing_lay_is_free() -> None:
    xs, ys = np.meshgrid(np.arange(-0.2, 0.2, 0.02), np.arange(-0.2, 0.2, 0.02))
    flat = voxels_of(np.stack([xs.ravel(), ys.ravel(), np.full(xs.size, 0.02)], axis=1))
    assert plate(0.0, Label.NOT_SALIENT).look_for(flat) == (1, 0)
    assert plate(0.0, Label.UNKNOWN).look_for(flat) == (0, 1)
    assert plate(-0.4, Label.UNKNOWN).look_for(flat) == (1, 0)
    assert plate(0.5, Label.SALIENT).look_for(flat) == (0, 0)
    told = plate(0.0, Label.SALIENT).ask_about(flat)
    assert told[:4] == (5, 0, 1, 0)
    assert np.isnan(told.saliency)
    assert plate(0.0, Label.NOT_SALIENT).ask_about(flat)[:4] == (5, 0, 0, 1)


def test_views_that_look_elsewhere_are_left_out_and_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng = np.random.default_rng(3)
    glimpses = Glimpses()
    for _ in range(40):
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pose[:3, 3] = rng.uniform(-2, 2, 3)
        depth = rng.uniform(0.5, 4, (120, 160)).astype(np.float32)
        glimpses.add(depth, CAMERA, pose, np.zeros((120, 160), np.uint8))
    surfaces = [voxels_of(rng.uniform(-0.3, 0.3, (60, 3)) + at) for at in rng.normal(size=(9, 3))]
    looks = [sum(len(where) for _, _, where, _, _ in glimpses._looks(one)) for one in surfaces]
    assert min(map(len, map(glimpses._towards, map(centres_of, surfaces)))) < 30
    monkeypatch.setattr(Glimpses, "_towards", lambda self, _: self._views)
    assert looks == [sum(len(one[2]) for one in glimpses._looks(some)) for some in surfaces]


def test_what_stands_where_another_thing_stood_is_new_and_the_other_gone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Else a box of the same size in the same place is the same, whatever its hue.
    monkeypatch.setattr("curiosight.catalogue.matching.SAME_BONUS", 0.0)
    catalogue = Catalogue()
    catalogue.add(visit(BEFORE))
    (x, y, _), *others = BEFORE
    after = catalogue.add(visit(((x, y, YELLOW), *others)))
    here = [one for one in after if np.hypot(*(one.T_world_centre[:2, 3] - (x, y))) < 0.03]
    assert [one.change for one in here] == ["gone", "new"]
    assert [one.change for one in after if one not in here] == ["same", "same"]


def test_confidence_falls_where_views_see_floor_and_in_a_part_of_a_better_known_thing() -> None:
    whole = [(view, blob(0.0, 0.3)) for view in range(6)]
    part = [(view, blob(0.0, 0.09)) for view in range(6, 9)]
    things = [Thing(whole), Thing(part)]
    sizes = [thing.box(UP)[1] for thing in things]
    n_pixels = [640 * 480] * 2
    measures = measure_things(things, sizes, n_pixels, plate(0.0, Label.SALIENT))
    assert measures.shape == (2, len(WEIGHTS))
    of = {name: measures[:, place] for place, name in enumerate(WEIGHTS)}
    assert of["in_other"].tolist() == [0, 1]
    assert of["other_in"][1] > 0.2
    assert of["salient"].tolist() == [1, 1]
    on_floor = measure_things(things, sizes, n_pixels, plate(0.0, Label.NOT_SALIENT))
    assert (confidence_of(on_floor) < confidence_of(measures)).all()
    alone = measure_things(things[1:], sizes[1:], n_pixels[1:], plate(0.0, Label.SALIENT))
    assert confidence_of(alone)[0] > confidence_of(measures)[1]
    large = measure_things(things, sizes, [64 * 480] * 2, plate(0.0, Label.SALIENT))
    assert (confidence_of(large) > confidence_of(measures)).all()
    for share in (0.0, 0.3, 1.0):
        assert abs(share_of(odds_of(share)) - share) < 1e-5
