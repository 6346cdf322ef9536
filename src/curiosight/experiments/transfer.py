"""What is left of places when others have been learned: qualities as a matrix, and their sums."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]


def transfer(qualities: Matrix) -> dict[str, float | None]:
    """Return what a matrix of qualities says of the episodes that are done.

    qualities: (n, n), row i after episode i, column j of the tests of episode j; NaN = not yet.
    average_quality: of all episodes after the last; backward_transfer: by how much what is learned
    later helps (or, below 0, harms) an episode since it was learned (Lopez-Paz and Ranzato, 2017);
    forgetting: by how much less it is known than when it was known best (Chaudhry et al., 2018).
    Means over all episodes but the last; None before two are done.
    """
    done = int(np.isfinite(qualities).any(axis=1).sum())
    known = qualities[:done, :done]
    average = float(known[-1].mean()) if done else None
    if done < 2:
        return {"average_quality": rounded(average), "backward_transfer": None, "forgetting": None}
    return sums_of(known, done - 1)


def sums_of(qualities: Matrix, n_learned: int) -> dict[str, float | None]:
    """Return the same of (n, m) qualities whose last row is of the end.

    n_learned: how many columns have been learned and left since, column i before row i.
    """
    last, first = qualities[-1, :n_learned], np.diag(qualities)[:n_learned]
    best = [float(np.nanmax(qualities[column:, column])) for column in range(n_learned)]
    return {
        "average_quality": rounded(float(qualities[-1].mean())),
        "backward_transfer": rounded(float((last - first).mean())),
        "forgetting": rounded(float((np.array(best) - last).mean())),
    }


def rounded(value: float | None) -> float | None:
    """Return six decimals of a number; None for NaN."""
    return None if value is None or np.isnan(value) else round(value, 6)
