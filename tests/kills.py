"""Kill a command without warning at chosen moments, in processes that are quick to start.

Run as a program: its one process imports everything once, and forks for each kill before it has
begun any thread. Lines on standard input are JSON: the command's words and where it dies; one line
on standard output answers each: whether it was killed, or its exit status.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any


class Killer:
    """Have commands killed after so many seconds, or at their n-th change of a file."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def kill(
        self,
        *words: str | Path | int,
        after_s: float | None = None,
        at: int | None = None,
        aside: Path | None = None,
    ) -> bool:
        """Run a command that dies there; tell whether it did, or had ended before.

        aside: a folder where a watch puts what it has learned, at each look just before it is kept;
        its state is then written at every fifth look, else at each.
        """
        asked: dict[str, Any] = {"words": [str(word) for word in words], "after_s": after_s}
        asked |= {"at": at, "aside": None if aside is None else str(aside)}
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        stdin.write(json.dumps(asked) + "\n")
        stdin.flush()
        return bool(json.loads(stdout.readline())["is_killed"])


@contextmanager
def killer() -> Iterator[Killer]:
    process = subprocess.Popen(
        [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        yield Killer(process)
    finally:
        process.communicate(timeout=60)


def _serve(lines: IO[str]) -> None:
    from curiosight.cli.app import run
    from curiosight.cli.commands import load_command

    load_command("explore")
    load_command("learn")
    load_command("watch")
    import curiosight.cli.watch_run  # noqa: F401 - imported only as it is begun

    for line in lines:
        asked = json.loads(line)
        child = os.fork()
        if child == 0:
            _do(run, asked)
        _, status = os.waitpid(child, 0)
        print(json.dumps({"is_killed": os.WIFSIGNALED(status)}), flush=True)


def _do(run: Callable[[list[str]], int], asked: dict[str, Any]) -> None:
    """Run the command in this process, and die on the way or exit."""
    from curiosight.experiments.keeping import Keeping

    Keeping.is_due = lambda _: True  # type: ignore[method-assign]
    if asked["aside"] is not None:
        n_looks = Counter[int]()

        def is_due(keeping: Keeping) -> bool:
            n_looks[id(keeping)] += 1
            return n_looks[id(keeping)] % 5 == 0

        Keeping.is_due = is_due  # type: ignore[method-assign]
        _put_aside(Path(asked["aside"]))
    if asked["at"] is not None:
        _die_at(asked["at"])
    if asked["after_s"] is not None:
        threading.Thread(target=_die_after, args=(asked["after_s"],), daemon=True).start()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os._exit(run(asked["words"]))


def _put_aside(folder: Path) -> None:
    """Have a watch put aside what it knows after each look, and what chance is then."""
    from curiosight.experiments.watching import Watching

    note = Watching._note

    def noting(watching: Watching, look: Any) -> None:
        learner = watching.learner
        state = json.dumps(learner.rng.bit_generator.state)
        (folder / f"{look.number}.json").write_text(state)
        learner.save(folder / f"{look.number}.npz", is_packed=False)
        note(watching, look)

    Watching._note = noting  # type: ignore[method-assign]


def _die_after(seconds: float) -> None:
    time.sleep(seconds)
    os.kill(os.getpid(), signal.SIGKILL)


def _die_at(turn: int) -> None:
    """Die at the n-th change of a file of the run: before, or where it is odd after it."""
    turns = iter(range(1, 1_000_000))

    def dying(original: Callable[..., Any]) -> Callable[..., Any]:
        def called(what: Any, *arguments: Any, **options: Any) -> Any:
            # Numba's cache is no file of the run.
            if "__pycache__" in str(what) or "numba" in str(what) or next(turns) != turn:
                return original(what, *arguments, **options)
            if turn % 2:
                with suppress(OSError):
                    original(what, *arguments, **options)
            os.kill(os.getpid(), signal.SIGKILL)

        return called

    for name in ("replace", "fsync", "unlink"):
        setattr(os, name, dying(getattr(os, name)))


if __name__ == "__main__":
    _serve(sys.stdin)
