"""Build the wheel and the sdist, and try them as who installs them does: `make release`.

The sdist must build the very files of the wheel. The wheel is installed into a fresh environment
with what it needs, which must be small; there, outside the checkout, a script uses the public
names, its types are checked, and a short demo runs.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
OUTSIDE = Path(__file__).parent / "outside.py"
DIST = ROOT / "dist"
MOST_MB = 550
# Not to come in with the base install: they are extras.
EXTRAS = ("scipy", "matplotlib", "pillow", "scikit-learn", "onnxruntime", "ray", "rerun-sdk")
# What an installer puts there besides.
OWN_OF_PIP = ("pip", "setuptools", "pkg_resources", "_distutils_hack", "wheel")


def run(*command: str | Path, cwd: Path = ROOT) -> str:
    """Run a command as a newcomer's shell would, and return what it printed."""
    mine = {"PYTHONPATH", "CURIOSIGHT_TEST_DATA", "VIRTUAL_ENV"}
    surroundings = {name: value for name, value in os.environ.items() if name not in mine}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=surroundings, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as file:
        return {name: file.read(name) for name in file.namelist()}


def build(folder: Path) -> Path:
    """Build both into dist/; return the wheel."""
    shutil.rmtree(DIST, ignore_errors=True)
    run(sys.executable, "-m", "hatchling", "build", "-d", DIST)
    (wheel,), (sdist,) = DIST.glob("*.whl"), DIST.glob("*.tar.gz")
    with tarfile.open(sdist) as file:
        file.extractall(folder, filter="data")
    (unpacked,) = folder.iterdir()
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=unpacked)
    ours, theirs = contents(wheel), contents(folder / wheel.name)
    assert ours == theirs, f"not alike in the sdist: {sorted(ours.keys() ^ theirs.keys())}"
    assert {"curiosight/py.typed", "curiosight_command.py"} <= ours.keys()
    assert not [name for name in ours if name.startswith(("tests", "docs", "benchmarks"))]
    for name in ("README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", "docs/method.md"):
        assert (unpacked / name).is_file(), f"the sdist has no {name}"
    return wheel


def megabytes(packages: Path) -> float:
    """Return what the packages take on the disk, as `du` counts; without what pip is."""
    files = (path for path in packages.rglob("*") if path.is_file() and not path.is_symlink())
    own = [packages / name for name in OWN_OF_PIP]
    kept = (path for path in files if not any(path.is_relative_to(one) for one in own))
    return sum(path.stat().st_blocks * 512 for path in kept) / 2**20


def installed(wheel: Path, environment: Path) -> Path:
    """Install the wheel into a fresh environment; return its folder of commands."""
    run(sys.executable, "-m", "venv", environment)
    commands = environment / "bin"
    quiet = ("--quiet", "--disable-pip-version-check")
    # What pip would compile beforehand Python compiles as it needs it: that is a third of the time.
    compiled = () if "--compiled" in sys.argv else ("--no-compile",)
    run(commands / "pip", "install", *quiet, *compiled, wheel)
    listed = json.loads(run(commands / "pip", "list", "--format", "json", quiet[1]))
    names = {one["name"].lower() for one in listed}
    assert not names & set(EXTRAS), f"in the base install: {sorted(names & set(EXTRAS))}"
    (packages,) = environment.glob("lib/python*/site-packages")
    size = megabytes(packages)
    print(f"the base install takes {size:.0f} MB" + ("" if not compiled else ", not compiled"))
    assert size <= MOST_MB, f"expected at most {MOST_MB} MB"
    return commands


def main() -> None:
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="curiosight-release-") as scratch:
        folder = Path(scratch)
        (folder / "sdist").mkdir()
        wheel = build(folder / "sdist")
        commands = installed(wheel, folder / "environment")
        at_home = folder / "home"
        at_home.mkdir()
        script = shutil.copy(OUTSIDE, at_home)
        strict = ("--strict", "--config-file", os.devnull, "--cache-dir", folder / "types")
        python = commands / "python"
        types = (*strict, "--python-executable", python, script)
        print(run(sys.executable, "-m", "mypy", *types, cwd=at_home).strip())
        print(run(commands / "curiosight", "--version", cwd=at_home).strip())
        demo = ("demo", "--steps", "12", "--quiet", "--json", "--out", "demo")
        facts = json.loads(run(commands / "curiosight", *demo, cwd=at_home))
        assert facts["explored"]["steps"] == 12, facts
        assert (at_home / "demo/report.html").stat().st_size > 100_000
        print(run(python, script, "room:7,views=12", cwd=at_home).strip())
    print(f"released to {DIST} after {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    main()
