"""Models of two robots become one, whichever comes first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from command import files, refusal, succeed
from curiosight.config import load_config
from curiosight.experiments.components import make_learner
from curiosight.frame import Camera, Frame, Label
from curiosight.frame.level import ground_axes
from curiosight.learner import places
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.merging import fingerprint, merge_all, merge_learners
from curiosight.teacher import CallTeacher

Capsys = pytest.CaptureFixture[str]
CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
# A room: where it begins along x, metres; the colours of its walls and of its things.
Room = tuple[float, tuple[int, int, int], tuple[int, int, int]]
KITCHEN: Room = (0.0, (90, 120, 90), (210, 40, 40))
BEDROOM: Room = (20.0, (120, 90, 130), (60, 200, 60))
OFFICE: Room = (40.0, (150, 140, 60), (40, 60, 220))


def views(room: Room, n_views: int, seed: int, *, shift: float = 0.0) -> list[Frame]:
    """Return views of a room: a square thing before a wall 2 m away; shift: of the world."""
    start, wall, thing = room
    rng = np.random.default_rng(seed)
    frames = []
    for number in range(n_views):
        rgb = np.clip(rng.normal(wall, 6, (120, 160, 3)), 0, 255).astype(np.uint8)
        depth = np.full((120, 160), 2.0, np.float32)
        v, u = rng.integers(10, 70), rng.integers(10, 110)
        rgb[v : v + 40, u : u + 40] = np.clip(rng.normal(thing, 6, (40, 40, 3)), 0, 255)
        depth[v : v + 40, u : u + 40] = 1.5
        pose = np.eye(4)
        # Looks along x, y is to the left, z is up.
        pose[:3, :3] = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]).T
        pose[:3, 3] = shift + start + 0.5 * (number % 4), rng.uniform(-0.4, 0.4), 1.0
        frames.append(Frame(f"{start:g}-{seed}-{number}", rgb, depth, CAMERA, pose))
    return frames


def label(frame: Frame) -> np.ndarray:
    assert frame.depth is not None
    return np.where(frame.depth < 1.8, Label.SALIENT, Label.NOT_SALIENT).astype(np.uint8)


def robot(frames: list[Frame], max_samples: int = 4000) -> SaliencyLearner:
    """Return a model that learned from frames, off-line."""
    settings = {"forest.max_samples": max_samples, "run.n_threads": 1, "forest.n_trees": 8}
    learner = make_learner(load_config(overrides=settings), CallTeacher(label))
    learner.fit([learner.visit(frame, learner.segment(frame)).lesson for frame in frames])
    learner.notes["frames"] = {"home": sorted(frame.id for frame in frames)}
    return learner


def quality(learner: SaliencyLearner, room: Room) -> float:
    """Return by how much things are more salient than their room."""
    gaps = []
    for frame in views(room, 4, 99):
        saliency, truth = learner.saliency(frame.rgb, frame.T_world_camera), label(frame)
        gaps.append(saliency[truth == 255].mean() - saliency[truth == 0].mean())
    return float(np.mean(gaps))


@pytest.fixture(scope="module")
def two() -> tuple[SaliencyLearner, SaliencyLearner]:
    """One was in the kitchen and the bedroom, the other in the bedroom and the office."""
    one = robot([*views(KITCHEN, 12, 0), *views(BEDROOM, 12, 1)])
    return one, robot([*views(BEDROOM, 12, 2), *views(OFFICE, 12, 3)])


def test_merged_model_knows_each_room_as_well_as_who_knew_it_better(
    two: tuple[SaliencyLearner, SaliencyLearner],
) -> None:
    before = [fingerprint(one) for one in two]
    merged = merge_learners(*two)
    assert [fingerprint(one) for one in two] == before
    assert sorted(merged.experts.n_views()) == [12, 12, 24]
    assert merged.n_samples <= 4000
    for room in (KITCHEN, BEDROOM, OFFICE):
        better = max(quality(one, room) for one in two)
        assert better > 0.5
        assert quality(merged, room) > better - 0.02
    assert len(merged.notes["frames"]["home"]) == 48


def test_order_does_not_matter_to_a_byte(
    two: tuple[SaliencyLearner, SaliencyLearner], tmp_path: Path, capsys: Capsys
) -> None:
    for name, learner in zip(("a", "b"), two, strict=True):
        (tmp_path / name).mkdir()
        learner.save(tmp_path / name / "model.npz")
    a, b = tmp_path / "a", tmp_path / "b"
    told = succeed(capsys, "merge", a, b, "--out", tmp_path / "ab")
    succeed(capsys, "merge", b, a, "--out", tmp_path / "ba")
    assert files(tmp_path / "ab") == {"model.npz", "config.toml", "summary.json"}
    for name in files(tmp_path / "ab"):
        assert (tmp_path / "ab" / name).read_bytes() == (tmp_path / "ba" / name).read_bytes()
    assert "places      3, of 24, 12, 12 views" in told.out
    read = SaliencyLearner.load(tmp_path / "ab")
    assert quality(read, OFFICE) == quality(merge_learners(*two), OFFICE)


def test_three_are_merged_in_any_order() -> None:
    learners = [robot(views(room, 8, 7)) for room in (KITCHEN, BEDROOM, OFFICE)]
    merged = [merge_all(order).experts.state_arrays() for order in (learners, learners[::-1])]
    assert merged[0].keys() == merged[1].keys()
    assert all(np.array_equal(merged[0][name], merged[1][name]) for name in merged[0])


def test_places_of_another_world_are_known_by_their_looks(
    two: tuple[SaliencyLearner, SaliencyLearner],
) -> None:
    """The second robot's world is shifted by the way from one room to the next."""
    shifted = robot([*views(BEDROOM, 12, 2, shift=100.0), *views(OFFICE, 12, 3, shift=100.0)])
    merged = merge_learners(two[0], shifted)
    assert sorted(merged.experts.n_views()) == [12, 12, 24]


def test_grids_that_are_turned_against_each_other_are_one(
    two: tuple[SaliencyLearner, SaliencyLearner], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each robot lays its own grid over the ground; which way does not matter."""
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    monkeypatch.setattr(places, "ground_axes", lambda up: turn @ ground_axes(up))
    turned = robot([*views(BEDROOM, 12, 2), *views(OFFICE, 12, 3)])
    merged = merge_learners(two[0], turned)
    assert sorted(merged.experts.n_views()) == [12, 12, 24]
    # Poses count, not looks alone.
    assert merged.experts.places is not None
    assert merged.experts.places.state_arrays()["places_cell_of_spot"].min() >= 0
    for room in (KITCHEN, BEDROOM, OFFICE):
        best = max(quality(one, room) for one in (two[0], turned))
        assert quality(merged, room) > best - 0.05


def test_what_cannot_be_merged_is_refused(
    two: tuple[SaliencyLearner, SaliencyLearner], tmp_path: Path, capsys: Capsys
) -> None:
    for name, learner in (("a", two[0]), ("small", robot(views(OFFICE, 8, 3), 1000))):
        (tmp_path / name).mkdir()
        learner.save(tmp_path / name / "model.npz")
    line = refusal(capsys, "merge", tmp_path / "a", tmp_path / "small", "--out", tmp_path / "out")
    assert "small: cannot be merged (forest: expected that of the first model" in line
    assert not (tmp_path / "out").exists()
    line = refusal(capsys, "merge", tmp_path / "a", "--out", tmp_path / "out")
    assert line == "curiosight: merge: expected two runs or more, got one"
    line = refusal(capsys, "merge", tmp_path / "a", tmp_path / "none", "--out", tmp_path / "out")
    assert "none: " in line
    with pytest.raises(ValueError, match="learners: expected at least two, got 1"):
        merge_all([two[0]])


def test_what_counts_nothing_or_twice_is_refused(
    two: tuple[SaliencyLearner, SaliencyLearner], tmp_path: Path, capsys: Capsys
) -> None:
    blank = make_learner(load_config(), CallTeacher(label))
    small = robot(views(OFFICE, 8, 3), 1000)
    for name, learner in (("a", two[0]), ("copy", two[0]), ("blank", blank), ("small", small)):
        (tmp_path / name).mkdir()
        learner.save(tmp_path / name / "model.npz")
    a, out = tmp_path / "a", tmp_path / "out"
    for twice in (a, tmp_path / "copy"):
        line = refusal(capsys, "merge", a, twice, "--out", out)
        assert line.endswith(f"holds the same model as {a}; give each once")
    line = refusal(capsys, "merge", a, tmp_path / "blank", "--out", out)
    assert line.endswith("blank: has learned nothing; leave it out")
    (tmp_path / "b").mkdir()
    two[1].save(tmp_path / "b" / "model.npz")
    line = refusal(capsys, "merge", a, tmp_path / "small", tmp_path / "b", "--out", out)
    assert f"{tmp_path / 'small'}: cannot be merged" in line
    assert not out.exists()


def test_models_without_places_are_merged_too() -> None:
    learners = []
    for room in (KITCHEN, OFFICE):
        learner = SaliencyLearner(CallTeacher(label), Forest(n_features=39, n_trees=4))
        for frame in views(room, 4, 5):
            learner.observe(frame)
        learners.append(learner)
    merged = merge_learners(*learners)
    assert merged.n_samples == sum(learner.n_samples for learner in learners)
    assert min(quality(merged, room) for room in (KITCHEN, OFFICE)) > 0.5
