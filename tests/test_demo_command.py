"""curiosight demo: a short one, whole."""

from __future__ import annotations

import json
import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from command import call, files, interrupt_at, refusal, succeed
from curiosight.cli.app import run
from curiosight.experiments import demonstrating
from curiosight.learner.learner import SaliencyLearner
from curiosight.rooms.renderer import Renderer
from curiosight.rooms.scene import Scene

Capsys = pytest.CaptureFixture[str]
README = (Path(__file__).parent.parent / "README.md").read_text("utf-8")


@pytest.fixture(scope="module", autouse=True)
def few_views() -> Iterator[None]:
    """Render a tenth of the demo's views: time is what rendering takes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demonstrating, "N_VIEWS", 16)
        patch.setattr(demonstrating, "N_TEST_VIEWS", 8)
        yield


@pytest.fixture(scope="module", autouse=True)
def lit_once() -> Iterator[None]:
    """Light each room once, whoever draws it: test_room_renderer.py tells that it is the same."""
    lit: dict[bytes, Renderer] = {}

    def renderer(scene: Scene, *, n_threads: int) -> Renderer:
        drawn = pickle.dumps(scene)
        if drawn not in lit:
            lit[drawn] = Renderer(scene, n_threads=n_threads)
        return lit[drawn]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("curiosight.rooms.views.Renderer", renderer)
        yield
    assert len(lit) == 2  # before the move, and after


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("demo") / "out"
    options = ["--steps", "12", "--seed", "3", "--preset", "default", "--quiet"]
    assert run(["demo", *options, "--out", str(path)]) == 0
    return path


def summary_of(folder: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads((folder / "demo.json").read_text())
    return content


def test_it_learns_and_is_tested_after_the_things_were_moved(shown: Path) -> None:
    summary = summary_of(shown)
    assert summary["room"] == "room:3,views=16"
    assert summary["rearranged"] == "room:3,rearrange=1,views=8,split=test"
    aucs = summary["roc_auc_after_move"]
    baseline = summary["baseline_roc_auc_after_move"]
    assert isinstance(aucs, dict)
    assert isinstance(baseline, dict)
    assert set(aucs) == set(baseline) == {"all", "near", "beyond_range", "missing"}
    # Twelve looks are few, and still enough to be better than what pops out.
    assert aucs["all"] > max(0.6, baseline["all"])


def test_the_report_shows_the_move_first(shown: Path) -> None:
    page = (shown / "report.html").read_text()
    after, unseen = page.index("After the things were moved"), page.index("never learned from")
    learned, numbers = page.index("views it learned from"), page.index("In numbers")
    assert after < unseen < learned < numbers
    # What the camera saw, the teacher and the model said, and the truth: of four views and three.
    assert len(re.findall(r"<img", page[after:unseen])) == 16
    assert len(re.findall(r"<img", page[unseen:learned])) == 12
    assert page[numbers:].index("fine-grained") < page[numbers:].index("How it learned")
    assert "curiosight demo --seed 3 --steps 12 --preset default" in page
    assert "table" in page  # the furniture on the map is named
    assert not re.search(r'(src|href)="(?!data:|#)', page)


def test_a_run_of_explore_is_all_there(shown: Path) -> None:
    for name in ("steps.csv", "model.npz", "config.toml", "figures/after_move.png"):
        assert (shown / name).is_file()


def test_the_same_seed_gives_the_same_bytes_and_the_table_of_the_readme(
    shown: Path, tmp_path: Path, capsys: Capsys
) -> None:
    outcome = succeed(capsys, "demo", "--steps", "12", "--seed", "3", "--out", tmp_path / "again")
    for name in ("steps.csv", "model.npz", "config.toml"):
        assert (tmp_path / "again" / name).read_bytes() == (shown / name).read_bytes(), name
    again, before = summary_of(tmp_path / "again"), summary_of(shown)
    assert again["roc_auc_after_move"] == before["roc_auc_after_move"]
    lines = outcome.out.splitlines()
    assert lines[0] == "demo"
    # The words exactly; the numbers are a whole demo's, and this is a short one.
    marked = README.split("<!-- output of: curiosight demo -->")[1]
    assert row_names(outcome.out) == row_names(marked.split("```")[1])
    for wanted in ("overall error", "after things were moved", "beyond 4 m", "segment (ms)"):
        assert any(wanted in line for line in lines), wanted
    assert lines[-1].endswith("report.html")
    assert len(lines) < 20


def row_names(text: str) -> list[str]:
    """Return what the rows of a table of results are of."""
    return [line.split("  ")[1] for line in text.splitlines() if line.startswith("  ")]


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_before_its_loop_it_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    monkeypatch.setattr("curiosight.rooms.views.Renderer", lambda *_, **__: None)
    interrupt_at(monkeypatch, demonstrating, "Exploration")
    outcome = call(capsys, "demo", "--seed", "3", "--out", tmp_path / "out")
    assert outcome.status == 130
    assert outcome.err.splitlines()[-1] == "curiosight: interrupted"
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("ctrl_c_as_usual")
@pytest.mark.parametrize(
    ("owner", "method", "turn", "said", "n_tested"),
    [
        (SaliencyLearner, "learn", 2, "stopped after 2 steps; all is kept", 0),
        (demonstrating, "fine_grained", 3, "after 4 steps and 3 test views after the move", 3),
    ],
)
def test_interrupted_it_keeps_what_was_done_and_says_how_much(
    owner: object, method: str, turn: int, said: str, n_tested: int,
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys,
) -> None:  # fmt: skip
    monkeypatch.setattr(demonstrating, "N_VIEWS", 8)
    monkeypatch.setattr(demonstrating, "N_TEST_VIEWS", 4)
    interrupt_at(monkeypatch, owner, method, turn)
    outcome = call(capsys, "demo", "--steps", 4, "--seed", 3, "--out", tmp_path / "out")
    assert outcome.status == 130
    assert said in outcome.err
    assert summary_of(tmp_path / "out")["views_after_move"] == n_tested
    assert {"report.html", "model.npz", "steps.csv"} <= files(tmp_path / "out")
    page = (tmp_path / "out/report.html").read_text()
    assert ("Then the things were moved" in page) == (n_tested > 0)
    assert ("After the move: objects" in page) == (n_tested > 0)


def test_mistakes_are_one_line(capsys: Capsys, tmp_path: Path) -> None:
    assert "n_steps" in refusal(capsys, "demo", "--steps", "0", "--out", tmp_path / "x")
    assert "seed" in refusal(capsys, "demo", "--seed", "-1", "--out", tmp_path / "x")
    (tmp_path / "full").mkdir()
    (tmp_path / "full/mine.txt").write_text("mine")
    assert "not empty" in refusal(capsys, "demo", "--out", tmp_path / "full")
