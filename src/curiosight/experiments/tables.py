"""The tables of an exploration: steps.csv, decisions.csv, timings.csv, in step with each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from curiosight.experiments.deciding import DecisionsFile
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.steps import STEP_COLUMNS, STEPS, TIMES, StepRow
from curiosight.explorer.decision import Decision
from curiosight.explorer.strategy import Strategy

DECISIONS = "decisions.csv"


class Tables:
    """Write a line, or some, a step.

    stages: that times are told of.
    n_kept: bytes of each file to go on behind, as `sync` told; None = begin all anew.
    last: the last decisions before.
    """

    def __init__(
        self,
        out: OutputFolder,
        strategy: Strategy,
        stages: Sequence[str],
        *,
        n_kept: Sequence[int] | None = None,
        last: Sequence[tuple[int, Decision]] = (),
    ) -> None:
        n_steps, n_times, n_decisions = n_kept or (None, None, None)
        self._steps = TableFile(out.file(STEPS), STEP_COLUMNS, n_kept=n_steps)
        self._times = TableFile(out.file(TIMES), ["step", *stages], n_kept=n_times)
        path = out.file(DECISIONS)
        self._decisions = DecisionsFile(path, strategy, last=last, n_kept=n_decisions)

    @property
    def last_decisions(self) -> Sequence[tuple[int, Decision]]:
        """The last decisions, each with the step that it led to."""
        return self._decisions.last

    @property
    def is_other_than_before(self) -> bool:
        """Tell whether steps that were done again came out otherwise than they stood there."""
        return self._steps.is_other

    def add(self, row: StepRow, lap: Mapping[str, float]) -> None:
        """Write a step, why it was chosen, and its milliseconds per stage."""
        self._steps.add(asdict(row))
        self._decisions.add(row.step)
        self._times.add({"step": row.step, **lap})

    def sync(self) -> list[int]:
        """Wait until all is on the disk; return how many bytes of each file there are."""
        return [table.sync() for table in (self._steps, self._times, self._decisions)]

    def close(self) -> None:
        """Close the files; may be called twice."""
        for table in (self._steps, self._times, self._decisions):
            table.close()
