"""Damage that a decoder passes over with a line to standard error makes a bad frame instead."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import succeed
from curiosight.datasets.complaints import listen
from curiosight.datasets.decoding import UnreadableFile, read_rgb
from recordings import write_image, write_seven_scenes

Capsys = pytest.CaptureFixture[str]


def noise(width: int = 160, height: int = 120) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), np.uint8)


def cut_out(content: bytes) -> bytes:
    """Leave out the second half of the coded picture; its end mark stays."""
    return content[: len(content) // 2] + content[-2:]


def blank(content: bytes) -> bytes:
    """Set much of the coded picture to 0."""
    middle = len(content) // 2
    return content[:middle] + bytes(3000) + content[middle + 3000 :]


def flip(content: bytes) -> bytes:
    """Turn 30 bits of the coded picture over."""
    flipped, rng = bytearray(content), np.random.default_rng(2)
    for place in rng.integers(len(content) // 5, len(content) - 100, 30):
        flipped[place] ^= 1 << int(rng.integers(8))
    return bytes(flipped)


@pytest.mark.parametrize("spoil", [cut_out, blank, flip])
def test_damaged_jpeg_is_a_bad_frame_and_nothing_is_printed(
    spoil, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "one.jpg"
    write_image(path, noise())
    assert read_rgb(path).shape == (120, 160, 3)
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(UnreadableFile, match=r"^one\.jpg is damaged \(Corrupt JPEG data: "):
        read_rgb(path)
    assert capfd.readouterr() == ("", "")


def test_run_with_damaged_jpegs_counts_them(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_seven_scenes(tmp_path / "kitchen", 5, ending="jpg")
    path = tmp_path / "kitchen/seq-01/frame-000002.color.jpg"
    path.write_bytes(cut_out(path.read_bytes()))
    outcome = succeed(capfd, "learn", tmp_path / "kitchen", "--quiet", "--out", tmp_path / "out")
    (line,) = outcome.err.splitlines()
    assert "1 of 5 frames taught nothing: bad frame, first frame-000002 (" in line
    assert "frame-000002.color.jpg is damaged (Corrupt JPEG data: " in line


def test_few_bytes_before_the_end_harm_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_image(tmp_path / "one.jpg", noise())
    whole = read_rgb(tmp_path / "one.jpg")
    content = (tmp_path / "one.jpg").read_bytes()
    (tmp_path / "one.jpg").write_bytes(content[:-2] + bytes(5) + content[-2:])
    np.testing.assert_array_equal(read_rgb(tmp_path / "one.jpg"), whole)
    assert capfd.readouterr() == ("", "")


def test_what_others_say_meanwhile_is_handed_on(capfd: pytest.CaptureFixture[str]) -> None:
    def decode() -> int:
        os.write(2, b"Corrupt JPEG data: premature end of data segment\n")
        os.write(2, b"a note of a thread\n")
        os.write(2, b"libpng warning: iCCP: known incorrect sRGB profile\n")
        return 7

    damage = "Corrupt JPEG data: premature end of data segment"
    assert listen(decode) == (7, damage)
    assert capfd.readouterr().err == "a note of a thread\n"
    assert listen(lambda: 8) == (8, None)


def test_threads_hear_only_their_own_complaints(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    good = cv2.imencode(".jpg", noise())[1]
    bad = np.frombuffer(cut_out(good.tobytes()), np.uint8)
    heard: dict[bool, set[bool]] = {True: set(), False: set()}

    def decode_many(is_good: bool) -> None:
        for _ in range(50):
            _, damage = listen(lambda: cv2.imdecode(good if is_good else bad, 1))
            heard[is_good].add(damage is None)

    threads = [threading.Thread(target=decode_many, args=(is_good,)) for is_good in heard]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert heard == {True: {True}, False: {False}}
    assert capfd.readouterr().err == ""


def test_without_standard_error_pictures_are_read(tmp_path: Path) -> None:
    write_image(tmp_path / "one.jpg", noise())
    program = (
        "import sys; from pathlib import Path; from curiosight.datasets.decoding import read_rgb\n"
        "print(read_rgb(Path(sys.argv[1])).shape)"
    )
    done = subprocess.run(
        ["sh", "-c", '"$@" 2>&-', "sh", sys.executable, "-c", program, tmp_path / "one.jpg"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "(120, 160, 3)\n"
