"""Time this build of the program and another in turns, on the same frames."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curiosight.errors import DataError, printable

FIGURES = ("median_ms", "p90_ms", "processor_median_ms", "processor_p90_ms")
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
# Of a run that Ctrl-C, SIGTERM or SIGHUP ended, as `curiosight` and as the system tell it.
ENDED = frozenset({130, 143, 129, -2, -15, -1})
_TELL = "import curiosight; print(curiosight.__file__); print(curiosight.__version__)"


class StoppedError(Exception):
    """A run was ended from outside; what it measured is not whole."""


@dataclass(frozen=True, slots=True)
class Build:
    """A build of the program, by the Python interpreter that imports it.

    path: PYTHONPATH of its runs; None = without, the environment alone counts.
    """

    python: Path
    path: str | None = None

    @classmethod
    def this(cls) -> Build:
        """Return the build that runs."""
        sources = Path(__file__).parents[2]
        path = os.pathsep.join([str(sources), os.environ.get("PYTHONPATH", "")])
        return cls(Path(sys.executable), path)

    def package(self) -> tuple[Path, str]:
        """Return the folder of the package that is imported, and its version.

        Raises `DataError` where there is no such interpreter, or no curiosight in it.
        """
        if not self.python.is_file():
            found = "is a folder" if self.python.is_dir() else "is no file"
            remedy = "name the interpreter of the other build, such as other/.venv/bin/python"
            raise DataError(self.python, found, remedy)
        done = _run([*_call(self.python), "-c", _TELL], self.path)
        told = done.stdout.splitlines()
        if done.returncode or len(told) != 2:
            found = f"has no curiosight ({_last_line(done.stderr) or 'it said nothing'})"
            raise DataError(self.python, found, "install the other build there")
        return Path(told[0]).parent, told[1]

    def bench(self, arguments: Sequence[str]) -> dict[str, Any]:
        """Return what `curiosight bench` measures.

        Raises `DataError` where it fails, and `ValueError` where it has no such stage.
        """
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "bench.json"
            options = ["--quiet", "--json", str(file)]
            command = [*_call(self.python), "-m", "curiosight", "bench", *options, *arguments]
            done = _run(command, self.path)
            if done.returncode in ENDED:
                raise StoppedError
            if done.returncode == 0 and file.exists():
                figures: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
                return figures
        line = _last_line(done.stderr)
        if done.returncode == 2 and line.startswith("stage: "):
            raise ValueError(line)
        found = f"its bench ended with status {done.returncode} ({line or 'it said nothing'})"
        raise DataError(self.python, found, "mend that, or leave out what it does not know")


class Race:
    """Let two builds time the same stages of the same frames, in rounds of one run each.

    Every run is a process of its own on one thread, which compiles its kernels, or reads them
    from its cache, and warms up before it times. One build is first in every other round, so
    that neither gains by a machine that grows slower or faster.

    arguments: of `curiosight bench`, without --quiet, --json and --against.
    n_rounds: of which the median counts.
    """

    def __init__(self, python: Path, arguments: Sequence[str], *, n_rounds: int = 5) -> None:
        if n_rounds < 1:
            raise ValueError(f"rounds: expected 1 or more, got {n_rounds}")
        self.n_rounds = n_rounds
        self._arguments = list(arguments)
        self.builds = {"this": Build.this(), "other": Build(python)}
        self._package, self._version = self.builds["other"].package()
        self.rounds: list[dict[str, dict[str, Any] | None]] = []

    def __iter__(self) -> Iterator[dict[str, float]]:
        """Run the rounds; yield after each its ratio of processor time for every stage.

        Ends early where a signal from outside ends a run: that round does not count.
        """
        for number in range(self.n_rounds):
            order = ("this", "other") if number % 2 == 0 else ("other", "this")
            try:
                runs = {name: self._run(name) for name in order}
            except StoppedError:
                return
            self.rounds.append(runs)
            yield _ratios(runs, "processor_median_ms")

    def _run(self, name: str) -> dict[str, Any] | None:
        """Return what a build measures; None = the other one does not have the stage."""
        try:
            return self.builds[name].bench(self._arguments)
        except ValueError:
            if name == "this":
                raise
            return None

    def figures(self) -> dict[str, Any]:
        """Return this build's figures, medians over the rounds, and `against`: both builds'."""
        first = self.rounds[0]["this"]
        assert first is not None
        stages = {stage: _stage_figures(stage, self.rounds) for stage in first["stages"]}
        return {
            **first,
            "stages": {stage: figures["this"] for stage, figures in stages.items()},
            "against": {
                "python": str(self.builds["other"].python),
                "package": str(self._package),
                "version": self._version,
                "rounds": len(self.rounds),
                "stages": stages,
            },
        }


def _stage_figures(stage: str, rounds: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return a stage's milliseconds of both builds and their ratios, this one's by the other's.

    Ratios are medians over the rounds of each round's; `processor_ratios` are those.
    """
    found: dict[str, Any] = {}
    for name in ("this", "other"):
        stages = [runs[name]["stages"] for runs in rounds if runs[name] is not None]
        spent = [times[stage] for times in stages if stage in times]
        found[name] = _medians(spent) if spent else None
    for kind, figure in (("processor", "processor_median_ms"), ("wall", "median_ms")):
        each = [_ratios(runs, figure).get(stage) for runs in rounds]
        known = [ratio for ratio in each if ratio is not None]
        found[f"{kind}_ratio"] = round(float(np.median(known)), 3) if known else None
        found[f"{kind}_ratios"] = [round(ratio, 3) for ratio in known]
    return found


def _medians(spent: Sequence[dict[str, float]]) -> dict[str, float]:
    return {
        figure: round(float(np.median([times[figure] for times in spent])), 3) for figure in FIGURES
    }


def _ratios(runs: dict[str, Any], figure: str) -> dict[str, float]:
    """Return this build's figure by the other's, of the stages that both have."""
    if runs["this"] is None or runs["other"] is None:
        return {}
    this, other = runs["this"]["stages"], runs["other"]["stages"]
    return {
        stage: this[stage][figure] / other[stage][figure]
        for stage in this
        if stage in other and other[stage][figure] > 0
    }


def _call(python: Path) -> list[str]:
    # An absolute path, links kept: a link is what makes an environment of an interpreter. The
    # folder that one is in (-P) may hold another curiosight.
    return [str(python.absolute()), "-P"]


def _run(command: list[str], path: str | None) -> subprocess.CompletedProcess[str]:
    """Run a command with one thread; path: PYTHONPATH, None = without it."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    if path is not None:
        environment["PYTHONPATH"] = path
    try:
        return subprocess.run(
            command,
            env={**environment, **ONE_THREAD},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="backslashreplace",
            check=False,
        )
    except OSError as error:
        raise DataError(command[0], f"cannot be run ({error.strerror})", "check it") from error


def _last_line(text: str) -> str:
    """Return the last line of what a process said; "" where it said nothing."""
    lines = text.strip().splitlines()
    return printable(lines[-1].removeprefix("curiosight: ")) if lines else ""
