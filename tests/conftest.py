"""What several tests of the commands read, made once for each of their files."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from curiosight.cli.app import run
from recordings import write_folder
from rooms_once import draw_room_once, lit_once_in

# The tests of the node on a real graph want an environment of their own: `make test-ros`.
collect_ignore = ["ros"]


# These test how rooms are drawn and lit: nothing is kept for them.
OF_ROOMS = ("test_room", "test_home")
DRAWN_BY = ("worlds.sources", "rooms.home.home", "experiments.driving")


@pytest.fixture(scope="session")
def light_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of this run of the tests, the same for all of its workers."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "light"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="module", autouse=True)
def rooms_once(request: pytest.FixtureRequest, light_folder: Path) -> Iterator[None]:
    """Have a room drawn and lit once, whichever test shows it."""
    with pytest.MonkeyPatch.context() as patch:
        if not request.module.__name__.startswith(OF_ROOMS):
            patch.setattr("curiosight.rooms.renderer.lit", lit_once_in(light_folder))
            for module in DRAWN_BY:
                patch.setattr(f"curiosight.{module}.draw_room", draw_room_once)
        yield


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
