"""Where to look next: regions, learning progress, strategies (sec. II-B)."""

from curiosight.exploration.check import check_strategy
from curiosight.exploration.regions import Regions, make_regions
from curiosight.exploration.strategies import (
    STRATEGIES,
    Chronological,
    Iac,
    Random,
    Strategy,
    make_strategy,
)

__all__ = [
    "STRATEGIES",
    "Chronological",
    "Iac",
    "Random",
    "Regions",
    "Strategy",
    "check_strategy",
    "make_regions",
    "make_strategy",
]
