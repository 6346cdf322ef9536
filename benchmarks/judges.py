"""Compare the learned maps of both presets with every other method, on several recordings.

    python benchmarks/judges.py OSD_LEARN REDKITCHEN [room:11 room:12 …]

osd_learn is learned in 5 random folds of frames, redkitchen in 5 blocks; a drawn room off-line from
60 views, and tested on 40 others after its things were moved. Nothing is learned from ground truth,
which all are tested on. Keeps benchmarks/results/judges.json, and writes docs/judges.md anew.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from curiosight.cli.evaluate_report import method_results
from curiosight.config import Config
from curiosight.evaluation import SplitKind
from curiosight.experiments.comparing import choose_methods
from curiosight.experiments.evaluating import CrossValidation, Evaluation
from curiosight.experiments.learning import OffLine
from curiosight.viewing.comparison import MethodResult, markdown_table
from curiosight.worlds.sources import open_source

HERE = Path(__file__).parent
RESULTS, PAGE = HERE / "results" / "judges.json", HERE.parent / "docs" / "judges.md"
N_FOLDS, N_VIEWS, N_TEST_VIEWS = 5, 60, 40
SPLITS: dict[str, SplitKind] = {"redkitchen": "blocks"}
HEAD = """# The learned map beside other methods

Written by `python benchmarks/judges.py`, which says how. Intervals are 95 %, bootstrap over frames.
"depth" is what the teacher says of the very frame, with what it knows of the whole recording, and
noise where it says nothing: more than the others are shown, which have colour alone. Fβ, E, S,
weighted F and MAE stretch each map to reach from 0 to 1.

"""


def split_of(source: str) -> SplitKind:
    """Return how a recording's frames are split."""
    return SPLITS.get(Path(source).name, "frames")


def evaluations(source: str, config: Config, baselines: str) -> Evaluation | CrossValidation:
    """Return what judges a recording's maps, ready to run."""
    methods = choose_methods(baselines)
    if not source.startswith("room:"):
        split = split_of(source)
        dataset = open_source(Path(source))
        return CrossValidation(config, dataset, n_folds=N_FOLDS, split=split, methods=methods)
    off_line = OffLine(config, open_source(Path(f"{source},views={N_VIEWS}")))
    for _ in off_line:
        pass
    moved = open_source(Path(f"{source},views={N_TEST_VIEWS},rearrange=1,split=test"))
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "model.npz"
        off_line.fit().save(model)
        return Evaluation(config, model, moved, methods=methods)


def results(source: str) -> tuple[list[MethodResult], dict[str, Any]]:
    """Return both presets' and the others' results, and their tables without single frames."""
    methods: list[MethodResult] = []
    tables: dict[str, Any] = {}
    # Of the second run only the learned map is kept.
    for preset, baselines in (("default", "all"), ("paper", "depth")):
        config = Config.of_preset(preset)
        evaluation = evaluations(source, config, baselines)
        for _ in evaluation:
            pass
        comparison = evaluation.comparison
        assert comparison is not None
        metrics = evaluation.metrics()["methods"]
        times = comparison.times_ms()
        for result in method_results(comparison, metrics, times):
            if preset == "default" or result.is_ours:
                table = {**metrics[result.name], "times": times.get(result.name)}
                del table["per_frame"], table["mean_per_frame"]
                tables[result.name] = table
                methods.append(result)
    return methods, tables


def lines(source: str, methods: list[MethodResult], n_frames: int) -> Iterator[str]:
    """Yield the section of a recording."""
    if source.startswith("room:"):
        how = f"learned from {N_VIEWS} views, tested on {n_frames} after its things were moved"
    else:
        how = f"{N_FOLDS} folds of {split_of(source)}, {n_frames} frames with ground truth"
    yield f"## {Path(source).name}\n\n{how}\n\n"
    yield markdown_table(methods) + "\n"


def main() -> None:
    """Compare and keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sources", nargs="+")
    kept: dict[str, Any] = {}
    page = [HEAD]
    for source in parser.parse_args().sources:
        methods, kept[Path(source).name] = results(source)
        ours = kept[Path(source).name]["ours (default)"]
        page += lines(source, methods, ours["n_frames"])
        for method in methods:
            print(
                f"{Path(source).name:12s} {method.name:18s} {method.figures['roc_auc']}", flush=True
            )
        RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
        PAGE.write_text("".join(page).rstrip() + "\n")


if __name__ == "__main__":
    main()
