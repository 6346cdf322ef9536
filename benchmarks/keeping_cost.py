"""What it costs a look that nothing is lost: runs with and without what is kept, side by side.

    python benchmarks/keeping_cost.py RECORDING [--looks 300] [--rounds 5]
        [--commands explore,learn,watch] [--strategy progress-rate] [--out keeping_cost.json]

Of each command two runs with the same seed are made in one process, look by look in turn, the one
with state, model and journal, written as often as the command does, the other without. Time is that
of the CPU for the thread that looks, so that neither who else uses the machine nor the decoding of
frames counts. Of a watch it is the core of its loop that runs, without maps: what its teacher says,
learning, advice, the tables, what is kept. A round is both runs from their beginning; tells the
median over the rounds. Kept in benchmarks/results/keeping_cost.json.
"""

from __future__ import annotations

import argparse
import itertools
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from curiosight import __version__
from curiosight.cli.learn import FIT_S, FIT_SHARE
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
from curiosight.learner.archive import MODEL
from curiosight.robot.feed import Shot
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "keeping_cost.json"
# Looks at the beginning that do not count: kernels are compiled, or read.
N_WARM_UP = 5
ADD = Journal.add


class Side:
    """One of two runs: what a look of it takes.

    keeps: whether it keeps what it knows. spent: seconds of the CPU of each look so far.
    """

    def __init__(self, folder: Path, source: Path, *, keeps: bool) -> None:
        self.keeps, self.spent = keeps, list[float]()
        self.out = OutputFolder(folder, "benchmark", source)
        self._total, self._since = 0.0, time.thread_time()

    def clock(self) -> float:
        """Return the seconds that this run has taken, and not the other."""
        return self._total + time.thread_time() - self._since

    def keeping(self, **options: Any) -> Keeping:
        """Return when to write, by this run's clock; never where nothing is kept."""
        if not self.keeps:
            return Keeping(every_looks=10**9, every_s=1e12)
        return Keeping(clock=self.clock, **options)

    @contextmanager
    def pause(self) -> Iterator[None]:
        """Take no time."""
        begun = time.thread_time()
        yield
        self._since += time.thread_time() - begun

    def look(self, looks: Iterator[object]) -> None:
        """Take the next look; StopIteration at the end of a recording that is learned."""
        self._since = time.thread_time()
        next(looks)
        taken = time.thread_time() - self._since
        self._total += taken
        self.spent.append(taken)


def explore(side: Side, config: Config, dataset: Dataset, source: str) -> Iterator[object]:
    """Explore as the command does."""
    given = GivenCommand("explore", __version__, source) if side.keeps else None
    return iter(Exploration(config, dataset, side.out, given=given, keeping=side.keeping()))


def learn(side: Side, config: Config, dataset: Dataset, source: str) -> Iterator[object]:
    """Learn as the command does."""
    off_line = OffLine(config, dataset, version=__version__)
    keeping = side.keeping(expected_s=FIT_S, max_share=FIT_SHARE)
    for frame in off_line:
        if keeping.is_due():
            with keeping.writing():
                off_line.keep(side.out.file(STATE))
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
        watching.watch._to_teach.put(Shot(frame, number % len(dataset), float(number)))
        watching.watch._teach_next()
        watching.watch._learn_next()
        watching.keeper.sync_if_due()
        yield frame


COMMANDS: dict[str, Callable[[Side, Config, Dataset, str], Iterator[object]]] = {
    "explore": explore,
    "learn": learn,
    "watch": watch,
}


def run_round(
    name: str, config: Config, source: str, n_looks: int, folder: Path
) -> tuple[float, float]:
    """Return the milliseconds of a look with and without what is kept.

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
    spent = [1e3 * float(np.mean(side.spent[N_WARM_UP:])) for side in sides]
    return spent[0], spent[1]


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
        "| command | a look without (ms of CPU) | with | more, median | each round |",
        "|---|---|---|---|---|",
    ]
    for one in results:
        each = ", ".join(f"{100 * share:+.1f}" for share in one["shares"])
        lines.append(
            f"| `{one['command']}` | {one['without_ms']:.1f} | {one['with_ms']:.1f} "
            f"| {100 * one['share']:+.1f} % | {each} |"
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
        rounds, kept = [], list[int]()
        Journal.add = journal_bytes(kept)  # type: ignore[method-assign, assignment]
        for number in range(arguments.rounds):
            with tempfile.TemporaryDirectory() as folder:
                spent = run_round(name, config, arguments.recording, n_looks, Path(folder))
                rounds.append(spent)
            shares = [kept_ms / free_ms - 1 for kept_ms, free_ms in rounds]
            print(f"{name} {number + 1}: {100 * shares[-1]:+.2f} %", flush=True)
        with_ms, without_ms = np.median(rounds, axis=0)
        results.append(
            {
                "command": name,
                "looks": n_looks,
                "with_ms": with_ms,
                "without_ms": without_ms,
                "share": float(np.median(shares)),
                "shares": shares,
                "journal_bytes_a_look": float(np.mean(kept)) if kept else None,
            }
        )
        arguments.out.write_text(json.dumps(results, indent=1) + "\n")
    print(table(results))


if __name__ == "__main__":
    main()
