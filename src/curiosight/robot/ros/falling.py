"""Tell when the error has stopped falling."""

from __future__ import annotations


class Falling:
    """Watch the mean error of the regions that were looked at.

    It has stopped falling when for `patience` looks it has not come down by `min_fall` below its
    lowest. A region that is looked at for the first time begins that anew.
    """

    def __init__(self, patience: int = 60, min_fall: float = 0.01) -> None:
        if patience < 1:
            raise ValueError(f"patience: expected 1 or more, got {patience}")
        if not min_fall >= 0:
            raise ValueError(f"min_fall: expected 0 or more, got {min_fall}")
        self._patience, self._min_fall = patience, min_fall
        self._lowest: float | None = None
        self._regions: set[int] = set()
        self.n_since = 0

    def note(self, region: int, mean_error: float | None) -> None:
        """Note a look. mean_error: of all regions, after it; None = none is known."""
        is_new = region not in self._regions
        self._regions.add(region)
        if is_new or (
            mean_error is not None
            and (self._lowest is None or mean_error < self._lowest - self._min_fall)
        ):
            self._lowest, self.n_since = mean_error, 0
        else:
            self.n_since += 1

    @property
    def has_stopped(self) -> bool:
        return self.n_since >= self._patience
