"""A mean error never stands without the number of frames that it is a mean of."""

from __future__ import annotations

from curiosight.cli.talk import count, format_value


def mean_of(
    error: float | None, pooled: float | None, n_scored: int, n_tested: int, noun: str = "frame"
) -> str:
    """Write a mean error with the number of frames it is a mean of, and the error of all pooled.

    n_scored: of `n_tested` frames, those that show something salient: the others have no F1.
    """
    if error is None:
        return format_value(error)
    frames = f"mean of {n_scored} of {count(n_tested, noun)}"
    return f"{error:.3f}, {frames}, pooled {format_value(pooled)}"
