"""What it costs a look that nothing is lost: runs with and without what is kept, side by side.

    python benchmarks/keeping_cost.py RECORDING [--looks 300] [--rounds 5]
        [--commands explore,learn,watch] [--strategy progress-rate] [--out keeping_cost.json]

Of each command two runs with the same seed are made in one process, look by look in turn, the one
with state, model and journal, written as often as the command does, the other without. Time is that
of the CPU for the thread that looks, so that neither who else uses the machine nor the decoding of
frames counts. Of a watch it is the core of its loop that runs, without maps: what its teacher says,
learning, advice, the tables, what is kept. What is kept at each look is the median of what it took
more than the same look of the other run, for a mean would tell of who else uses the caches; state
and model are timed where they are written, and count by the number of looks. A round is both runs
from their beginning; tells the median over the rounds. Kept in
benchmarks/results/keeping_cost.json.
"""

from __future__ import annotations

import argparse
import itertools
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from curiosight import __version__
from curiosight.cli.learn import FIT_S, FIT_SHARE, STATE_S, STATE_SHARE
from curiosight.config import Config, load_config
from curiosight.datasets import Dataset
from curiosight.experiments.command_file import GivenCommand, GivenWatch
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.journal import Journal
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.learning import OffLine
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.snapshot import STATE
from curiosight.experiments.watch_parts import Asked
from curiosight.experiments.watching import SHARE, Watching
from curiosight.frame import Frame
from curiosight.learner.archive import MODEL
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "keeping_cost.json"
# Looks at the beginning that do not count: kernels are compiled, or read.
N_WARM_UP = 5
ADD = Journal.add
KEYS = ("without_ms", "each_ms", "writing_ms")


@dataclass(frozen=True)
class Given:
    """A frame as a feed gives it."""

    frame: Frame
    index: int
    taken_at: float


class Side:
    """One of two runs: what a look of it takes.

    keeps: whether it keeps what it knows. spent: seconds of the CPU of each look so far, and
    written: of these, for state and model.
    """

    def __init__(self, folder: Path, source: Path, *, keeps: bool) -> None:
        self.keeps, self.spent, self.written = keeps, list[float](), list[float]()
        self.out = OutputFolder(folder, "benchmark", source)
        self._total, self._writing, self._since = 0.0, 0.0, time.thread_time()

    def clock(self) -> float:
        """Return the seconds that this run has taken, and not the other."""
        return self._total + time.thread_time() - self._since

    def keeping(self, **options: Any) -> Keeping:
        """Return when to write, by this run's clock; never where nothing is kept."""
        if not self.keeps:
            return Keeping(every_looks=10**9, every_s=1e12)
        keeping = Keeping(clock=self.clock, **options)
        writing = keeping.writing

        @contextmanager
        def timed() -> Iterator[None]:
            begun = time.thread_time()
            with writing():
                yield
            self._writing += time.thread_time() - begun

        keeping.writing = timed  # type: ignore[method-assign]
        return keeping

    @contextmanager
    def pause(self) -> Iterator[None]:
        """Take no time."""
        begun = time.thread_time()
        yield
        self._since += time.thread_time() - begun

    def look(self, looks: Iterator[object]) -> None:
        """Take the next look; StopIteration at the end of a recording that is learned."""
        self._since, self._writing = time.thread_time(), 0.0
        next(looks)
        taken = time.thread_time() - self._since
        self.written.append(self._writing)
        self._total += taken
        self.spent.append(taken)


def explore(side: Side, config: Config, dataset: Dataset, source: str) -> Iterator[object]:
    """Explore as the command does."""
    given = GivenCommand("explore", __version__, source) if side.keeps else None
    return iter(Exploration(config, dataset, side.out, given=given, keeping=side.keeping()))


def learn(side: Side, config: Config, dataset: Dataset, source: str) -> Iterator[object]:
    """Learn as the command does."""
    off_line = OffLine(config, dataset, version=__version__)
    keeping = side.keeping(expected_s=STATE_S, max_share=STATE_SHARE)
    saving = side.keeping(expected_s=FIT_S, max_share=FIT_SHARE)
    for frame in off_line:
        if keeping.is_due():
            with keeping.writing():
                off_line.keep(side.out.file(STATE))
        if saving.is_due():
            with saving.writing():
                off_line.so_far().save(side.out.file(MODEL), is_packed=False)
        yield frame


def watch(side: Side, config: Config, dataset: Dataset, source: str) -> Iterator[object]:
    """Teach, learn and keep as the threads of a watch do, one after the other."""
    given = GivenWatch("watch", __version__, source, learn=True) if side.keeps else None
    watching = Watching(config, dataset, side.out, Asked(is_learning=True), given=given)
    watching._keeping = side.keeping(max_share=SHARE)
    watching._saving = side.keeping(max_share=SHARE)
    for number in itertools.count():
        with side.pause():  # a camera reads by itself
            frame = dataset[number % len(dataset)]
        shot = Given(frame, number % len(dataset), float(number))
        watching.watch._to_teach.put(shot)  # type: ignore[arg-type]
        watching.watch._teach_next()
        watching.watch._learn_next()
        watching.keeper.sync_if_due()
        yield frame


COMMANDS: dict[str, Callable[[Side, Config, Dataset, str], Iterator[object]]] = {
    "explore": explore,
    "learn": learn,
    "watch": watch,
}


@dataclass(frozen=True)
class Round:
    """Milliseconds of the CPU: of a look without, and by how much more it was with what is kept.

    mean: of all. each: median over the looks of what a look took more than the same look without,
    state and model left out. writing: these, by the number of looks.
    """

    without_ms: float
    mean_ms: float
    each_ms: float
    writing_ms: float

    @classmethod
    def of(cls, kept: Side, free: Side) -> Self:
        """Return what two runs took, without their first looks."""
        n = min(len(kept.spent), len(free.spent))
        spent, written, less = (
            1e3 * np.array(one[N_WARM_UP:n]) for one in (kept.spent, kept.written, free.spent)
        )
        more = spent - less
        each = float(np.median(more - written))
        return cls(float(less.mean()), float(more.mean()), each, float(written.mean()))

    @property
    def share(self) -> float:
        """Return what is kept costs, by what a look takes without."""
        return (self.each_ms + self.writing_ms) / self.without_ms


def run_round(name: str, config: Config, source: str, n_looks: int, folder: Path) -> Round:
    """Make both runs.

    Each is the first at every other look: the second finds the frame in the CPU's cache.
    """
    names = ("with", "without")
    sides = [Side(folder / side, Path(source), keeps=side == "with") for side in names]
    runs = []
    for side in sides:
        dataset = open_source(source, reading=config.reading)
        runs.append((side, COMMANDS[name](side, config, dataset, source)))
    with suppress(StopIteration):
        for number in range(N_WARM_UP + n_looks):
            for side, looks in runs if number % 2 else reversed(runs):
                side.look(looks)
    return Round.of(*sides)


def journal_bytes(kept: list[int]) -> Callable[[Journal, object], None]:
    """Return what to add records to a journal by, so that the bytes of each are noted."""

    def noting(journal: Journal, record: object) -> None:
        before = journal.n_bytes
        ADD(journal, record)
        kept.append(journal.n_bytes - before)

    return noting


def table(results: Sequence[dict[str, Any]]) -> str:
    """Return the table as Markdown."""
    lines = [
        "| command | a look without (ms of CPU) | more at each look | state and model "
        "| together, median | each round | means of all looks |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in results:
        shares, means = (
            ", ".join(f"{100 * share:.1f}" for share in one[name]) for name in ("shares", "means")
        )
        lines.append(
            f"| `{one['command']}` | {one['without_ms']:.1f} | {one['each_ms']:.2f} "
            f"| {one['writing_ms']:.2f} | {100 * one['share']:.1f} % | {shares} | {means} |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", help="a folder, or a room such as room:7,views=12")
    parser.add_argument("--looks", type=int, default=300, help="of a run, at most")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--commands", default="explore,learn,watch")
    parser.add_argument("--strategy", default="progress-rate")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    n_looks = arguments.looks
    length = {"explorer.n_steps": N_WARM_UP + n_looks, "explorer.strategy": arguments.strategy}
    config = load_config(None, None, length)
    results: list[dict[str, Any]] = []
    for name in arguments.commands.split(","):
        rounds, kept = list[Round](), list[int]()
        Journal.add = journal_bytes(kept)  # type: ignore[method-assign, assignment]
        for number in range(arguments.rounds):
            with tempfile.TemporaryDirectory() as folder:
                rounds.append(run_round(name, config, arguments.recording, n_looks, Path(folder)))
            print(f"{name} {number + 1}: {rounds[-1]}", flush=True)
        shares = [one.share for one in rounds]
        results.append(
            {
                "command": name,
                "looks": n_looks,
                **{key: float(np.median([asdict(one)[key] for one in rounds])) for key in KEYS},
                "share": float(np.median(shares)),
                "shares": shares,
                "means": [one.mean_ms / one.without_ms for one in rounds],
                "journal_bytes_a_look": float(np.mean(kept)) if kept else None,
            }
        )
        arguments.out.write_text(json.dumps(results, indent=1) + "\n")
    print(table(results))


if __name__ == "__main__":
    main()
