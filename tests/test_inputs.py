"""What somebody named as a file is looked at before it is opened: no pipe, device or giant."""

from __future__ import annotations

import ast
import errno
import os
import socket
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import curiosight
from command import call, refusal, succeed
from curiosight.datasets.arrays import read_array
from curiosight.errors.inputs import MAX_BYTES, check_file, read_bytes, read_text
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
ROOT = Path(curiosight.__file__).parent
NEEDS_NULL = pytest.mark.skipif(not Path("/dev/null").is_char_device(), reason="no /dev/null")


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A recording to spoil."""
    write_folder(tmp_path / "room", 4)
    return tmp_path / "room"


def make_pipe(path: Path) -> None:
    os.mkfifo(path)


def make_socket(path: Path) -> None:
    here = os.getcwd()
    os.chdir(path.parent)  # its name may be of some hundred characters at most
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(path.name)
    os.chdir(here)


def link_to_device(path: Path) -> None:
    path.symlink_to(os.devnull)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")
@pytest.mark.parametrize(
    ("make", "words"),
    [(make_pipe, "a pipe"), (make_socket, "a socket"), (link_to_device, "a device")],
)
def test_what_is_no_file_is_told_before_it_is_opened(
    make: Callable[[Path], None], words: str, tmp_path: Path
) -> None:
    make(tmp_path / "one")
    (tmp_path / "link").symlink_to(tmp_path / "one")
    for path in (tmp_path / "one", tmp_path / "link"):
        with pytest.raises(OSError, match=f"^it is {words}, not a file$"):
            check_file(path)


def test_folders_links_in_circles_and_missing_files_are_told_as_usual(tmp_path: Path) -> None:
    (tmp_path / "round").symlink_to(tmp_path / "round")
    for path, number in ((tmp_path, errno.EISDIR), (tmp_path / "round", errno.ELOOP)):
        with pytest.raises(OSError, match=os.strerror(number)):
            read_bytes(path)
    with pytest.raises(FileNotFoundError):
        read_bytes(tmp_path / "missing")


def test_file_is_read_up_to_a_size(tmp_path: Path) -> None:
    (tmp_path / "text").write_bytes(b"\xef\xbb\xbfone\r\ntwo\rthree\n")
    assert read_text(tmp_path / "text", "utf-8-sig") == "one\ntwo\nthree\n"
    assert len(read_bytes(tmp_path / "text", max_bytes=18)) == 18
    with pytest.raises(OSError, match="larger than"):
        read_bytes(tmp_path / "text", max_bytes=17)
    with (tmp_path / "giant").open("wb") as file:
        file.truncate(MAX_BYTES + 1)  # it takes no room on the disk
    with pytest.raises(OSError, match=r"^it is larger than 512 MB$"):
        read_bytes(tmp_path / "giant")


@NEEDS_NULL
@pytest.mark.parametrize("name", ["rgb/000001.png", "depth/000001.png"])
def test_image_that_is_a_device_is_a_bad_frame(
    name: str, source: Path, tmp_path: Path, capsys: Capsys
) -> None:
    (source / name).unlink()
    link_to_device(source / name)
    outcome = succeed(capsys, "learn", source, "--out", tmp_path / "out")
    assert "first 000001 (000001.png cannot be read (it is a device, not a file))" in outcome.err


@NEEDS_NULL
@pytest.mark.parametrize(
    "words",
    [
        "explore SOURCE --config DEVICE",
        "learn SOURCE --teacher boxes:DEVICE",
        "map DEVICE SOURCE",
        "explore SOURCE --regions DEVICE",
        "info SOURCE --depth-camera DEVICE",
        "info DEVICE",
    ],
)
def test_command_refuses_a_device(words: str, source: Path, tmp_path: Path, capsys: Capsys) -> None:
    link_to_device(tmp_path / "device")
    places = {"SOURCE": str(source), "DEVICE": str(tmp_path / "device")}
    for name, place in places.items():
        words = words.replace(name, place)
    out = [] if words.startswith("info") else ["--out", tmp_path / "out"]
    assert str(tmp_path / "device") in refusal(capsys, *words.split(), *out)
    assert not (tmp_path / "out").exists()


@NEEDS_NULL
def test_mask_camera_and_poses_that_are_devices(source: Path, capsys: Capsys) -> None:
    for name in ("ground_truth/000000.png", "camera.json", "poses.txt"):
        (source / name).unlink()
        link_to_device(source / name)
    outcome = call(capsys, "info", source)
    assert outcome.status == 0
    assert "no camera.json" in outcome.out


def test_array_that_claims_more_than_its_file_holds(tmp_path: Path) -> None:
    np.save(tmp_path / "one.npy", np.arange(12).reshape(3, 4))
    np.testing.assert_array_equal(read_array(tmp_path / "one.npy"), np.arange(12).reshape(3, 4))
    content = (tmp_path / "one.npy").read_bytes()
    (tmp_path / "one.npy").write_bytes(content.replace(b"(3, 4)", b"(3, 5)"))
    with pytest.raises(ValueError, match="larger than the file"):
        read_array(tmp_path / "one.npy")


def test_packed_array_that_would_be_too_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez_compressed(tmp_path / "two.npz", depth=np.ones((30, 40)), other=np.zeros(3))
    assert read_array(tmp_path / "two.npz", lambda names: names[0]).shape == (30, 40)
    monkeypatch.setattr("curiosight.datasets.arrays.MAX_BYTES", 9000)
    with pytest.raises(ValueError, match="array: expected"):
        read_array(tmp_path / "two.npz", lambda names: names[0])
    assert read_array(tmp_path / "two.npz", lambda names: names[1]).shape == (3,)


READERS = {"read_bytes", "read_text", "loadtxt", "genfromtxt", "fromfile", "imread"}
# What reads a file that we wrote, or that came with the package.
OWN = ("experiments/", "viewing/", "cli/", "robot/page/")


@pytest.mark.parametrize(
    "module", sorted(path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*.py"))
)
def test_files_of_others_are_read_in_one_way(module: str) -> None:
    if module.startswith(OWN):
        return
    tree = ast.parse((ROOT / module).read_text("utf-8"))
    called = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    assert {node.attr for node in called} & READERS == set()
    assert "np.load" not in map(ast.unparse, called)
