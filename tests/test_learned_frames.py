"""A model knows which frames it has learned from, under whatever folder is the working one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.components import count_learned, make_learner, note_frames
from curiosight.worlds import open_source
from recordings import write_folder


def test_what_is_drawn_has_the_same_name_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learner, views = make_learner(load_config(), None), open_source("room:5,views=4")
    note_frames(learner, views, views.ids[:2])
    monkeypatch.chdir(tmp_path)
    assert learner.notes["frames"] == {"room:5,views=4": sorted(views.ids[:2])}
    assert count_learned(learner, views, range(4)) == 2


def test_a_recording_is_known_by_its_whole_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_folder(tmp_path / "recording", 3)
    monkeypatch.chdir(tmp_path)
    learner, frames = make_learner(load_config(), None), open_dataset("recording")
    note_frames(learner, frames, frames.ids[1:])
    assert list(learner.notes["frames"]) == [os.path.abspath("recording")]
    monkeypatch.chdir(tmp_path / "recording")
    assert count_learned(learner, open_dataset("../recording"), range(3)) == 2
