"""Keep what a watch has come to: a state that is replaced now and then, and a journal of the rest.

The journal begins anew with each state, so both have an end. After a kill the looks of the journal
are learned again, by what was drawn of them, and all is as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.camera_start import BEGUN, Begun, FirstFrames
from curiosight.experiments.command_file import COMMAND, GivenWatch
from curiosight.experiments.deciding import DecisionsFile
from curiosight.experiments.handing_on import HandedOn, Rooms
from curiosight.experiments.journal import JOURNAL, REMEDY, Journal, read_journal
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.run_snapshot import run_snapshot
from curiosight.experiments.snapshot import KIND, STATE
from curiosight.experiments.watch_parts import Parts
from curiosight.experiments.watched import LookRecord, Watched
from curiosight.learner.archive import MODEL, read_archive
from curiosight.robot.advice import Advice
from curiosight.robot.watch import Watch
from curiosight.teacher import TemporalTeacher

CONFIG, SUMMARY, LOOKS, DECISIONS = "config.toml", "summary.json", "looks.csv", "decisions.csv"
# What an earlier run may have left that would pass for this one's; by the first it is known.
RESULTS = (COMMAND, CONFIG, MODEL, SUMMARY, LOOKS, DECISIONS, STATE, JOURNAL, BEGUN)
COLUMNS = ("look", "seconds", "id", "region", "error", "samples")
# A journal of more begins anew, whatever it costs.
MAX_JOURNAL_BYTES = 2**27


def check_kept(run: Path) -> None:
    """Raise `DataError` where what is kept of a watch is damaged, before much is done to go on."""
    if (run / STATE).is_file():
        read_archive(run / STATE, KIND)
        read_journal(run / JOURNAL)


class WatchKeeper:
    """The tables, the state and the journal of a watch.

    given: the command that it can be gone on with by; None = only tables are kept.
    so_far: what it has come to. unkept: why the strategy cannot be kept; None = it can.
    n_cut: bytes of the journal's last record that a power cut left half.
    """

    def __init__(
        self,
        out: OutputFolder,
        parts: Parts,
        advice: Advice,
        dataset: Dataset,
        given: GivenWatch | None,
        *,
        is_learning: bool,
    ) -> None:
        self.so_far, self.n_cut = Watched(), 0
        self.unkept: str | None = None
        self._out, self._parts, self._advice, self._given = out, parts, advice, given
        self._is_learning = is_learning
        self._comes_again = not isinstance(dataset, FirstFrames)
        self._dataset = dataset
        self._journal = Journal(out.path / JOURNAL)
        self._snapshot = run_snapshot(
            parts.config, given, dataset.ids, parts.learner, advice.views, parts.views, parts.ways
        )
        self._rooms = Rooms.of(parts.config, dataset, parts.regions)
        if (teacher := self.remembering) is not None:
            teacher.is_noting = given is not None

    def begin(self, *, is_kept: bool) -> None:
        """Open the tables; is_kept: go on with the state and the journal that are there."""
        sizes: list[int | None] = [None, None]
        state: dict[str, Any] = {"decisions": ()}
        if is_kept:
            state = self._snapshot.read(self._out.path / STATE)
            records, self.n_cut = read_journal(self._out.path / JOURNAL)
            self._take_up(state)
            sizes = state["sizes"]
        self._looks = TableFile(self._out.file(LOOKS), COLUMNS, n_kept=sizes[0])
        path, strategy = self._out.file(DECISIONS), self._advice.strategy
        last = state["decisions"]
        self._decisions = DecisionsFile(path, strategy, last=last, n_kept=sizes[1])
        if is_kept:
            try:
                self._do_again(records)
            except BaseException:
                self.close()
                raise

    def note(self, record: LookRecord) -> dict[str, Any]:
        """Keep a look; return its row. Once this returns no kill takes it away."""
        if self._given is not None:
            self._journal.add(record)
        return self._add(record)

    def sync_if_due(self) -> None:
        """See to it that a power cut takes no more than seconds."""
        self._journal.sync_if_due()

    @property
    def is_full(self) -> bool:
        """Tell whether the journal must begin anew."""
        return self._journal.n_bytes > MAX_JOURNAL_BYTES

    def keep(self, watch: Watch) -> None:
        """Replace the state, and begin the journal anew; nothing may learn meanwhile."""
        if self._given is None:
            return
        with watch.teaching, self._advice.telling:
            self.so_far.counts, self.so_far.ages = watch.counts(), watch.ages
            teacher = self.remembering
            memory = None if teacher is None else teacher.memory()
            self._write(
                {
                    "handed_on": HandedOn(self._rooms, self.so_far.looks, memory),
                    "sizes": [self._looks.sync(), self._decisions.sync()],
                    "decisions": list(self._decisions.last),
                    "so_far": self.so_far,
                    "learner": self._parts.learner.learned() if self._is_learning else None,
                    "advice": self._advice.state(),
                }
            )
        self._journal.begin_anew()

    def close(self) -> None:
        """Close the tables; may be called twice."""
        self._looks.close()
        self._decisions.close()

    def finish(self, watch: Watch) -> None:
        """Write the last state of a watch that is over, which needs no journal."""
        self.keep(watch)
        self._journal.close()
        self._out.remove([JOURNAL])

    def _add(self, record: LookRecord) -> dict[str, Any]:
        is_learning, index = self._is_learning, record.index
        self.so_far.add(record, comes_again=self._comes_again, is_learning=is_learning)
        row = {
            "look": record.number,
            "seconds": record.seconds,
            "id": record.trouble.id,
            "region": -1 if index is None else int(self._parts.regions.of_view[index]),
            "error": record.outcome.error,
            "samples": self._parts.learner.n_samples,
        }
        self._looks.add(row)
        self._decisions.add(record.number)
        return row

    def _write(self, state: dict[str, Any]) -> None:
        """Write a state; without the strategy, where one of somebody's own cannot be kept."""
        path = self._out.file(STATE)
        if self.unkept is None:
            try:
                self._snapshot.write(path, state)
                return
            except ValueError as error:
                self.unkept = str(error)
        advice = state["advice"] | {"strategy": None}
        self._snapshot.write(path, state | {"advice": advice, "decisions": []})

    def _take_up(self, state: Mapping[str, Any]) -> None:
        """Put all that looks change where it was when the state was written."""
        self.so_far = state["so_far"]
        if state["learner"] is not None:
            self._parts.learner.take_up(state["learner"])
        memory = state["handed_on"].memory
        if (teacher := self.remembering) is not None and memory is not None:
            teacher.recall(memory)
        advice = dict(state["advice"])
        if advice["strategy"] is None:
            advice["strategy"] = self._advice.strategy
        self._advice.take_up(advice)

    def _do_again(self, records: list[LookRecord]) -> None:
        """Learn what the journal tells that the state does not know."""
        n_taught, teacher = self.so_far.counts.taught, self.remembering
        for record in records:
            if record.number < self.so_far.n_looks:
                continue  # a kill came between the state and its journal
            if record.number > self.so_far.n_looks:
                found = f"lacks look {self.so_far.n_looks}, and goes on with {record.number}"
                raise DataError(self._out.path / JOURNAL, found, REMEDY)
            if record.taught is not None:
                self._parts.learner.learn_again(record.taught)
            if teacher is not None and record.noted is not None and record.verdict > n_taught:
                teacher.remember_again(record.noted)
            outcome, seconds = record.heard(), record.seconds
            self._advice.look_again(record.index, outcome, seconds, record.pinned)
            self._add(record)
        counts = self.so_far.counts
        self.so_far.counts = replace(counts, taught=max(n_taught, counts.taught))

    @property
    def remembering(self) -> TemporalTeacher | None:
        """The teacher, if it has a memory."""
        teacher = self._parts.teacher
        return teacher if isinstance(teacher, TemporalTeacher) else None

    def write_beginning(self) -> None:
        """Write by what the watch can be gone on with, but for its state."""
        if self._given is None:
            return
        if isinstance(self._dataset, FirstFrames):
            parts = self._parts
            begun = Begun(self._dataset.looks, parts.survey, parts.regions)
            begun.write(self._out.file(BEGUN), self._given.version)
        self._given.write(self._out)
