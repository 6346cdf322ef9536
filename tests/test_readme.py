"""What the README shows is what the program does; its output: test_demo_command.py."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from command import succeed
from curiosight.cli.commands import COMMANDS
from recordings import write_folder

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text("utf-8")
DOCS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def block(language: str) -> str:
    """Return the README's first code block of a language."""
    found = re.search(rf"```{language}\n(.*?)```", README, re.DOTALL)
    assert found is not None
    return found[1]


def test_python_lines_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    write_folder(tmp_path / "recording", 8)
    monkeypatch.chdir(tmp_path)
    code = block("python")
    assert "n_steps=200" in code
    names: dict[str, object] = {}
    exec(code.replace("n_steps=200", "n_steps=12"), names)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [str(step) for step in range(12)]
    saliency = names["saliency"]
    assert isinstance(saliency, np.ndarray)
    assert saliency.shape == names["dataset"][0].rgb.shape[:2]  # type: ignore[index]
    assert saliency.max() > 0.9
    assert len([line for line in code.splitlines() if line.strip()]) == 8


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.name)
def test_commands_and_options_that_are_named_exist(path: Path, capsys) -> None:
    names = "|".join(COMMANDS)
    for command, rest in re.findall(rf"curiosight ({names})([^`\n]*)", path.read_text("utf-8")):
        help_text = succeed(capsys, command, "--help").out
        for option in re.findall(r"--[a-z-]+", rest):
            assert option in help_text, f"{command} {option}"


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.name)
def test_files_that_are_linked_exist(path: Path) -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", path.read_text("utf-8")):
        assert link.startswith("http") or (path.parent / link).exists(), link


def test_milliseconds_are_those_of_the_benchmarks() -> None:
    benchmarks = (ROOT / "benchmarks/README.md").read_text("utf-8")
    for told, stage in (
        ("segment a frame", "segment"),
        ("RGB →", "RGB → map"),
        ("learn a", "learn"),
    ):
        (ours,) = re.findall(rf"^\| {told}.*?\*\*([\d.]+) ms\*\*", README, re.MULTILINE)
        (measured,) = re.findall(rf"^\| {stage} \| ([\d.]+) \|", benchmarks, re.MULTILINE)
        assert ours == measured, stage
    paper = re.findall(
        r"^\| (?:segment a|RGB →|learn a).*?\| (\d+) ms \| \*\*", README, re.MULTILINE
    )
    stages = re.search(
        r"`paper`, an earlier build.*?segment (\d+).*?learn (\d+),\s+map (\d+)",
        benchmarks,
        re.DOTALL,
    )
    assert stages is not None
    assert paper == [stages[1], stages[3], stages[2]]


def test_tables_that_stand_twice_are_the_same() -> None:
    benchmarks = (ROOT / "benchmarks/README.md").read_text("utf-8")
    rows = re.findall(r"^\| `[\w:-]+`: (?:seconds|looks) \|.*$", README, re.MULTILINE)
    assert len(rows) == 6
    for row in rows:
        assert row in benchmarks


def test_installed_size_is_told_alike() -> None:
    (said,) = re.findall(r"`pip install curiosight` takes (\d+) MB", README)
    install = (ROOT / "docs/install.md").read_text("utf-8")
    assert f"| **{said}** |" in install
    assert int(said) <= 550
