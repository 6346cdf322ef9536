"""The oracle's trials: what they foretell comes true, and trying changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.config import Config, load_config
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.running import LookRow, Run
from curiosight.explorer.decision import Decision
from recordings import write_folder

N_STAY = 3


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Prepared:
    folder = tmp_path_factory.mktemp("source")
    write_folder(folder / "room", 16)
    return prepare(str(folder / "room"), settings("oracle"), folder / "prepared")


def settings(strategy: str, **explorer: str) -> Config:
    values = {"strategy": strategy, "n_stay": N_STAY, "regions": "time:3", **explorer}
    named = {f"explorer.{key}": value for key, value in values.items()}
    return load_config(overrides={"test.every": 5, "test.gap": 0, "run.n_threads": 1, **named})


def explored(run: Run, n_looks: int) -> tuple[list[LookRow], dict[int, Decision]]:
    """Return the looks, and by the number of the look that each led to the decisions."""
    rows, decisions = [], {}
    for row in run.looks(n_looks):
        reasons = run.strategy.reasons()  # type: ignore[attr-defined]
        if reasons is not None and reasons not in decisions.values():
            decisions[row.look] = reasons
        rows.append(row)
    return rows, decisions


def test_what_a_trial_foretells_comes_true(prepared: Prepared) -> None:
    rows, decisions = explored(Run(prepared, settings("oracle"), seed=1), 1 + 4 * N_STAY)
    assert sorted(decisions) == [2, 5, 8, 11]
    errors = [row.overall_error for row in rows]
    for look, decision in decisions.items():
        gains = {one.region: one.expected_gain for one in decision.candidates}
        fall = errors[look - 2] - errors[look + N_STAY - 2]
        assert gains[decision.chosen] == pytest.approx(fall, abs=1e-12)
    falls = {one.expected_gain for decision in decisions.values() for one in decision.candidates}
    assert len(falls) > len(decisions)


def test_trying_changes_nothing(prepared: Prepared) -> None:
    tried, plain = (Run(prepared, settings("sweep:3"), seed=2) for _ in range(2))
    rows = []
    for row in tried.looks(8):
        tried.tour.trial(tried.views[:4])
        rows.append(row)
    assert rows == list(plain.looks(8))
    assert (tried.learner.calibration.counts == plain.learner.calibration.counts).all()


def test_looks_are_scored_again_in_a_run_as_they_were(prepared: Prepared) -> None:
    """With them, `iac` has another progress than from the errors as they were made."""
    run = Run(prepared, settings("iac", progress="backward"), seed=3)
    rows = list(run.looks(30))
    assert any(run.strategy.progress_of(region) for region in range(run.regions.n_regions))
    forward = list(Run(prepared, settings("iac"), seed=3).looks(30))
    assert [row.error for row in rows] != [row.error for row in forward], "they choose otherwise"
    assert np.isfinite([row.overall_error for row in rows if row.overall_error is not None]).all()
