"""What several tests of the commands read, made once for each of their files."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from curiosight.cli.app import run
from recordings import write_folder

# The tests of the node on a real graph want an environment of their own: `make test-ros`.
collect_ignore = ["ros"]


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain folder of eight frames with poses and ground truth; not to be changed."""
    path = tmp_path_factory.mktemp("recordings") / "room"
    write_folder(path, 8)
    return path


@pytest.fixture(scope="module")
def model(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that learned the room."""
    path = tmp_path_factory.mktemp("runs") / "learn"
    assert run(["learn", str(room), "--out", str(path), "--quiet"]) == 0
    return path


@pytest.fixture
def ctrl_c_as_usual() -> None:
    """Have Ctrl-C interrupt, even where the tests run in the background of a shell."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
