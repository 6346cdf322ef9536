"""Kernels are compiled where Numba has a place for its cache, and where it has none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import curiosight
from recordings import write_image

# A program of its own, in a folder where `__pycache__` is a file: nobody can write there, not
# even root.
KERNELS = """
import warnings
warnings.formatwarning = lambda message, *_: f"warning: {message}\\n"
from curiosight.errors.compiling import njit

@njit(cache=True, nogil=True)
def twice(x):
    return 2 * x

@njit(cache=True)
def four_times(x):
    return twice(twice(x))

print(four_times(3))
"""
NO_CACHE = "warning: Numba has no place for its cache, so every run compiles anew: "


def run(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    (folder / "kernels.py").write_text(KERNELS)
    return subprocess.run(
        [sys.executable, folder / "kernels.py"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **environment},
    )


@pytest.fixture
def nowhere(tmp_path: Path) -> dict[str, str]:
    """Leave Numba no place for a cache; nor does a second look find one."""
    (tmp_path / "__pycache__").write_text("a file, not a folder")
    (tmp_path / "file").write_text("")
    below = str(tmp_path / "file/below")
    return {"HOME": below, "XDG_CACHE_HOME": below, "NUMBA_CACHE_DIR": below}


def test_without_a_place_for_the_cache_kernels_run_and_one_line_warns(
    tmp_path: Path, nowhere: dict[str, str]
) -> None:
    for _ in range(2):
        done = run(tmp_path, **nowhere)
        assert done.stdout == "12\n"
        assert done.stderr.startswith(NO_CACHE)
        assert done.stderr.count("\n") == 1
        assert "set NUMBA_CACHE_DIR to a folder" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"kernels.py", "__pycache__", "file"}


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"])
def test_any_place_for_the_cache_is_used(
    variable: str, tmp_path: Path, nowhere: dict[str, str]
) -> None:
    if variable == "HOME":
        del nowhere["XDG_CACHE_HOME"]
    nowhere[variable] = str(tmp_path / "place")
    done = run(tmp_path, **nowhere)
    assert (done.stdout, done.stderr) == ("12\n", "")
    assert len(list((tmp_path / "place").rglob("*.nbc"))) == 2


def test_beside_the_source_is_the_usual_place(tmp_path: Path) -> None:
    elsewhere = {"NUMBA_CACHE_DIR": "", "HOME": str(tmp_path / "home")}
    assert run(tmp_path, **elsewhere).stderr == ""
    assert len(list((tmp_path / "__pycache__").glob("*.nbc"))) == 2


def test_command_runs_on_a_package_that_nobody_can_write_to(
    tmp_path: Path, nowhere: dict[str, str]
) -> None:
    """A copy of the package, all of whose folders have a file in the place of a cache."""
    source = Path(curiosight.__file__).parent
    for path in source.rglob("*.py"):
        copy = tmp_path / "curiosight" / path.relative_to(source)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
        (copy.parent / "__pycache__").touch()
    write_image(tmp_path / "photos/one.png", np.zeros((20, 30, 3), np.uint8))
    program = "import curiosight.cli as cli; print(cli.__file__, flush=True); cli.main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "info", tmp_path / "photos"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **nowhere, "PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode == 0
    assert done.stdout.startswith(str(tmp_path / "curiosight/cli"))
    assert done.stderr.startswith(NO_CACHE)
    assert done.stderr.count("\n") == 1
