"""Kill commands without warning at random moments, go on with them, and compare every byte.

    python benchmarks/kills.py RECORDING [--kills 200] [--commands explore,learn,compare,watch]
        [--options "--strategy progress-rate"] [--seed 0] [--out kills.json]

Each command is run to its end once. Then it is begun again and again, killed (SIGKILL, with all its
processes) at a random moment after its folder is there, every file that it left is read, and it is
gone on with by --resume; every fourth time that is killed, too. No two watches are alike: of each
look it is noted what the model was just behind it, before it is kept, and compared with the model
that goes on. Prints a table, and keeps it in benchmarks/results/kills.json, from the first kill on.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.experiments.journal import JOURNAL, read_journal
from curiosight.experiments.snapshot import KIND, STATE
from curiosight.learner.archive import MODEL, read_archive
from curiosight.learner.model_file import KIND as MODEL_KIND

RESULTS = Path(__file__).parent / "results" / "kills.json"
# What tells times, or of them, differs between any two runs; state.npz goes with the run.
TIMED = ("timings.csv", "timings.json", "report.html", STATE)
KILLED_AGAIN = 0.25
STEPS = {"explore": 60, "compare": 12}
WATCHED_S = 6
# What a watch notes of its looks, and of the model that it begins with: in the folder beside.
NOTED, BEGUN = "looks.txt", "begun.txt"
# As the first word: run a watch that does so.
WATCHED = "--watched"


@dataclass
class Tally:
    """What became of a command's kills.

    n_ended: had ended before. n_early: nothing was written yet, so that there was nothing to go on
    with. n_again: of those that went on, killed again. n_equal: finished with the same bytes.
    n_redone: looks that were on the disk and were looked at again, of each kill. n_lost: looks that
    a watch had learned from and that were not on the disk.
    """

    command: str
    seconds: float
    n_kills: int = 0
    n_ended: int = 0
    n_early: int = 0
    n_again: int = 0
    n_unreadable: int = 0
    n_other: int = 0
    n_equal: int = 0
    n_redone: list[int] = field(default_factory=list)
    n_lost: list[int] = field(default_factory=list)


class Command:
    """A command that is killed: its words, and how it is gone on with."""

    def __init__(self, name: str, source: str, options: Sequence[str]) -> None:
        self.name, self._source, self._options = name, source, options

    def begin(self, out: Path) -> list[str]:
        """Return the words of a whole run."""
        length = ["--steps", str(STEPS[self.name])] if self.name in STEPS else []
        if self.name == "compare":
            length += ["--strategies", "random,sweep", "--seeds", "2", "--workers", "2"]
        if self.name == "watch":
            length = ["--learn", "--seconds", str(WATCHED_S)]
        own = self._options if self.name == "explore" else ()
        return [self.name, self._source, *length, *own, "--out", str(out), "--quiet"]

    def go_on(self, out: Path) -> list[str]:
        """Return the words that go on with it."""
        where = (
            ["--out", str(out), "--resume"] if self.name == "compare" else ["--resume", str(out)]
        )
        return [self.name, *where, "--quiet"]

    def program(self, out: Path) -> list[str]:
        """Return what runs it, but for its words."""
        if self.name == "watch":
            return [sys.executable, __file__, WATCHED, str(aside_of(out))]
        return [sys.executable, "-m", "curiosight"]

    def is_begun(self, out: Path) -> bool:
        """Tell whether so much is written that it can be gone on with."""
        return (out / ("compare.toml" if self.name == "compare" else "command.json")).is_file()


def aside_of(out: Path) -> Path:
    """Return the folder where a watch into another notes what it learned."""
    return out.with_name(f"{out.name}-noted")


def run(command: Command, words: Sequence[str], out: Path, after_s: float | None = None) -> Any:
    """Run a command; return its exit status, None where it was killed.

    after_s: seconds after its folder was there, which takes until all is opened.
    """
    process = subprocess.Popen(
        [*command.program(out), *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while after_s is not None and process.poll() is None and not out.exists():
        time.sleep(0.002)
    try:
        _, err = process.communicate(timeout=after_s)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None
    if process.returncode not in (0, 1):
        print(f"{shlex.join(words)}: {process.returncode}\n{err}", file=sys.stderr)
    return process.returncode


def contents(out: Path) -> dict[str, bytes]:
    """Return what a run says but for its times, and for which command wrote which file."""
    return {
        path.relative_to(out).as_posix(): path.read_bytes()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.name not in TIMED and "figures" not in path.parts
        if not path.name.startswith(".")
    }


def unreadable(out: Path) -> list[str]:
    """Return the files that are there under their names and cannot be read."""
    bad = []
    for path in out.rglob("*"):
        if path.name.startswith("."):
            continue
        try:
            if path.name in (MODEL, STATE):
                read_archive(path, MODEL_KIND if path.name == MODEL else KIND)
            elif path.name == JOURNAL:
                read_journal(path)
            elif path.suffix in (".npy", ".npz"):
                np.load(path)
            elif path.suffix == ".json":
                json.loads(path.read_text("utf-8"))
            elif path.suffix == ".csv":
                content = path.read_text("utf-8")
                lines = list(csv.reader(content.splitlines()))
                if content and (not content.endswith("\n") or len({*map(len, lines)}) > 1):
                    raise ValueError("a broken line")
        except Exception as error:  # whatever it is, it is counted
            bad.append(f"{path}: {error}")
    return bad


def began_s(out: Path) -> float:
    """Return when the first file of a run was written, seconds since 1970."""
    return min(path.stat().st_mtime for path in out.rglob("*") if path.is_file())


def n_steps(out: Path) -> int:
    path = out / "steps.csv"
    return max(0, path.read_text().count("\n") - 1) if path.is_file() else 0


def n_kept(out: Path) -> int:
    """Return after how many steps the state of an exploration was written."""
    if not (out / STATE).is_file():
        return 0
    header, _ = read_archive(out / STATE, KIND)
    sizes = dict(zip(header["state"][1], header["state"][2], strict=True))["sizes"]
    content = (out / "steps.csv").read_bytes()[: sizes[1][0]]
    return content.count(b"\n") - 1


def kill_often(
    command: Command, n_kills: int, folder: Path, rng: np.random.Generator
) -> Iterator[Tally]:
    """Kill a command so often; yield what has become of it so far after each."""
    whole, out = folder / command.name, folder / f"{command.name}-killed"
    run(command, command.begin(folder / "warm-up"), folder)  # kernels are compiled once
    shutil.rmtree(folder / "warm-up", ignore_errors=True)
    run(command, command.begin(whole), whole)
    tally = Tally(command.name, round(time.time() - began_s(whole), 1))
    wanted = contents(whole)
    for _ in range(n_kills):
        shutil.rmtree(out, ignore_errors=True)
        shutil.rmtree(aside_of(out), ignore_errors=True)
        tally.n_kills += 1
        if run(command, command.begin(out), out, rng.uniform(0, tally.seconds)) is not None:
            tally.n_ended += 1
        _go_on(command, out, tally, rng)
        if command.name != "watch" and command.is_begun(out):
            found = {
                name: one.replace(str(out).encode(), str(whole).encode())
                for name, one in contents(out).items()
            }
            differing = [name for name in {*found, *wanted} if found.get(name) != wanted.get(name)]
            tally.n_equal += not differing
            if differing:
                tally.n_other += 1
                print(f"{command.name}: {differing} are others", file=sys.stderr)
        yield tally


def _go_on(command: Command, out: Path, tally: Tally, rng: np.random.Generator) -> None:
    """Look at what was left, and go on until the end."""
    while True:
        bad = unreadable(out)
        tally.n_unreadable += len(bad)
        print(*bad, sep="\n", end="", file=sys.stderr)
        if not command.is_begun(out):
            tally.n_early += 1
            return
        n_noted = len(_lines(aside_of(out) / NOTED))
        if command.name == "explore":
            tally.n_redone.append(n_steps(out) - n_kept(out))
        is_again = rng.random() < KILLED_AGAIN
        after_s = rng.uniform(0, 2 * tally.seconds) if is_again else None
        (aside_of(out) / BEGUN).unlink(missing_ok=True)  # of the one that was killed
        status = run(command, command.go_on(out), out, after_s)
        if command.name == "watch" and (out / STATE).is_file():
            _compare_watch(out, n_noted, tally)
        if status is not None:
            return
        tally.n_again += 1


def _compare_watch(out: Path, n_noted: int, tally: Tally) -> None:
    """Compare the model that a watch went on with to what it was when it was killed."""
    begun = _lines(aside_of(out) / BEGUN)
    if not begun:
        return  # it was killed again before that, or it had ended by itself
    n_looks, found = begun[-1].split()
    noted = _lines(aside_of(out) / NOTED)
    noted, since = noted[:n_noted], noted[n_noted:]
    tally.n_lost.append(n_noted - int(n_looks))
    known = [line.split() for line in noted][: int(n_looks)]
    is_equal = not known or known[-1] == [str(int(n_looks) - 1), found]
    tally.n_equal += is_equal
    if not is_equal:
        tally.n_other += 1
        print(f"watch: the model after {n_looks} looks is another", file=sys.stderr)
    # What was lost is looked at again under the same numbers.
    lines = [*map(" ".join, known), *since]
    (aside_of(out) / NOTED).write_text("".join(f"{line}\n" for line in lines))


def _lines(path: Path) -> list[str]:
    """Return the whole lines of a file; none where there is none."""
    content = path.read_text() if path.is_file() else ""
    return content[: content.rfind("\n") + 1].splitlines()


def watch_noted(aside: Path, words: Sequence[str]) -> int:
    """Run a watch that notes what its model is, as it begins and just behind each look."""
    from curiosight.cli.app import run as run_command
    from curiosight.experiments.watching import Watching

    aside.mkdir(exist_ok=True)
    note, begin = Watching._note, Watching.run

    def write(name: str, number: int, watching: Watching) -> None:
        with (aside / name).open("a") as file:
            file.write(f"{number} {_digest(watching)}\n")

    def noting(watching: Watching, look: Any) -> None:
        write(NOTED, look.number, watching)
        note(watching, look)

    def beginning(watching: Watching, *arguments: Any) -> Any:
        write(BEGUN, watching.so_far.n_looks, watching)
        return begin(watching, *arguments)

    Watching._note, Watching.run = noting, beginning  # type: ignore[method-assign]
    return run_command(list(words))


def _digest(watching: Any) -> str:
    """Return what stands for all that a learner knows, and for where its chance is."""
    learner, digest = watching.learner, hashlib.sha256()
    arrays = learner.experts.state_arrays()
    if learner.calibration is not None:
        arrays |= learner.calibration.state_arrays()
    for name in sorted(arrays):
        digest.update(name.encode() + np.ascontiguousarray(arrays[name]).tobytes())
    digest.update(json.dumps(learner.rng.bit_generator.state).encode())
    return digest.hexdigest()


def table(tallies: Sequence[Tally]) -> str:
    """Return the table as Markdown."""
    lines = [
        "| command (s) | kills | nothing begun | ended before | killed again | unreadable files "
        "| to the same bytes | otherwise | looks done again: mean, most | lost: mean, most |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in tallies:
        redone, lost = one.n_redone or [0], one.n_lost or [0]
        lines.append(
            f"| {one.command} ({one.seconds}) | {one.n_kills} | {one.n_early} | {one.n_ended} "
            f"| {one.n_again} | {one.n_unreadable} | {one.n_equal} | {one.n_other} "
            f"| {np.mean(redone):.1f}, {max(redone)} | {np.mean(lost):.2f}, {max(lost)} |"
        )
    return "\n".join(lines)


def main() -> None:
    if sys.argv[1:2] == [WATCHED]:
        sys.exit(watch_noted(Path(sys.argv[2]), sys.argv[3:]))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", help="a folder, or a room such as room:7,views=12")
    parser.add_argument("--kills", type=int, default=200, help="of all commands together")
    parser.add_argument("--commands", default="explore,learn,compare,watch")
    parser.add_argument("--options", default="", help="of explore")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    names = arguments.commands.split(",")
    source = arguments.recording
    source = str(Path(source).absolute()) if Path(source).exists() else source
    with tempfile.TemporaryDirectory() as folder:
        tallies: dict[str, Tally] = {}
        for number, name in enumerate(names):
            n_kills = (arguments.kills + number) // len(names)
            command = Command(name, source, shlex.split(arguments.options))
            for tally in kill_often(command, n_kills, Path(folder), rng):
                tallies[name] = tally
                content = [asdict(one) for one in tallies.values()]
                arguments.out.write_text(json.dumps(content, indent=1) + "\n")
    print(table([*tallies.values()]))


if __name__ == "__main__":
    main()
