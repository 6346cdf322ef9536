"""What the paper says of its figures, asked of the same figures of another source."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.evaluation import MethodScores
from curiosight.evaluation.bootstrap import bootstrap_interval
from curiosight.experiments.comparing import DEPTH, Comparison
from curiosight.experiments.contest.table import Curve
from curiosight.experiments.paper_figures.evolution import Snapshot, Target

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# "At the beginning": of the looks. "At the end": so near to the off-line model's F1.
BEGINNING = 0.25
REACHED = 0.95
# So many frames "suffice": where runs are longer than that, and little falls after it.
ENOUGH_LOOKS, LITTLE = 1000, 0.01
# Where false positives are "very low".
LOW_RATE = 0.01
# Of fewer seeds resampling gives no interval of a standard deviation.
LEAST_SEEDS = 3
# Errors of seeds that differ by no more do so by rounding.
ALIKE = 1e-6
_BASELINE = "BMS"
_Statistic = Callable[[Any], float | None]


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper, and the number that decides it.

    holds: whether it is true here; None = the interval has both. value: above 0 speaks for it.
    low, high: 95 %, bootstrap over `over`; None where there is none.
    """

    figure: int
    claim: str
    value: float
    low: float | None
    high: float | None
    over: str

    @property
    def holds(self) -> bool | None:
        if self.low is None or self.high is None:
            return self.value > 0
        return None if self.low <= 0 < self.high else self.low > 0


def claims_of_roc(comparison: Comparison, seed: int) -> list[Claim]:
    """Compare the ROC curves of figure 3."""
    ours = comparison.scores[comparison.ours]
    n_ours = len(ours.maps.frames)
    scores = {
        name: one
        for name, one in comparison.scores.items()
        if len(one.maps.frames) == n_ours and one.maps.ranking().roc_auc is not None
    }
    others = {name: one for name, one in scores.items() if name not in (comparison.ours, DEPTH)}
    if not others or comparison.ours not in scores:
        return []
    over = f"{n_ours} frames"
    best = max(others, key=lambda name: others[name].maps.ranking().roc_auc or 0)
    claim = f"AUC above that of all others (the best is {best}): difference"
    claims = [_gain(3, claim, ours, others[best], over, seed)]
    if DEPTH in scores:
        depth = scores[DEPTH]
        claim = "AUC above that of depth with noise: difference"
        claims.append(_gain(3, claim, ours, depth, over, seed))
        gains = [_gain(3, name, one, depth, over, seed).value for name, one in others.items()]
        share = float(np.mean(np.array(gains) > 0)) - 0.5
        claims.append(
            Claim(3, "most others above depth with noise: share − 0.5", share, None, None, over)
        )
        rates = [_true_rate(one) for one in (depth, ours)]
        claim = f"depth finds most at {LOW_RATE:g} false positives: its rate − ours"
        claims.append(Claim(3, claim, rates[0] - rates[1], None, None, over))
    return claims


def claims_of_evolution(
    target: Target, snapshots: Sequence[Snapshot], threshold: float
) -> list[Claim]:
    """Tell whether what was not seen yet is taken for salient in figure 5: above the threshold."""
    if target.late is None:
        return []
    first = target.late.first_look
    before = [shot for shot in snapshots if shot.looks < first and shot.on_late is not None]
    if not before:
        return []
    last = before[-1]
    assert last.on_late is not None
    claim = (
        f"a thing that look {first} shows first is salient after {last.looks} looks: its mean "
        f"score − {threshold:g}"
    )
    return [Claim(5, claim, last.on_late - threshold, None, None, "1 view")]


def claims_of_errors(
    curves: Mapping[str, Sequence[Curve]], offline_error: float, baseline: float | None, seed: int
) -> list[Claim]:
    """Compare the strategies of figure 6; all have the same seeds and looks.

    baseline: overall error of BMS; None = not known.
    """
    errors = {name: np.array([curve.errors for curve in each]) for name, each in curves.items()}
    random, iac, chronological = errors["random"], errors["iac"], errors["chronological"]
    n_beginning = max(1, round(BEGINNING * random.shape[1]))
    over = f"{len(random)} seeds"

    def claim(text: str, per_seed: Floats, statistic: _Statistic = float) -> Claim:
        return _interval(6, text, per_seed, over, seed, statistic)

    ends = np.stack([one[:, -1] for one in errors.values()], axis=1)
    worst_f1 = (1 - ends).min(axis=1) / (1 - offline_error)
    claims = [
        claim(
            "the off-line error is a lower bound: least last error − it",
            _least(ends, offline_error),
        ),
        claim(
            f"all come to {REACHED:g} of the off-line F1: lowest share − {REACHED:g}",
            worst_f1 - REACHED,
        ),
        claim(
            f"chronological is slower over the first {n_beginning} looks: mean error − random's",
            (chronological - random)[:, :n_beginning].mean(axis=1),
        ),
        claim("IAC is faster than random: random's mean error − its", (random - iac).mean(axis=1)),
    ]
    if baseline is not None:
        text = f"below {_BASELINE} at the end: its error − the highest of ours"
        claims.insert(2, claim(text, baseline - ends.max(axis=1)))
    if len(random) >= LEAST_SEEDS:
        moments = np.stack([[one, one**2] for one in (random, iac)]).transpose(2, 0, 1, 3)
        text = "IAC varies less between seeds: 1 − its standard deviation / random's"
        claims.append(claim(text, moments, _less_spread))
    for name in ("random", "iac"):
        claims += _claims_of_enough(name, errors[name], offline_error, over, seed)
    return claims


def _claims_of_enough(
    name: str, errors: Floats, offline_error: float, over: str, seed: int
) -> list[Claim]:
    """Tell whether 1000 looks suffice; nothing where runs are no longer."""
    if errors.shape[1] <= ENOUGH_LOOKS:
        return []
    then, end = errors[:, ENOUGH_LOOKS - 1], errors[:, -1]
    f1 = (1 - then) / (1 - offline_error)
    reached = f"{name}, after {ENOUGH_LOOKS} looks: share of the off-line F1 − {REACHED:g}"
    later = f"{name}, after {ENOUGH_LOOKS} looks: {LITTLE:g} − what the error still falls"
    return [
        _interval(6, reached, f1 - REACHED, over, seed),
        _interval(6, later, LITTLE - (then - end), over, seed),
    ]


def claims_of_time(shares: Mapping[str, Sequence[Floats]], seed: int) -> list[Claim]:
    """Tell whether IAC's time in regions moves more than that of chance in figure 7.

    shares: (n_regions, n_looks) of each seed.
    """
    moves = {
        name: np.array([one.std(axis=1).mean() for one in each]) for name, each in shares.items()
    }
    claim = "IAC's shares of time change more than random's: standard deviation − random's"
    per_seed = moves["iac"] - moves["random"]
    return [_interval(7, claim, per_seed, f"{len(per_seed)} seeds", seed)]


def _least(ends: Floats, offline_error: float) -> Floats:
    """Return the last error of that strategy whose mean is least, less the off-line one."""
    return np.asarray(ends[:, np.argmin(ends.mean(axis=0))] - offline_error)


def _interval(
    figure: int,
    claim: str,
    per_seed: Floats,
    over: str,
    seed: int,
    statistic: _Statistic = float,
) -> Claim:
    interval = bootstrap_interval(per_seed, statistic, np.random.default_rng(seed))
    low, high = (None, None) if interval is None else interval
    value = statistic(per_seed.mean(axis=0))
    return Claim(figure, claim, 0.0 if value is None else value, low, high, over)


def _less_spread(moments: Floats) -> float | None:
    """Return 1 - the ratio of standard deviations, the second to the first.

    moments: (2, 2, n_looks). None where the first does not vary: the same seed, drawn again.
    """
    deviations = np.sqrt(np.maximum(moments[:, 1] - moments[:, 0] ** 2, 0)).mean(axis=1)
    return None if deviations[0] < ALIKE else float(1 - deviations[1] / deviations[0])


def _gain(
    figure: int, claim: str, one: MethodScores, other: MethodScores, over: str, seed: int
) -> Claim:
    value, interval = one.auc_gain(other, seed)
    low, high = (None, None) if interval is None else interval
    return Claim(figure, claim, value, low, high, over)


def _true_rate(one: MethodScores) -> float:
    false_rate, true_rate = one.maps.ranking().roc.T
    return float(np.interp(LOW_RATE, false_rate, true_rate))
