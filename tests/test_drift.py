"""When a place is no longer what was learned of it: tests on numbers, and on drawn rooms."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.frame import Camera, Frame, Label
from curiosight.learner.drift import ALARM, CAUSES, Alarm, Cause, Drift, Event
from curiosight.learner.forest import Forest
from curiosight.learner.glance import N_ACROSS, N_DOWN, Glance, colours_of
from curiosight.learner.rise import LEAST_KNOWN, N_KEPT, N_NEWEST, Rise, winnings
from curiosight.learner.scenery import Scenery, Signs
from curiosight.learner.staleness import Staleness
from curiosight.viewing.report import Report
from curiosight.viewing.report.page import report_html

Floats = npt.NDArray[np.float64]
CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
WALL, BOX = 2.5, 1.8  # metres ahead


def test_a_bet_wins_nothing_on_average() -> None:
    p = (np.arange(1_000_000) + 0.5) / 1_000_000
    assert np.mean([winnings(one) for one in p.tolist()]) == pytest.approx(1, abs=0.03)
    # Ranks among those known are a little larger than uniform, so that bets lose.
    ranks = np.arange(1, 101) / 100
    assert 0.7 < np.mean([winnings(one) for one in ranks.tolist()]) < 1


def draw(kind: str, n: int, seed: int) -> Floats:
    """Return (n, 5) independent numbers."""
    chance, shape = np.random.default_rng(seed), (n, len(CAUSES))
    if kind == "falling":
        return np.asarray(chance.normal(size=shape) - np.arange(n)[:, None] / 100)
    if kind == "rare":
        return (chance.random(shape) < 0.02).astype(float)
    return {"normal": chance.normal, "heavy": chance.standard_cauchy}[kind](size=shape)


@pytest.mark.parametrize("kind", ["normal", "heavy", "falling", "rare"])
def test_what_does_not_change_gives_no_alarm(kind: str) -> None:
    """By design 0.3 in 10 000 looks; in these 6000 one is rare, and two never come."""
    alarms = []
    for seed in range(12):
        drift = Drift()
        for *signs, error in draw(kind, 500, seed).tolist():
            alarms.append(drift.add(0, Signs(*signs), error))
    assert sum(alarm is not None for alarm in alarms) <= 1


def test_evidence_grows_by_about_one_a_number_while_nothing_changes() -> None:
    chance, last = np.random.default_rng(3), []
    for _ in range(300):
        rise = Rise()
        last.append([rise.add(one) for one in chance.normal(size=150).tolist()][-1])
    # P(evidence >= a) <= n / a where that is exact (Markov); it is nearly.
    n = 150 - LEAST_KNOWN - N_NEWEST
    assert np.median(last) < n
    assert np.mean(np.array(last) >= 20 * n) <= 0.08


def test_a_rise_is_found_soon_and_dated() -> None:
    chance, rise = np.random.default_rng(0), Rise()
    for one in chance.normal(0.3, 0.1, 150).tolist():
        assert rise.add(one) < 1000
    n = 0
    while rise.add(float(chance.normal(0.7, 0.1))) < ALARM * len(CAUSES):
        n += 1
        assert n < 12
    assert abs(rise.n_since - (n + 1)) <= 2
    assert len(rise.known) == 151 + n


def test_little_is_known_at_first_and_memory_has_an_end() -> None:
    rise = Rise()
    for one in range(LEAST_KNOWN + N_NEWEST):
        assert rise.add(float(one)) == 0
    assert rise.add(1e9) > 0
    for _ in range(2 * N_KEPT + N_NEWEST):
        rise.add(0.0)
    assert len(rise.known) == N_KEPT + N_NEWEST


@pytest.mark.parametrize("cause", CAUSES)
def test_an_alarm_says_its_reason(cause: Cause) -> None:
    chance, drift = np.random.default_rng(1), Drift()
    alarms = []
    for look in range(120):
        numbers = {one: float(chance.uniform(0.1, 0.3)) for one in CAUSES}
        numbers[cause] += 0.5 * (look >= 90)
        error = numbers.pop("errors")
        alarms.append(drift.add(4, Signs(**numbers), error))
    looks = [look for look, alarm in enumerate(alarms) if alarm is not None]
    assert looks[0] in range(94, 106)
    alarm = alarms[looks[0]]
    assert alarm is not None
    assert (alarm.place, alarm.cause) == (4, cause)
    assert alarm.was == pytest.approx(0.2, abs=0.02)
    assert alarm.now == pytest.approx(0.7, abs=0.1)
    begin = {"gone": "objects moved: ", "new": "new things: ", "errors": "new things: "}
    assert alarm.reason.startswith(begin.get(cause, "light changed: "))
    assert alarm.summary()["reason"] == alarm.reason
    assert len(looks) == 1  # it is forgotten then


def test_looks_that_tell_nothing_do_not_count() -> None:
    drift = Drift()
    for _ in range(1000):
        assert drift.add(0, Signs(), None) is None
    assert all(not rise.known for rise in drift.rises.values())


def test_percents_are_of_what_is_said() -> None:
    assert Alarm(0, "gone", 0.051, 0.34, 7).reason == (
        "objects moved: 34% of what stood in view is gone, usually 5%"
    )


def test_an_event_says_when_and_where() -> None:
    event = Event(71, "000011", Alarm(2, "tint", 0.03, 0.12, 6))
    assert event.sentence == (
        "look 71, place 2: light changed: views are redder or bluer than before by 12%, "
        "usually by 3% (000011)"
    )
    assert event.summary() == {
        **{"look": 71, "id": "000011", "place": 2, "cause": "tint", "was": 0.03, "now": 0.12},
        **{"n_looks": 6, "reason": event.alarm.reason},
    }
    only = Event(71, "000011", Alarm(-1, "tint", 0.03, 0.12, 6))
    assert only.sentence.startswith("look 71: light changed")


def test_a_report_tells_what_changed() -> None:
    page = report_html(Report("A look around", "It looked.", events=["look 7: objects <moved>"]))
    assert "What changed" in page
    assert "look 7: objects &lt;moved&gt;" in page
    assert "What changed" not in report_html(Report("A look around", "It looked."))


def frame(
    seed: int,
    *,
    box: float | None = 0.0,
    gain: float = 1.0,
    shade: float = 0.0,
    red: float = 1.0,
    shift: float = 0.0,
) -> tuple[Frame, npt.NDArray[np.uint8]]:
    """Look at a wall with a box before it, from a little aside.

    box: metres right of the middle of the wall, None = it is not there. shade: how much darker the
    wall is at its right end. The wall's pattern is of 20 cm.
    """
    chance = np.random.default_rng(seed)
    aside = shift + float(chance.uniform(-0.05, 0.05))
    u = (np.arange(CAMERA.width) - CAMERA.cx) / CAMERA.fx
    v = (np.arange(CAMERA.height) - CAMERA.cy) / CAMERA.fy
    depth = np.full((CAMERA.height, CAMERA.width), WALL)
    labels = np.full(depth.shape, Label.NOT_SALIENT, np.uint8)
    if box is not None:
        is_box = (abs(u * BOX + aside - box)[None] < 0.25) & (abs(v * BOX)[:, None] < 0.25)
        depth[is_box], labels[is_box] = BOX, Label.SALIENT
    x = u[None] * depth + aside
    pattern = 110 + 25 * np.sign(np.sin(x * np.pi / 0.2 + 0.3))
    light = gain * chance.uniform(0.9, 1.1) * (1 - shade * np.clip(x + 1, 0, 2) / 2)
    rgb = (pattern * light)[..., None] * np.array([red, 1.0, 1.0]) + chance.normal(
        0, 3, (*depth.shape, 3)
    )
    pose = np.eye(4)
    pose[0, 3] = aside
    noisy = (depth + chance.normal(0, 0.005, depth.shape)).astype(np.float32)
    image = np.clip(rgb, 0, 255).astype(np.uint8)
    return Frame(str(seed), image, noisy, CAMERA, pose), labels


def glance(seed: int, **changes: float | None) -> Glance:
    found = Glance.of(*frame(seed, **changes))  # type: ignore[arg-type]
    assert found is not None
    return found


def settled(n_views: int = 30) -> Scenery:
    scenery = Scenery()
    for seed in range(n_views):
        scenery.look(glance(seed))
    return scenery


def test_a_view_of_what_is_known_shows_no_sign_of_change() -> None:
    scenery = settled()
    for seed in range(100, 110):
        signs = scenery.look(glance(seed))
        assert signs.light == pytest.approx(0, abs=0.04)
        assert signs.tint == pytest.approx(0, abs=0.02)
        assert signs.gone == pytest.approx(0, abs=0.05)
        assert signs.new == pytest.approx(0, abs=0.05)


def test_first_views_tell_nothing() -> None:
    scenery = Scenery()
    assert scenery.look(glance(0)) == Signs()


@pytest.mark.parametrize(
    ("changes", "sign", "expected"),
    [
        # The ends of the wall are as bright as it was, and 0.6 of it: ± 0.26 in logarithms.
        ({"shade": 0.4}, "light", pytest.approx(0.17, abs=0.04)),
        ({"red": 1.2}, "tint", pytest.approx(math.log(1.2), abs=0.02)),
        ({"box": None}, "gone", pytest.approx(1, abs=0.05)),
        ({"box": 0.6}, "gone", pytest.approx(0.95, abs=0.1)),
        ({"box": 0.6}, "new", pytest.approx(0.8, abs=0.2)),
    ],
)
def test_each_change_is_told_by_its_own_sign(
    changes: dict[str, float | None], sign: str, expected: float
) -> None:
    signs = settled().look(glance(100, **changes))
    assert getattr(signs, sign) == expected
    others = (
        {"light", "tint", "gone", "new"} - {sign} - ({"gone", "new"} if "box" in changes else set())
    )
    for other in others:
        assert (getattr(signs, other) or 0) < 0.06


def test_exposure_is_no_change_of_light() -> None:
    signs = settled().look(glance(100, gain=0.6))
    assert signs.light == pytest.approx(0, abs=0.04)
    assert signs.tint == pytest.approx(0, abs=0.02)


def test_what_has_gone_is_forgotten() -> None:
    scenery = settled()
    gone = [scenery.look(glance(100 + look, box=None)).gone for look in range(8)]
    assert gone[:3] == pytest.approx([1, 1, 1], abs=0.1)
    assert gone[-1] is None


def test_memory_of_ever_new_walls_has_an_end() -> None:
    scenery = Scenery(max_voxels=8000)
    for look in range(100):
        scenery.look(glance(look, shift=3.0 * (look // 4)))
    assert 2000 < len(scenery) <= 8000
    # What was seen last is still known, and what was seen first is not.
    assert scenery.look(glance(100, shift=3.0 * 24)).light is not None
    assert scenery.look(glance(100)).light is None


def test_what_is_copied_goes_on_alike() -> None:
    one = settled(10)
    other = pickle.loads(pickle.dumps(one))
    for seed in range(20, 26):
        assert one.look(glance(seed)) == other.look(glance(seed))
    assert len(one) == len(other)


def test_a_frame_without_pose_or_depth_gives_no_glance() -> None:
    whole, labels = frame(0)
    assert Glance.of(replace(whole, T_world_camera=None), labels) is None
    assert Glance.of(replace(whole, depth=None), labels) is None
    found = Glance.of(whole, labels)
    assert found is not None
    assert found.depth.shape == found.is_salient.shape == (N_DOWN, N_ACROSS)
    assert found.colours.shape == (N_DOWN, N_ACROSS, 3)


def test_colours_are_logarithms_where_they_can_be_told() -> None:
    rgb = np.array([[[100, 50, 200], [0, 50, 50], [50, 250, 50]]], np.uint8)
    colours = colours_of(rgb)
    expected = [math.log(100), math.log(2), math.log(4)]
    np.testing.assert_allclose(colours[0, 0], expected, atol=1e-5)
    assert np.isnan(colours[0, 1:]).all()


def test_looks_from_one_spot_count_once_and_when_it_is_left() -> None:
    pose, turned, away = (np.eye(4) for _ in range(3))
    turned[:3, 2] = 1, 0, 0
    away[0, 3] = 1.5
    staleness = Staleness()
    for error in (0.2, 0.4):
        staleness.note(0, pose, Signs(tint=error / 2), error)
    assert not staleness.drifts
    staleness.note(0, turned, Signs(), None)
    assert list(staleness.drifts[0].rises["errors"].known) == pytest.approx([0.3])
    assert list(staleness.drifts[0].rises["tint"].known) == pytest.approx([0.15])
    staleness.note(0, away, Signs(), 0.5)
    staleness.note(1, away, Signs(), 0.5)
    assert list(staleness.drifts[0].rises["errors"].known) == pytest.approx([0.3, 0.5])


def test_without_poses_ten_looks_in_a_row_count_once() -> None:
    staleness = Staleness()
    for look in range(25):
        staleness.note(0, None, Signs(), 0.1 * (look // 10))
    assert list(staleness.drifts[0].rises["errors"].known) == pytest.approx([0.0, 0.1])


@pytest.mark.parametrize(("cause", "leaves"), [("gone", True), ("light", False)])
def test_what_a_place_was_leaves_unless_it_comes_back(cause: Cause, leaves: bool) -> None:
    rng = np.random.default_rng(0)
    forest = Forest(n_features=3, n_trees=40, n_regrown=1, max_samples=1000)
    staleness = Staleness()

    def learn(n: int, group: int) -> int:
        """Learn samples of a group; return how many trees regrew."""
        rows = rng.integers(0, 256, (n, 3), np.uint8)
        staleness.make_room(0, forest, n)
        regrown = forest.update(rows, rows[:, 0] > 127, group)
        return len(staleness.regrow(0, forest, regrown))

    learn(60, group=1)
    staleness.begin(Alarm(0, cause, 0.1, 0.5, 5), forest)
    assert [learn(25, group=2) for _ in range(3)] == [2, 2, 1]
    assert np.bincount(forest.groups).tolist() == [0, 0 if leaves else 60, 75]
    assert not staleness.stale
