"""One learner, many threads: the bytes of one thread, also while another one learns."""

from __future__ import annotations

import copy
import pickle
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.config import Config
from curiosight.experiments.components import make_learner
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.teacher import Teacher, survey_recording
from room_world import RoomRecording

Image = npt.NDArray[np.uint8]
N_THREADS = 4


@pytest.fixture(scope="module")
def room() -> RoomRecording:
    return RoomRecording(8)


@pytest.fixture(scope="module")
def images(room: RoomRecording) -> list[Image]:
    """Different pictures, of two sizes in turn."""
    pictures = [frame.rgb for frame in room.frames]
    return [rgb[: -40 * (number % 2) or None] for number, rgb in enumerate(pictures)]


@pytest.fixture
def hurried() -> Iterator[None]:
    """Have threads take turns as often as they can."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


def taught(room: RoomRecording, preset: str, n_frames: int) -> SaliencyLearner:
    teacher = Teacher(survey_recording(room.frames[::4]))
    learner = make_learner(Config.of_preset(preset), teacher, np.random.default_rng(0))
    for frame in room.frames[:n_frames]:
        learner.observe(frame)
    return learner


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("preset", ["default", "paper"])
def test_threads_get_the_maps_of_one_thread(preset: str, room, images) -> None:
    learner = taught(room, preset, 3)
    serial = [learner.saliency(rgb).tobytes() for rgb in images]
    assert len(set(serial)) == len(serial)
    turns = [number % len(images) for number in range(12 * len(images))]
    with ThreadPoolExecutor(N_THREADS) as pool:
        maps = pool.map(lambda number: learner.saliency(images[number]).tobytes(), turns)
        assert list(maps) == [serial[number] for number in turns]


@pytest.mark.usefixtures("hurried")
def test_maps_while_another_thread_learns_are_of_before_or_after(room) -> None:
    learner = taught(room, "default", 2)
    learner.calibration = None  # votes are of one moment; their scale may be a frame ahead
    rgb = room.frames[5].rgb
    allowed = {learner.saliency(rgb).tobytes()}
    seen: list[npt.NDArray[np.float32]] = []
    is_over = threading.Event()

    def look() -> None:
        while not is_over.is_set():
            seen.append(learner.saliency(rgb))

    threads = [threading.Thread(target=look) for _ in range(N_THREADS - 1)]
    twin = copy.deepcopy(learner)  # it learns the same, and nobody looks meanwhile
    for thread in threads:
        thread.start()
    for frame in room.frames[2:8]:
        learner.observe(frame)
    is_over.set()
    for thread in threads:
        thread.join()
    for frame in room.frames[2:8]:
        twin.observe(frame)
        allowed.add(twin.saliency(rgb).tobytes())
    assert seen
    assert all(found.min() >= 0 and found.max() <= 1 for found in seen)
    assert {found.tobytes() for found in seen} <= allowed
    assert learner.saliency(rgb).tobytes() == twin.saliency(rgb).tobytes()


@pytest.mark.parametrize("method", ["update", "fit"])
def test_forest_changes_in_one_moment(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever asks between two trees of one change gets what was there before it."""
    rng = np.random.default_rng(0)
    rows = rng.integers(0, 256, (200, 3), dtype=np.uint8)
    forest = Forest(n_features=3, n_trees=6, vote="soft")
    forest.update(rows, rows[:, 0] > 99)
    before, state = forest.predict(rows), forest.state_arrays()
    grow, during = forest._grow, []

    def watched(*arguments):
        during.append((forest.predict(rows), forest.state_arrays()))
        return grow(*arguments)

    monkeypatch.setattr(forest, "_grow", watched)
    getattr(forest, method)(rows, rows[:, 1] > 99)
    assert len(during) == {"update": 4, "fit": 6}[method]
    for prediction, arrays in during:
        np.testing.assert_array_equal(prediction, before)
        assert all(np.array_equal(arrays[name], state[name]) for name in state)
    assert not np.array_equal(forest.predict(rows), before)


def test_model_that_was_used_can_be_copied(room, images) -> None:
    learner = taught(room, "default", 2)
    learner.teacher = None
    expected = learner.saliency(images[0])
    for twin in (copy.deepcopy(learner), pickle.loads(pickle.dumps(learner))):
        np.testing.assert_array_equal(twin.saliency(images[0]), expected)
