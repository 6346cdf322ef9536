"""The table of the two presets in docs/method.md."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(BENCHMARKS)
    return importlib.import_module("presets_table")


def test_document_holds_the_results_that_are_kept(benchmark: ModuleType) -> None:
    table = benchmark.table_of(json.loads(benchmark.RESULTS.read_text(encoding="utf-8")))
    document = benchmark.DOCUMENT.read_text(encoding="utf-8")
    assert f"{benchmark.BEGIN}\n{table}\n{benchmark.END}" in document


def test_only_what_is_between_the_marks_is_replaced(benchmark: ModuleType, tmp_path: Path) -> None:
    document = tmp_path / "method.md"
    document.write_text(f"# Before\n{benchmark.BEGIN}\nold\n{benchmark.END}\nAfter\n")
    cell = {"precision": 1.0, "recall": 0.8254, "coverage": 0.5, "overlap_f": None}
    mean = {"roc_auc": {"mean": 0.9}, "f1": {"mean": 0.75}}
    results = {
        "teacher": {"kitchen": {"`paper`": cell | {"boundary_f": 0.25}}},
        "map": {"paper": {"osd_learn, all": mean}},
    }
    for _ in range(2):
        benchmark.write_table(results, document)
        lines = document.read_text(encoding="utf-8").splitlines()
        assert (lines[:2], lines[-2:]) == (
            ["# Before", benchmark.BEGIN],
            [benchmark.END, "After"],
        )
        assert "| `paper` | kitchen | 1.000 | .825 | .500 | – | .250 |" in lines
        assert "| `paper` | .900 / .750 | – |" in lines
        assert "old" not in lines
