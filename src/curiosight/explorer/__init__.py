"""Where to look next: regions, learning progress, strategies (sec. II-B)."""

from curiosight.explorer.check import check_strategy
from curiosight.explorer.decision import Candidate, Decision, Explains
from curiosight.explorer.regions import Regions, make_regions
from curiosight.explorer.strategies import (
    STRATEGIES,
    Chronological,
    Iac,
    Random,
    Strategy,
    make_strategy,
)

__all__ = [
    "STRATEGIES",
    "Candidate",
    "Chronological",
    "Decision",
    "Explains",
    "Iac",
    "Random",
    "Regions",
    "Strategy",
    "check_strategy",
    "make_regions",
    "make_strategy",
]
