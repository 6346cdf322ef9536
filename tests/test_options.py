"""Options that commands share."""

from __future__ import annotations

from pathlib import Path

import pytest

from curiosight.cli.again import command_again
from curiosight.cli.options import absolute_source


def test_teacher_is_found_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert absolute_source("masks:labels") == f"masks:{tmp_path / 'labels'}"
    assert absolute_source(f"boxes:{tmp_path / 'b.json'}") == f"boxes:{tmp_path / 'b.json'}"
    assert absolute_source("depth") == "depth"
    assert absolute_source(None) is None


def test_command_again_holds_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recording").mkdir()
    sources = [Path("recording"), Path("room:7,views=8")]
    words = command_again("evaluate", sources, {"folds": 5, "split": None})
    room = ["room:7,views=8", "--config", "config.toml", "--folds", "5"]
    assert words == ["curiosight", "evaluate", str(tmp_path / "recording"), *room]
