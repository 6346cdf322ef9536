"""Keep why a strategy went where it went: decisions.csv."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from pathlib import Path

from curiosight.experiments.output import TableFile
from curiosight.explorer.decision import Decision, Explains
from curiosight.explorer.strategy import Strategy

COLUMNS = ("step", "region", "expected_gain", "seconds", "score", "chosen", "text")
N_LAST = 8  # decisions that a report tells


class DecisionsFile:
    """One line a candidate of each decision; no file of a strategy that does not explain itself.

    last: the last decisions, and the step that each led to. n_kept: see `TableFile`.
    """

    def __init__(
        self,
        path: Path,
        strategy: Strategy,
        *,
        last: Iterable[tuple[int, Decision]] = (),
        n_kept: int | None = None,
    ) -> None:
        self.last: deque[tuple[int, Decision]] = deque(last, maxlen=N_LAST)
        self._explains = strategy if isinstance(strategy, Explains) else None
        self._file = None
        if self._explains is not None:
            self._file = TableFile(path, COLUMNS, n_kept=n_kept)

    def add(self, step: int) -> None:
        """Write the decision that led to a step, if there was one."""
        decision = None if self._explains is None else self._explains.reasons()
        if decision is None or self._file is None or self._is_known(decision):
            return
        self.last.append((step, decision))
        for one in decision.candidates:
            is_chosen = one.region == decision.chosen
            self._file.add(
                {
                    "step": step,
                    "region": one.region,
                    "expected_gain": _plain(one.expected_gain),
                    "seconds": _plain(one.seconds),
                    "score": _plain(one.score),
                    "chosen": int(is_chosen),
                    "text": decision.text if is_chosen else None,
                }
            )

    def sync(self) -> int:
        """Wait until it is on the disk; return its bytes, 0 where there is no file."""
        return 0 if self._file is None else self._file.sync()

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _is_known(self, decision: Decision) -> bool:
        return bool(self.last) and self.last[-1][1] is decision


def _plain(number: float | None) -> float | None:
    """Return a number as a table has it, without a minus before nothing."""
    return None if number is None else round(float(number), 6) + 0.0
