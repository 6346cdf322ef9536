"""A mean error never stands without the number of frames that it is a mean of."""

from __future__ import annotations

from curiosight.cli.talk import count, format_value


def mean_of(error: float | None, n_scored: int, n_tested: int, noun: str = "frame") -> str:
    """Write a mean error with the number of frames that it is a mean of."""
    if error is None:
        return format_value(error)
    return f"{error:.3f}, mean of {n_scored} of {count(n_tested, noun)}"
