"""Forests by place: what is salient in one room is not in the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.learner.experts import COMMON, MIN_VIEWS, Experts, _origins
from curiosight.learner.forest import Forest
from curiosight.learner.lesson import Lesson
from curiosight.learner.looks import LOOK_SIZE
from curiosight.learner.places import Places
from curiosight.learner.scenery import Signs
from curiosight.learner.sight import Sight
from curiosight.learner.staleness import Staleness

N_FEATURES, N_SAMPLES = 4, 300
FAR = 30.0  # metres between two rooms


def make_experts(**settings: int) -> Experts:
    forest = Forest(n_features=N_FEATURES, n_trees=6, n_regrown=2, **settings)  # type: ignore[arg-type]
    return Experts(forest, Places())


def sight(room: int, seed: int) -> Sight:
    """Return a view of one of two rooms, whose colours and positions tell them apart."""
    chance = np.random.default_rng(seed)
    look = np.zeros(LOOK_SIZE, np.uint8)
    look[400 * room + chance.integers(0, 50, 9)] = 80
    T = np.eye(4)
    T[:3, 3] = FAR * room + chance.uniform(0, 2), chance.uniform(0, 2), 1
    around = np.linspace(0, 2 * np.pi, 90)
    rays = 3 * np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
    return Sight(look, T, rays, np.array([0.0, 0, 1]))


def samples(room: int, seed: int) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]:
    """Draw rows of which the high are salient in room 0, and the low in room 1."""
    rows = np.random.default_rng(seed).integers(0, 256, (N_SAMPLES, N_FEATURES), np.uint8)
    return rows, (rows[:, 0] > 127) ^ (room == 1)


def teach(experts: Experts, room: int, seed: int, error: float | None = 0.2) -> int:
    spot = experts.note(sight(room, seed))
    experts.update(*samples(room, seed), spot, error)
    return spot


def share_right(experts: Experts, room: int, *, seed: int = 999) -> float:
    rows, is_salient = samples(room, seed)
    return float(np.mean((experts.vote(rows, sight(room, seed)) > 0.5) == is_salient))


def taught(n_looks: int = 12) -> Experts:
    experts = make_experts()
    for look in range(n_looks):
        teach(experts, look % 2, look)
    return experts


def test_each_place_has_a_forest_that_knows_it() -> None:
    experts = taught()
    assert len(experts.of_place) == 2
    assert min(share_right(experts, room) for room in (0, 1)) > 0.95
    rooms = [samples(room, 999) for room in (0, 1)]
    right = [(experts.common.predict(rows) > 0.5) == is_salient for rows, is_salient in rooms]
    assert np.mean(right) < 0.6, "what holds in one room only confuses a common forest"


def test_one_place_needs_one_forest() -> None:
    experts = make_experts()
    for look in range(3):
        teach(experts, 0, look)
    assert experts.of_place == ()
    assert experts.common.n_samples == 3 * N_SAMPLES


def test_without_places_all_is_of_the_common_forest() -> None:
    experts = Experts(Forest(n_features=N_FEATURES, n_trees=6, n_regrown=2))
    assert experts.note(sight(0, 0)) == 0
    change = experts.update(*samples(0, 0), 0)
    assert change.trees == {COMMON: tuple(range(6))}
    assert experts.chosen(sight(1, 0)) == {COMMON: 1.0}


def test_samples_follow_their_spots_to_a_new_place() -> None:
    experts = make_experts()
    teach(experts, 0, 0)
    teach(experts, 0, 2)
    assert not experts.of_place
    teach(experts, 1, 1)
    first, second = experts.of_place
    assert first.n_samples == 2 * N_SAMPLES
    assert second.n_samples == N_SAMPLES
    assert set(first.groups) == {0, 1}
    assert set(second.groups) == {2}


def test_a_second_place_takes_nothing_from_the_first_but_its_share() -> None:
    experts = make_experts(max_samples=2000)
    for look in range(6):
        teach(experts, 0, look)
    assert experts.common.n_samples == 6 * N_SAMPLES
    teach(experts, 1, 6)
    first, second = experts.of_place
    assert first.n_samples == 750  # half of the three quarters that the common forest leaves
    assert second.n_samples == N_SAMPLES
    assert experts.common.n_samples == 500


def test_all_forests_together_keep_no_more_than_one_may() -> None:
    experts = make_experts(max_samples=2000)
    for look in range(16):
        teach(experts, look % 2, look)
        assert experts.n_samples <= 2000
    assert experts.n_samples > 1900
    # A place that nobody comes back to makes room, too.
    alone = make_experts(max_samples=2000)
    for look in range(20):
        teach(alone, int(look >= 10), look)
        assert alone.n_samples <= 2000


def test_a_place_is_known_once_it_was_seen_often() -> None:
    experts = make_experts()
    assert not experts.knows(sight(0, 0))
    for look in range(MIN_VIEWS):
        assert not experts.knows(sight(0, 50))
        teach(experts, 0, look)
    assert experts.knows(sight(0, 50))
    assert experts.knows(None)


def test_the_off_line_model_knows_the_places_too() -> None:
    experts = make_experts()
    experts.fit([Lesson(*samples(k % 2, k), sight(k % 2, k)) for k in range(12)])
    assert len(experts.of_place) == 2
    assert min(share_right(experts, room) for room in (0, 1)) > 0.95


@pytest.mark.parametrize("n_looks", [0, 1, 12])
def test_what_is_restored_predicts_and_goes_on_the_same(n_looks: int) -> None:
    experts, again = taught(n_looks), make_experts()
    again.restore(experts.state_arrays())
    rows, _ = samples(0, 5)
    for room in (0, 1):
        view = sight(room, 77)
        np.testing.assert_array_equal(again.vote(rows, view), experts.vote(rows, view))
    assert teach(experts, 1, 50) == teach(again, 1, 50)
    assert experts.n_samples == again.n_samples


def test_the_same_seed_learns_the_same() -> None:
    one, two = taught().state_arrays(), taught().state_arrays()
    assert one.keys() == two.keys()
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])


def test_what_a_place_was_leaves_first_once_it_has_changed() -> None:
    experts = make_experts(max_samples=80_000)
    for look in range(160):
        teach(experts, look % 2, look)
    old = experts.of_place[0].n_samples
    other = experts.of_place[1].state_arrays()
    alarms, n_regrown = [], []
    for look in range(200, 218):
        spot = experts.note(sight(0, look % 100))
        rows, is_salient = samples(0, look)
        change = experts.update(rows, ~is_salient, spot, 0.95)
        alarms.append(change.alarm)
        n_regrown.append(len(change.trees[0]))
    (alarm,) = filter(None, alarms)
    assert (alarm.place, alarm.cause) == (0, "errors")
    assert alarm.was < 0.3
    assert alarm.now == pytest.approx(0.95)
    assert alarm.reason == f"new things: errors are 0.95, usually {alarm.was:.2f}"
    n_after = len(alarms) - alarms.index(alarm)
    # Two of six trees a look, and then as many again, which may be the same.
    assert set(n_regrown[:-n_after]) == {2}
    assert max(n_regrown[-n_after:]) == 4
    assert experts.of_place[0].n_samples == old + (18 - n_after) * N_SAMPLES
    # Nothing else forgets or regrows.
    for name, array in experts.of_place[1].state_arrays().items():
        np.testing.assert_array_equal(array, other[name])
    for look in range(218, 300):
        spot = experts.note(sight(0, look % 100))
        rows, is_salient = samples(0, look)
        experts.update(rows, ~is_salient, spot, 0.3)
    assert share_right(experts, 0) < 0.1
    assert share_right(experts, 1) > 0.95


def test_what_is_known_of_changes_follows_its_views() -> None:
    staleness = Staleness()
    for place in range(3):
        for look in range(place + 1):
            pose = np.eye(4)
            pose[0, 3] = 3 * look
            staleness.note(place, pose, Signs(gone=0.1 * look), None)
    staleness.note(3, None, Signs(), None)  # a look counts once the next is from another spot
    origins = _origins(np.array([0, 0, 1, 1, 1, 2]), np.array([1, 1, 0, 0, 3, 2, 2, 4]))
    assert origins == {1: 0, 0: 1, 3: 1, 2: 2}
    staleness.move(origins)
    n_known = {place: len(one.rises["gone"].known) for place, one in staleness.drifts.items()}
    assert n_known == {1: 1, 0: 2, 3: 2, 2: 3}
    assert staleness.drifts[0] is not staleness.drifts[3]


def test_what_was_never_seen_is_no_drift() -> None:
    experts = make_experts()
    for look in range(160):
        teach(experts, look % 2, look)

    def walk() -> list[bool]:
        """Look from eight spots in a row where nobody has been before."""
        drifted = []
        for step in range(8):
            view = sight(0, step)
            assert view.T_world_camera is not None
            view.T_world_camera[:3, 3] = 2.25 + 0.5 * (step % 4), 0.25 + 0.5 * (step // 4), 1
            spot = experts.note(view)
            change = experts.update(*samples(0, step), spot, 0.95)
            drifted.append(change.has_drifted)
        return drifted

    assert not any(walk())
    assert any(walk() + walk())
