"""What was wrong is counted, in memory that has an end."""

from __future__ import annotations

import numpy as np

from curiosight.experiments import problems
from curiosight.experiments.problems import OTHER, Problems
from curiosight.frame import Frame


def bad(number: int, problem: str = "its depth is empty") -> Frame:
    return Frame(str(number), np.zeros((2, 2, 3), np.uint8), problem=problem)


def test_each_frame_counts_once():
    found = Problems()
    for number in (3, 4, 3):
        found.add(bad(number))
    assert found.counts() == {"bad frame": 2}
    (line,) = found.sentences(9, "taught nothing")
    assert line == "2 of 9 frames taught nothing: bad frame, first 3 (its depth is empty)"


def test_memory_has_an_end(monkeypatch):
    monkeypatch.setattr(problems, "MAX_IDS", 10)
    monkeypatch.setattr(problems, "MAX_KINDS", 3)
    found = Problems()
    good = Frame("good", np.zeros((2, 2, 3), np.uint8))
    for number in range(50):
        found.add(bad(number))
        found.add(good, f"mask {number} is missing")
    assert found.counts()["bad frame"] == 50
    assert len(found.counts()) == 4
    assert OTHER in found.counts()
    kept = sum(len(frames.ids) for frames in found._frames.values())
    assert kept == 10
