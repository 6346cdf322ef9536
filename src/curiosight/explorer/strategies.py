"""Strategies by their names."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence

import numpy as np

from curiosight.explorer.coverage import Coverage
from curiosight.explorer.ground import Ways
from curiosight.explorer.iac import Direction, Iac, progress_motivation
from curiosight.explorer.motivations import (
    Error,
    Forgetting,
    Motivation,
    Novelty,
    Progress,
    ProgressAndForgetting,
    Uncertainty,
)
from curiosight.explorer.oracle import Oracle, Trial
from curiosight.explorer.own import is_own, load_own
from curiosight.explorer.progress import Negative, ProgressMeter, Undefined
from curiosight.explorer.progress_rate import ProgressRate
from curiosight.explorer.rl_iac import Planned
from curiosight.explorer.sampled_q import SampledQ
from curiosight.explorer.stays import Drawn, Stays
from curiosight.explorer.strategy import Strategy
from curiosight.explorer.sweep import Sweep
from curiosight.explorer.unlearned import Chronological, Over, Random
from curiosight.frame import Viewpoint

__all__ = [
    "ORACLE",
    "STRATEGIES",
    "Chronological",
    "Iac",
    "Over",
    "Random",
    "Strategy",
    "check_loadable",
    "check_name",
    "make_strategy",
]

STRATEGIES = (
    "chronological",
    "random",
    "random-region",
    "sweep",
    "coverage",
    "iac",
    "rl-iac",
    "error",
    "novelty",
    "uncertainty",
    "forgetting",
    "progress-forgetting",
    "progress-rate",
)
# Needs the true error, which only a comparison of strategies has.
ORACLE = "oracle"


def check_name(name: str) -> None:
    """Raise ValueError unless a strategy can be called so; a class is not looked for.

    Names are those of `STRATEGIES` and `ORACLE`, sweep:N, sweep:all, rl-iac:sampled, and
    package.module:Class of one's own.
    """
    base, _, option = name.partition(":")
    if base == "sweep":
        _read_stay(option)
    elif base == "rl-iac" and option not in ("", "sampled"):
        raise ValueError(f"strategy: expected rl-iac or rl-iac:sampled, got {name!r}")
    elif base != "rl-iac" and name not in (*STRATEGIES, ORACLE) and not is_own(name):
        nearest = difflib.get_close_matches(name.lower(), (*STRATEGIES, ORACLE), n=1, cutoff=0.4)
        hint = f"; did you mean {nearest[0]}?" if nearest else ""
        raise ValueError(
            f"strategy: expected {', '.join(STRATEGIES)}, {ORACLE} or package.module:Class, "
            f"got {name!r}{hint}"
        )


def check_loadable(name: str) -> None:
    """Raise ValueError unless a strategy of that name can be made without the true error."""
    check_name(name)
    if name == ORACLE:
        raise _needs_truth()
    if is_own(name):
        load_own(name)


def make_strategy(
    name: str,
    views: Sequence[Viewpoint],
    rng: np.random.Generator,
    *,
    ways: Ways | None = None,
    trial: Trial | None = None,
    random_over: Over = "views",
    random_n_stay: int = 1,
    n_stay: int = 10,
    n_warm_up: int = 2,
    random_share: float = 0.25,
    progress: Direction = "forward",
    theta: int = 15,
    smoothing: int = 1,
    min_errors: int = 2,
    undefined: Undefined = "repeat",
    negative: Negative = "clip",
    exponent: float = 1.0,
) -> Strategy:
    """Make the strategy of that name, see `check_name`.

    ways: the seconds from view to view; None = as if they took none. trial: see `Oracle`.
    random_over, random_n_stay: see `Random`; all that follow: see `Iac`. They hold for the
    others that stay in regions, too; but how often `rl-iac` goes anywhere at random is its own.

    Raises ValueError for an unknown name, and for views that the strategy cannot choose from.
    """
    check_name(name)
    base, _, option = name.partition(":")

    def new_meter() -> ProgressMeter:
        return ProgressMeter(
            theta=theta, smoothing=smoothing, min_errors=min_errors, undefined=undefined
        )

    def measured_progress() -> Motivation:
        return progress_motivation(progress, new_meter(), rng, theta=theta)

    def stays(motivation: Motivation) -> Stays:
        chosen = Drawn(rng, random_share=random_share, exponent=exponent, negative=negative)
        return Stays(
            views, rng, motivation, chosen,
            ways=ways, n_stay=n_stay, n_warm_up=n_warm_up, progress=Progress(new_meter()),
        )  # fmt: skip

    def rl_iac() -> Stays:
        motivation = measured_progress()
        # The authors' robot looks once wherever it comes to.
        n_looks = 1 if option == "sampled" else n_stay
        chosen = SampledQ(rng) if option == "sampled" else Planned(rng, n_stay=n_stay)
        return Stays(
            views, rng, motivation, chosen,
            ways=ways, n_stay=n_looks, n_warm_up=n_warm_up,
            inside="nearest", progress=motivation,
        )  # fmt: skip

    def iac() -> Iac:
        return Iac(
            views, rng, ways=ways, n_stay=n_stay, n_warm_up=n_warm_up,
            random_share=random_share, progress=progress, theta=theta, smoothing=smoothing,
            min_errors=min_errors, undefined=undefined, negative=negative, exponent=exponent,
        )  # fmt: skip

    makers: dict[str, Callable[[], Strategy]] = {
        "chronological": lambda: Chronological(views),
        "random": lambda: Random(views, rng, over=random_over, n_stay=random_n_stay),
        "random-region": lambda: Random(views, rng, over="regions", n_stay=random_n_stay),
        "sweep": lambda: Sweep(views, rng, ways=ways, n_stay=_read_stay(option)),
        "coverage": lambda: Coverage(views, rng, ways=ways),
        "iac": iac,
        "rl-iac": rl_iac,
        "error": lambda: stays(Error()),
        "novelty": lambda: stays(Novelty({view.region for view in views})),
        "uncertainty": lambda: stays(Uncertainty()),
        "forgetting": lambda: stays(Forgetting()),
        "progress-forgetting": lambda: stays(
            ProgressAndForgetting(measured_progress(), theta=theta)
        ),
        "progress-rate": lambda: ProgressRate(views, rng, ways=ways),
        ORACLE: lambda: _oracle(views, rng, ways, trial, n_stay),
    }
    if base in makers:
        return makers[base]()
    return load_own(name)(views, rng, ways=ways)


def _oracle(
    views: Sequence[Viewpoint],
    rng: np.random.Generator,
    ways: Ways | None,
    trial: Trial | None,
    n_stay: int,
) -> Oracle:
    if trial is None:
        raise _needs_truth()
    return Oracle(views, rng, trial=trial, ways=ways, n_stay=n_stay)


def _needs_truth() -> ValueError:
    return ValueError(
        "strategy: expected one that needs no true error, got oracle, which only comparisons of "
        "strategies can try"
    )


def _read_stay(text: str) -> int | None:
    """Read how long a sweep stays: "" = 10 looks, "all" = as many as a region has views."""
    if text in ("", "all"):
        return 10 if not text else None
    if not text.isdecimal() or int(text) < 1:
        raise ValueError(f"strategy: expected sweep, sweep:N or sweep:all, got {text!r} for N")
    return int(text)
