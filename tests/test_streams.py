"""Closed, full and deserted streams: a run goes on to its end, and its status is honest."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from command import files
from curiosight.cli.streams import Output
from recordings import write_image

PROGRAM = "from curiosight_command import main; main()"
NEEDS_FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")


def shell(redirected: str, *arguments: str | Path, **environment: str) -> tuple[int, str, str]:
    """Run `curiosight ARGUMENTS REDIRECTED` in a shell; return status and what was said."""
    done = subprocess.run(
        ["sh", "-c", f'"$@" {redirected}', "sh", sys.executable, "-c", PROGRAM, *arguments],
        capture_output=True,
        text=True,
        encoding="latin-1" if "latin-1" in str(environment) else None,
        check=False,
        env={**os.environ, **environment},
    )
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    ("redirected", "status", "said"),
    [
        (">&-", 1, "curiosight: standard output cannot be written (closed)"),
        pytest.param("> /dev/full", 1, "(No space left on device)", marks=NEEDS_FULL),
        (">&- 2>&-", 1, ""),
        ("<&- >&- 2>&-", 1, ""),
        ("2>&-", 0, ""),
        pytest.param("2> /dev/full", 0, "", marks=NEEDS_FULL),
    ],
)
@pytest.mark.parametrize("flag", ["--version", "--help"])
def test_lost_output_is_no_crash(redirected: str, status: int, said: str, flag: str) -> None:
    found, out, err = shell(redirected, flag)
    assert found == status
    assert said in err
    assert len(err.splitlines()) == (1 if said else 0)
    assert ("curiosight" in out) == (status == 0)


@pytest.mark.parametrize("redirected", ["2>&-", pytest.param("2> /dev/full", marks=NEEDS_FULL)])
def test_refusal_without_a_place_to_say_it_is_still_a_refusal(redirected: str) -> None:
    assert shell(redirected, "no-command") == (2, "", "")


def test_run_goes_on_without_its_reader(room: Path, tmp_path: Path) -> None:
    reader, writer = os.pipe()
    command = [sys.executable, "-c", PROGRAM, "explore", room, "--steps", "6"]
    process = subprocess.Popen([*command, "--out", tmp_path / "out"], stdout=writer, stderr=writer)
    os.close(writer)
    first = os.read(reader, 10)
    os.close(reader)
    assert first
    assert process.wait(timeout=120) == 1, "the table of results was asked for"
    assert len((tmp_path / "out/steps.csv").read_text().splitlines()) == 1 + 6
    assert {"model.npz", "summary.json", "report.html"} <= files(tmp_path / "out")


def test_nothing_is_lost_where_nothing_is_asked_for(room: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = shell(">&- 2>&-", "segment", room, "--quiet", "--every", "4", "--out", out)
    assert done == (0, "", "")
    assert "objects.json" in files(out)


def test_no_file_takes_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    """What writes to descriptor 2 by itself must not write into the next file opened."""
    program = (
        "import os, sys; from curiosight.cli.streams import settle_streams; settle_streams()\n"
        f"with open({str(tmp_path / 'table.csv')!r}, 'w') as file:\n"
        "    file.write(str(file.fileno() > 2)); file.flush()\n"
        "    os.write(2, b'libpng warning'); print('note', file=sys.stderr)"
    )
    command = ["sh", "-c", '"$@" <&- >&- 2>&-', "sh", sys.executable, "-c", program]
    subprocess.run(command, check=True)
    assert (tmp_path / "table.csv").read_text() == "True"


@pytest.mark.parametrize(
    ("environment", "shown"),
    [
        ({"PYTHONIOENCODING": "ascii"}, "-...?"),
        ({"PYTHONIOENCODING": "latin-1:strict"}, "-...ü"),
        # Not even the arguments are text here: a name is bytes.
        ({"LC_ALL": "POSIX", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}, "\\udcc3\\udcbc"),
    ],
)
def test_characters_that_a_stream_has_not_are_replaced(
    environment: dict[str, str], shown: str, tmp_path: Path
) -> None:
    write_image(tmp_path / "–…ü/one.png", np.zeros((20, 30, 3), np.uint8))
    status, out, _ = shell("", "info", tmp_path / "–…ü", **environment)
    assert status == 0
    title, *rows = out.splitlines()
    assert title.endswith(shown)
    assert any(re.fullmatch("  camera +-", row) for row in rows), "no camera: a dash"


def test_output_takes_all_of_what_a_slow_reader_leaves(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    content = bytes(range(256)) * 2000
    taken = bytearray()

    def read_slowly() -> None:
        while len(taken) < len(content):
            time.sleep(0.001)
            taken.extend(os.read(reader, 20_000))

    thread = threading.Thread(target=read_slowly)
    thread.start()
    output = Output(writer, is_closed=False)
    rest = memoryview(content)
    while rest:
        rest = rest[output.write(rest) :]
    thread.join(timeout=60)
    os.close(writer)
    os.close(reader)
    assert bytes(taken) == content
    assert output.error is None
