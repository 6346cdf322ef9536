"""Gymnasium environments: what others check of them, what they observe, what they reward."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curiosight.config import Config, load_config
from curiosight.evaluation import HeldOut
from curiosight.experiments.contest.prepared import META, Prepared, read_tests, write_tests
from curiosight.experiments.contest.running import Run
from curiosight.experiments.contest.tour import Tour
from curiosight.frame import Viewpoint
from recordings import write_folder, write_rooms

DOCS = Path(__file__).parent.parent / "docs" / "gym.md"
N_VIEWS, N_REGIONS, N_LOOKS = 15, 3, 12
IDS = ("curiosight/Look-v0", "curiosight/LookView-v0")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("source") / "room"
    write_folder(folder, N_VIEWS)
    return str(folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where sources are kept once they are prepared."""
    return tmp_path_factory.mktemp("prepared")


def settings(**overrides: Any) -> Config:
    named = {"test.every": 5, "test.gap": 0, "run.n_threads": 1, **overrides}
    return load_config(overrides={"explorer.regions": f"time:{N_REGIONS}", **named})


def make(source: str, folder: Path | None = None, name: str = IDS[0], **arguments: Any) -> Any:
    gymnasium = pytest.importorskip("gymnasium")
    arguments = {"config": settings(), "n_looks": N_LOOKS, **arguments}
    return gymnasium.make(f"curiosight.gym:{name}", source=source, folder=folder, **arguments)


def prepared_in(folder: Path) -> Path:
    """Return the only source kept in a folder."""
    (found,) = folder.glob(f"*/{META}")
    return found.parent


def act(env: Any, actions: list[int], seed: int) -> list[tuple[dict[str, Any], float, Any]]:
    """Return the observation, the reward and the info of each step after a reset."""
    env.reset(seed=seed)
    steps = [env.step(action) for action in actions]
    return [(observation, reward, info) for observation, reward, _, _, info in steps]


@pytest.mark.parametrize("name", IDS)
def test_check_env_has_nothing_to_remark(source: str, folder: Path, name: str) -> None:
    """Only an environment with a spec, from `make`, is checked for what no seed explains."""
    env = make(source, folder, name)
    from gymnasium.utils.env_checker import check_env

    assert env.spec.id == name
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


def test_look_by_look_it_learns_as_a_run_of_the_comparison(source: str, folder: Path) -> None:
    env = make(source, folder, IDS[1])
    run = Run(Prepared(prepared_in(folder)), settings(**{"explorer.strategy": "sweep:2"}), seed=4)
    rows = list(run.looks(N_LOOKS))
    ids = Prepared(prepared_in(folder)).ids
    steps = act(env, [ids.index(row.id) for row in rows], seed=4)
    for name in ("id", "region", "seconds", "metres", "overall_error"):
        assert [info[name] for _, _, info in steps] == [getattr(row, name) for row in rows]
    before, seconds, fallen = 1.0, 0.0, set()
    for (_, reward, _), row in zip(steps, rows, strict=True):
        assert reward * (row.seconds - seconds) == pytest.approx(before - row.overall_error)
        before, seconds = row.overall_error, row.seconds
        fallen.add(reward)
    assert len(fallen) > 2, "some looks teach more than others"


def test_a_region_is_looked_at_where_it_was_least_and_is_nearest(source: str, folder: Path) -> None:
    env = make(source, folder)
    ground = env.unwrapped.ground
    seen: list[int] = []
    ids = Prepared(prepared_in(folder)).ids
    known, _ = env.reset(seed=0)
    for region in (1, 1, 0, 1, 1, 1, 2):
        foretold = known["seconds"][region]
        known, _, _, _, info = env.step(region)
        view = ids.index(info["id"])
        among = ground.members[region]
        least = [v for v in among if seen.count(v) == min(seen.count(w) for w in among)]
        ways = ground.seconds_from(seen[-1] if seen else None)
        assert view in least
        assert ways[view] == ways[least].min() == pytest.approx(foretold)
        seen.append(view)
    assert known["looks"].tolist() == [1, 5, 1]


def test_what_is_known_of_a_region_is_what_strategies_know(source: str, folder: Path) -> None:
    env = make(source, folder, IDS[1])
    env.reset(seed=2)
    run = Run(Prepared(prepared_in(folder)), settings(), seed=2)
    rows = list(run.looks(N_LOOKS))
    ids = Prepared(prepared_in(folder)).ids
    for look, row in enumerate(rows, start=1):
        known, *_ = env.step(ids.index(row.id))
        assert known["looks"].sum() == known["view_looks"].sum() == look
        assert known["view_seconds"][ids.index(row.id)] == 0
        for region in range(N_REGIONS):
            errors = [r.error for r in rows[:look] if r.region == region]
            defined = [error for error in errors if error is not None]
            if defined:
                assert known["error"][region] == pytest.approx(np.mean(defined))
            elif not errors:
                assert known["error"][region] == known["uncertainty"][region] == 1
    told = [run.strategy.progress_of(region) for region in range(N_REGIONS)]
    assert any(told), "some region is learned"
    expected = [1.0 if progress is None else progress for progress in told]
    assert known["progress"] == pytest.approx(expected, abs=1e-6)


def test_seeds_decide_everything(source: str, folder: Path) -> None:
    env = make(source, folder)
    actions = [0, 1, 2, 0, 1, 2]
    (first, again, other) = (act(env, actions, seed) for seed in (7, 7, 8))
    errors = [[info["overall_error"] for _, _, info in steps] for steps in (first, again, other)]
    assert errors[0] == errors[1] != errors[2]
    unseeded = []
    for _ in range(2):
        env.reset()
        unseeded.append([env.step(action)[4]["overall_error"] for action in actions])
    assert unseeded[0] != unseeded[1], "each episode has chance of its own"


def test_an_episode_ends_when_it_was_said_to(source: str, folder: Path) -> None:
    from_class = make(source, folder, n_looks=3).unwrapped
    from gymnasium.error import ResetNeeded

    with pytest.raises(ResetNeeded):
        from_class.step(0)
    from_class.reset(seed=0)
    assert [from_class.step(0)[2:4] for _ in range(3)] == [(False, i == 2) for i in range(3)]
    with pytest.raises(ResetNeeded):
        from_class.step(0)
    late = make(source, folder, max_seconds=2.5)
    late.reset(seed=0)
    seconds, is_over = [], False
    while not is_over:
        _, _, _, is_over, info = late.step(0)
        seconds.append(info["seconds"])
    assert seconds[-2] < 2.5 <= seconds[-1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_looks": 0}, "n_looks: expected 1 or more, got 0"),
        ({"max_seconds": 0}, "max_seconds: expected a positive number, got 0"),
        ({"max_seconds": float("nan")}, "max_seconds: expected a positive number, got nan"),
        ({"render_mode": "human"}, "render_mode: expected None, got 'human'"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, Any], message: str) -> None:
    pytest.importorskip("gymnasium")
    from curiosight.gym.environment import LookEnv

    with pytest.raises(ValueError, match=re.escape(message)):
        LookEnv("nowhere", **arguments)


@pytest.mark.parametrize("action", [-1, N_REGIONS, 0.5])
def test_an_action_that_is_none_is_refused(source: str, folder: Path, action: float) -> None:
    env = make(source, folder).unwrapped
    env.reset(seed=0)
    with pytest.raises(ValueError, match=f"action: expected an integer from 0 to 2, got {action}"):
        env.step(action)


def test_a_change_of_the_source_is_nobodys_reward(source: str, tmp_path: Path) -> None:
    """From the third look on it is tested on other frames, as if the source had changed."""
    make(source, tmp_path)
    place = prepared_in(tmp_path)
    meta = Prepared(place).meta
    shutil.copytree(place / "phase0", place / "phase1")
    others = read_tests(place / "phase0")[:1]
    write_tests(place / "phase1", others)
    phases = [*meta["phases"], {**meta["phases"][0], "first_look": 2}]
    (place / META).write_text(json.dumps({**meta, "phases": phases}))

    views = [0, 7, 11]
    steps = act(make(source, tmp_path, IDS[1]), views, seed=5)
    tour = Tour(Prepared(place), settings(), np.random.default_rng(5).spawn(2)[0])
    errors = []
    for view in views:
        tour.enter_phase()
        errors.append(HeldOut(tour.learner, others).overall_error())
        seconds = tour.look(Viewpoint(view, 0, Prepared(place).poses[view])).seconds + 1
    errors.append(HeldOut(tour.learner, others).overall_error())
    _, reward, info = steps[2]
    assert info["overall_error"] == errors[3] != errors[2]
    assert reward == pytest.approx((errors[2] - errors[3]) / seconds)
    assert steps[1][2]["overall_error"] != errors[2], "as the frames before had it"


def test_sources_are_kept_where_one_says(source: str, tmp_path: Path) -> None:
    make(source, tmp_path)
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    make(source, tmp_path, IDS[1], n_looks=3, config=settings(**{"explorer.regions": "time:2"}))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == written
    other = replace(settings(), teacher=replace(settings().teacher, temporal=False))
    make(source, tmp_path, config=other)
    assert len(list(tmp_path.glob(f"*/{META}"))) == 2, "what it is to be taught is another"


def test_a_home_is_prepared_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gymnasium")
    from curiosight.gym import sources

    asked: list[tuple[str, Path]] = []
    monkeypatch.setattr(sources, "prepare", lambda place, _, to: asked.append((place, to)))
    for home in ("home:31,views=4", "home:31,views=5"):
        sources.prepared_source(home, settings(), tmp_path)
    assert [place for place, _ in asked] == ["home:31,views=4", "home:31,views=5"]
    assert len({folder for _, folder in asked}) == 2
    assert {folder.parent for _, folder in asked} == {tmp_path}


def test_without_a_folder_a_source_is_kept_until_the_process_ends(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("gymnasium")
    from curiosight.gym import sources

    monkeypatch.setattr(sources, "_until_the_end", lambda: tmp_path / "kept")
    make(source, None)
    assert prepared_in(tmp_path / "kept").is_dir()
    sources._remove(tmp_path / "kept", os.getpid() + 1)
    assert (tmp_path / "kept").is_dir(), "a forked process leaves it to its parent"
    sources._remove(tmp_path / "kept", os.getpid())
    assert not (tmp_path / "kept").exists()


def test_the_extra_is_named_where_gymnasium_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "curiosight.gym", raising=False)
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(ImportError, match=r"pip install 'curiosight\[gym\]'"):
        __import__("curiosight.gym")


def test_the_documented_bandit_loses_to_sweep(tmp_path: Path) -> None:
    """What docs/gym.md says of a home, of three small rooms that are as far apart."""
    write_rooms(tmp_path / "rooms", n_near=3)
    config = load_config(overrides={"test.every": 3, "test.gap": 0, "run.n_threads": 1})
    seconds, seeds = 100.0, range(4)
    errors, looks = {}, {}
    for agent, name in {"bandit": IDS[0], "sweep": IDS[1]}.items():
        env = make(
            str(tmp_path / "rooms"), tmp_path, name, config=config, n_looks=99, max_seconds=seconds
        )
        assert env.unwrapped.ground.n_regions == 3
        runs = [list(documented()[agent](env, seed)) for seed in seeds]
        errors[agent] = np.array([mean_over_time(rows, seconds) for rows in runs])
        looks[agent] = np.array([len(rows) for rows in runs])
    assert (2 * looks["bandit"] < looks["sweep"]).all(), "it goes back and forth between rooms"
    assert (errors["bandit"] > errors["sweep"]).all()
    assert errors["bandit"].mean() > errors["sweep"].mean() + 0.06


def documented() -> dict[str, Any]:
    """Return what the example in the docs defines."""
    names: dict[str, Any] = {}
    exec(re.findall(r"```python\n(.*?)```", DOCS.read_text("utf-8"), flags=re.S)[1], names)
    return names


def mean_over_time(rows: list[tuple[float, float]], until: float) -> float:
    """Return the mean of the error over the seconds; 1 until the first look is done."""
    seconds = np.minimum([0.0, *(row[0] for row in rows)], until)
    errors = np.array([1.0, *(row[1] for row in rows)])
    return float(np.diff(seconds, append=until) @ errors / until)


def test_the_mean_over_time_is_right() -> None:
    assert mean_over_time([(1.0, 0.5), (3.0, 0.1), (6.0, 0.0)], 4.0) == (1 + 2 * 0.5 + 0.1) / 4
