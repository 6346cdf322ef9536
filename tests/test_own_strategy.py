"""A strategy of one's own, named on the command line: it runs, or one line says why not."""

from __future__ import annotations

import csv
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from command import refusal, succeed
from curiosight.explorer.check import check_strategy
from curiosight.explorer.own import is_own, load_own
from curiosight.explorer.strategies import make_strategy
from recordings import write_folder
from test_strategies import make_views, run

DOCS = Path(__file__).parent.parent / "docs" / "strategies.md"
PLAIN = """
class Plain:
    def __init__(self, views, rng, *, ways=None):
        if not views:
            raise ValueError("views: expected some")
        self.views, self.n = views, 0

    def choose(self):
        self.n += 1
        return self.views[self.n % len(self.views)]

    def update(self, viewpoint, outcome):
        pass

    def upcoming(self):
        return ()

    def progress_of(self, region):
        return None
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that a user is in; what is imported from there is forgotten again."""
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in ("mine", "surprised"):
        sys.modules.pop(name, None)


def documented() -> str:
    return re.findall(r"```python\n(.*?)```", DOCS.read_text("utf-8"), flags=re.S)[0]


def test_the_documented_example_is_what_it_says(folder: Path) -> None:
    assert len(documented().split("class ")[1].splitlines()) <= 23
    (folder / "surprised.py").write_text(documented())
    views = make_views(4, 4)
    chosen = run(make_strategy("surprised:Surprised", views, np.random.default_rng()), 8, 0.9)
    assert [view.index for view in chosen] == [0, 1, 2, 3, 0, 1, 2, 3], "all of it is a surprise"
    chosen = run(make_strategy("surprised:Surprised", views, np.random.default_rng()), 8, 0.1)
    assert [view.index for view in chosen] == [view.index for view in views]
    check_strategy(load_own("surprised:Surprised"))


def test_the_documented_example_explores(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    room = tmp_path_factory.mktemp("room")
    write_folder(room, 6)
    (folder / "surprised.py").write_text(documented())
    options = ("--strategy", "surprised:Surprised", "--regions", "time:2", "--steps", 5)
    succeed(capsys, "explore", room, *options, "--out", folder / "out")
    with (folder / "out" / "steps.csv").open() as file:
        assert len({row["id"] for row in csv.DictReader(file)}) == 5
    assert not (folder / "out" / "decisions.csv").exists(), "it gives no reasons"
    page = (folder / "out" / "report.html").read_text("utf-8")
    assert "as surprised:Surprised told it" in page
    assert "decisions" not in page.split("<style>")[0] + page.split("</style>")[-1]


def test_what_has_a_colon_is_a_class_only_if_it_can_be_one() -> None:
    assert is_own("mine:Mine")
    assert is_own("my_package.looking:Around")
    for name in ("iac", "mine", "mine:", ":Mine", "sweep:10", "rl-iac:sampled", "a b:C", "a:b:c"):
        assert not is_own(name)


@pytest.mark.parametrize(
    ("source", "name", "complaint"),
    [
        (PLAIN, "absent:Plain", "no module 'absent'; install it, or run in the folder"),
        (PLAIN, "mine.inner:Plain", "no module 'mine.inner'"),
        (PLAIN, "mine:Plan", r"expected a class Plan in .*mine\.py, got nothing of that name"),
        (PLAIN + "\nPlan = 3", "mine:Plan", "got int Plan"),
        ("import absent_too", "mine:Plain", r"mine cannot be imported: .*absent_too.*\(mine.py, l"),
        ("class Plain(:", "mine:Plain", r"mine cannot be imported: SyntaxError.*mine\.py, line 1"),
        ("1 / 0", "mine:Plain", r"cannot be imported: ZeroDivisionError: .* \(mine\.py, line 1\)"),
        ("raise SystemExit(3)", "mine:Plain", "cannot be imported: SystemExit: 3"),
        (
            PLAIN.replace(", *, ways=None", ""),
            "mine:Plain",
            "breaks the contract: TypeError: .*ways",
        ),
        (
            PLAIN.replace("self.n % len(self.views)", "self.n"),
            "mine:Plain",
            r"breaks the contract: IndexError: .* \(mine\.py, line 10\)",
        ),
        (
            PLAIN.replace('raise ValueError("views: expected some")', "pass"),
            "mine:Plain",
            "without",
        ),
        (PLAIN.replace("return None", "return 1e999"), "mine:Plain", "progress_of: expected None"),
        (PLAIN + "\n    def reasons(self):\n        return 3", "mine:Plain", "a Decision"),
    ],
)
def test_what_is_wrong_with_it_is_told_in_one_line(
    folder: Path, source: str, name: str, complaint: str
) -> None:
    (folder / "mine.py").write_text(source)
    with pytest.raises(ValueError, match=rf"^strategy: .*{complaint}") as caught:
        load_own(name)
    assert "\n" not in str(caught.value)


def test_it_is_refused_before_anything_is_done(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_folder(folder / "room", 4)
    for name, complaint in (
        ("absent:Me", "no module 'absent'"),
        ("covrage", "did you mean coverage?"),
        ("oracle", "only comparisons"),
    ):
        line = refusal(capsys, "explore", folder / "room", "--strategy", name, "--out", "out")
        assert complaint in line
    assert not (folder / "out").exists()


def test_the_path_of_imports_is_as_it_was(folder: Path) -> None:
    (folder / "mine.py").write_text(PLAIN)
    before = list(sys.path)
    load_own("mine:Plain")
    with pytest.raises(ValueError, match="no module"):
        load_own("absent:Plain")
    assert sys.path == before
