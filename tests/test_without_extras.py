"""What the base install lacks is named where it is needed, and keeps from nothing else."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from command import refusal, succeed
from curiosight.datasets.matlab import read_matlab
from curiosight.errors import DataError
from curiosight.viewing.figures import roc
from recordings import write_folder

Capsys = pytest.CaptureFixture[str]
FIGURES = "need Matplotlib, which is missing: pip install 'curiosight[figures]'"


@pytest.fixture
def without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)


@pytest.mark.usefixtures("without_matplotlib")
def test_run_has_its_report_without_figures(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 6)
    run = tmp_path / "run"
    said = succeed(capsys, "explore", tmp_path / "room", "--steps", 6, "--out", run).err
    assert f"figures are left out: they {FIGURES}" in " ".join(said.split())
    assert (run / "report.html").is_file()
    assert not (run / "figures").exists()
    out = tmp_path / "scores"
    succeed(capsys, "evaluate", run, tmp_path / "room", "--baselines", "bms", "--out", out)
    report = (out / "report.html").read_text("utf-8")
    assert "table.md" in report
    assert "roc.png" not in report
    assert not list(out.rglob("*.png"))


@pytest.mark.usefixtures("without_matplotlib")
@pytest.mark.parametrize("command", [("compare",), ("figures", "--all")])
def test_command_of_figures_is_refused_at_once(
    command: tuple[str, ...], tmp_path: Path, capsys: Capsys
) -> None:
    said = refusal(capsys, *command, "room:7", "--out", tmp_path / "out")
    assert f"{command[0]}: its figures {FIGURES}" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("without_matplotlib")
def test_drawing_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(ImportError, match=r"figures need Matplotlib.*curiosight\[figures\]"):
        roc({}, tmp_path / "roc.png")


def test_matlab_file_says_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.io", None)
    with pytest.raises(DataError, match=r"needs SciPy, which is missing; .*curiosight\[matlab\]"):
        read_matlab(tmp_path / "camera.mat")
