"""Compare our forests with other learners that learn on-line, or are trained again and again.

    python benchmarks/online_learners.py stream SOURCE NAME   # describe and label each frame once
    python benchmarks/online_learners.py race NAME… [--peers PYTHON] [--onelearn PYTHON]
    python benchmarks/online_learners.py table NAME…   # results, and table and figure of the page

SOURCE: a recording, or home:31. `default` describes its frames, and the teacher with memory labels
them; what the learner would be shown is kept as a stream in runs/learners, the same for all. Before
a frame is learned from, all of its superpixels are predicted: the error is 1 - F1 over their
labelled pixels. docs/learners.md says how the others' environments are made. Keeps
benchmarks/results/online_learners.json.
"""

from __future__ import annotations

import argparse
import json
import pickle
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from online_peers import AGAIN_EVERY, LEARNERS, View, read_stream

from curiosight.config import load_config
from curiosight.evaluation import f1_error_of_rows
from curiosight.experiments.components import make_learner, make_teacher
from curiosight.experiments.timing import one_thread, processor
from curiosight.learner.calibration import Calibration
from curiosight.learner.description import fit_labels, sight_of
from curiosight.worlds.sources import open_source

HERE = Path(__file__).parent
RESULTS, DOCS = HERE / "results" / "online_learners.json", HERE.parent / "docs"
PAGE, FIGURE = DOCS / "learners.md", DOCS / "learners.png"
# Between which the page has the table.
MARKS = "<!-- table -->\n", "<!-- end of table -->\n"
RUNS = HERE.parent / "runs" / "learners"
# Frames over which the figure's curves are a mean.
N_SMOOTHED = 60
# What the figure shows, and how: hues that the colour-blind tell apart on light and dark.
DRAWN = {
    "ours": ("#D55E00", "-"),
    "ours-one-forest": ("#D55E00", ":"),
    "lightgbm-boosting": ("#0072B2", "-"),
    "scikit-forest": ("#56B4E9", "-"),
    "onelearn-amf": ("#009E73", "-"),
    "river-arf": ("#CC79A7", "-"),
    "mlp": ("#E69F00", "-"),
    "sgd": ("#E69F00", ":"),
    "naive-bayes": ("#888888", "-"),
}
NEUTRAL = "#808080"


def store_stream(source: str, name: str, seed: int) -> None:
    """Describe and label the frames of a recording as `explore` would, and keep what they teach."""
    config = load_config("default", None, {"run.seed": seed})
    dataset = open_source(Path(source))
    learner = make_learner(config, make_teacher(config, dataset))
    parts: dict[str, list[Any]] = {
        key: [] for key in ("rows", "n_salient", "n_other", "samples", "is_salient")
    }
    sights = []
    with one_thread():
        for index in range(len(dataset)):
            frame = dataset[index]
            if frame.problem is not None:
                continue
            description = learner.describe(frame.rgb)
            segmentation = learner.segment(frame)
            labels = fit_labels(segmentation.labels, description)
            counts, taught = description.count(labels), learner.sample(description, labels)
            for key, part in zip(parts, (description.rows, *counts, *taught), strict=True):
                parts[key].append(part)
            before = sight_of(description, frame.T_world_camera)
            sights.append((before, learner.sight(frame, description, segmentation)))
    bounds = {"bounds": _bounds(parts["rows"]), "sample_bounds": _bounds(parts["samples"])}
    RUNS.mkdir(parents=True, exist_ok=True)
    path = RUNS / f"{name}.npz"
    np.savez(path, **bounds, **{key: np.concatenate(part) for key, part in parts.items()})
    path.with_suffix(".sights").write_bytes(pickle.dumps(sights))
    print(name, len(sights), "frames,", bounds["sample_bounds"][-1], "samples")


def _bounds(parts: Iterable[Any]) -> Any:
    return np.cumsum([0, *map(len, parts)])


def python_of(learner: str, arguments: argparse.Namespace) -> str | None:
    """Return the Python of the environment that a learner runs in; None = there is none."""
    if learner.startswith("ours"):
        return sys.executable
    own: str | None = arguments.onelearn if learner.startswith("onelearn") else arguments.peers
    return own


def race(arguments: argparse.Namespace) -> None:
    """Run the learners over the streams, one after the other."""
    for learner in arguments.learners or LEARNERS:
        for name in arguments.names:
            python = python_of(learner, arguments)
            if python is not None:
                out = RUNS / f"{name}-{learner}.npz"
                command = [python, str(HERE / "online_peers.py"), str(RUNS / f"{name}.npz")]
                subprocess.run(
                    [*command, learner, str(out), "--seeds", str(arguments.seeds)], check=True
                )


def errors_of(scores: Any, asked: Any, views: list[View]) -> tuple[list[float], list[float]]:
    """Return 1 - F1 of the frames that say it, above 0.5, and above a threshold that follows.

    The second as the program finds it, from scores of the frames before. NaN where a frame was
    not asked for or shows nothing salient.
    """
    plain, followed, start, calibration = [], [], 0, Calibration()
    for view, is_asked in zip(views, asked, strict=True):
        if not is_asked:
            plain.append(np.nan)
            followed.append(np.nan)
            continue
        votes = np.nan_to_num(scores[start : start + len(view.rows)])
        start += len(view.rows)
        counts = view.n_salient, view.n_other
        for errors, found in ((plain, votes), (followed, calibration.scaled(votes))):
            error = f1_error_of_rows(*counts, found)
            errors.append(np.nan if error is None else error)
        if votes.any():
            calibration.add(votes, *counts)
    return plain, followed


def errors_again(scores: Any, views: list[View]) -> list[float]:
    """Return 1 - F1 of the frames that were predicted once more at the end, above 0.5."""
    some = views[::AGAIN_EVERY]
    parts = np.split(scores, _bounds(view.rows for view in some)[1:-1])
    found = [f1_error_of_rows(v.n_salient, v.n_other, s) for v, s in zip(some, parts, strict=True)]
    return [np.nan if error is None else error for error in found]


def collect(names: Iterable[str]) -> dict[str, Any]:
    """Return every learner's figures on every stream."""
    results: dict[str, Any] = {}
    for name in names:
        views = read_stream(RUNS / f"{name}.npz", with_sights=False)
        results[name] = {"frames": len(views)}
        for learner in LEARNERS:
            path = RUNS / f"{name}-{learner}.npz"
            if not path.is_file():
                continue
            stored = np.load(path)
            seeds = [stored[key] for key in stored.files if key.startswith("scores")]
            errors = np.array([errors_of(scores, stored["asked"], views) for scores in seeds])
            means = np.nanmean(errors, axis=2)
            again = [
                np.nanmean(errors_again(stored[key], views))
                for key in stored.files
                if key.startswith("again")
            ]
            results[name][learner] = {
                **json.loads(path.with_suffix(".json").read_text()),
                "seeds": len(seeds),
                "error": [round(float(x), 4) for x in (means[:, 0].mean(), means[:, 0].std())],
                "error_followed": [
                    round(float(x), 4) for x in (means[:, 1].mean(), means[:, 1].std())
                ],
                "error_again": round(float(np.mean(again)), 4) if again else None,
                "curve": _smoothed(errors[:, 1].mean(axis=0)),
            }
    return results


def _smoothed(errors: Any) -> list[float | None]:
    """Return means over the frames up to each tenth; None where none of them has an error."""
    curve: list[float | None] = []
    for end in range(N_SMOOTHED, len(errors) + 1, 10):
        recent = errors[end - N_SMOOTHED : end]
        known = recent[np.isfinite(recent)]
        curve.append(round(float(known.mean()), 4) if len(known) else None)
    return curve


def table(results: dict[str, Any]) -> str:
    """Return the table of docs/learners.md."""
    names = list(results)
    heads = ["learner", "library"]
    for name in names:
        heads += [f"`{name}`, .5", "followed", "again"]
    heads += ["ms an update", "ms a prediction", "MB", "seeds"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for learner in LEARNERS:
        cells = [results[name].get(learner) for name in names]
        known = [cell for cell in cells if cell]
        if not known:
            continue
        row = [f"`{learner}`", _library(known[0])]
        for cell in cells:
            if cell is None:
                row += ["–"] * 3
                continue
            again = cell["error_again"]
            row += [_spread(cell, "error"), _spread(cell, "error_followed")]
            row.append("" if again is None else f"{again:.3f}".replace("0.", "."))
        first = known[-1]
        update = f"{first['update_ms']:.1f}"
        if first["retrain_ms"]:
            update += f" ({first['retrain_ms']:.0f} every {first['retrained_every']})"
        row += [
            update,
            f"{first['predict_ms']:.1f}",
            f"{first['held_mb']:.0f}",
            f"{first['seeds']}",
        ]
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines)


def write_table(lines: str) -> None:
    """Put the table in its place on the page."""
    before, rest = PAGE.read_text().split(MARKS[0])
    _, after = rest.split(MARKS[1])
    PAGE.write_text(f"{before}{MARKS[0]}{lines}\n{MARKS[1]}{after}")
    print(lines)


def _library(cell: dict[str, Any]) -> str:
    name, number = next(iter(cell["packages"].items()))
    return "this" if name == "numba" else f"{name} {number}"


def _spread(cell: dict[str, Any], key: str) -> str:
    mean, spread = cell[key]
    text = f"{mean:.3f}" + (f" ± {spread:.3f}" if cell["seeds"] > 1 else "")
    return text.replace("0.", ".")


def draw(results: dict[str, Any]) -> None:
    """Draw error over frames with thresholds that follow, each curve named beside its end."""
    mpl.use("Agg")
    mpl.rcParams.update(dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor"), NEUTRAL))
    mpl.rcParams.update(dict.fromkeys(("xtick.color", "ytick.color"), NEUTRAL))
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(len(results), 1, figsize=(8, 3.6 * len(results)), sharex=True)
    for panel, (name, learners) in zip(np.atleast_1d(axes), results.items(), strict=True):
        ends: dict[str, float] = {}
        for learner, (colour, style) in DRAWN.items():
            if learner not in learners:
                continue
            curve = np.array(learners[learner]["curve"], float)
            frames = N_SMOOTHED + 10 * np.arange(len(curve))
            panel.plot(frames, curve, color=colour, linestyle=style, linewidth=1.8)
            ends[learner] = curve[np.isfinite(curve)][-1]
        low, high = panel.get_ylim()
        for learner, height in _apart(ends, 0.06 * (high - low)).items():
            panel.text(
                frames[-1] + 5, height, learner, color=DRAWN[learner][0], va="center", fontsize=9
            )
        panel.set_title(name, loc="left", fontsize=10)
        panel.set_ylabel("1 − F1, mean of 60 frames")
        panel.grid(alpha=0.25, color=NEUTRAL)
        panel.spines[["top", "right"]].set_visible(False)
    panel.set_xlabel("frames seen; each is predicted before it is learned from")
    figure.savefig(FIGURE, dpi=110, transparent=True, bbox_inches="tight")


def _apart(heights: dict[str, float], least: float) -> dict[str, float]:
    """Return heights in their order, moved so that neighbours are no nearer than `least`."""
    names = sorted(heights, key=lambda name: heights[name])
    moved = [heights[name] for name in names]
    for _ in range(200):
        for i in range(len(moved) - 1):
            lack = least - (moved[i + 1] - moved[i])
            if lack > 0:
                moved[i] -= lack / 2
                moved[i + 1] += lack / 2
    return dict(zip(names, moved, strict=True))


def main() -> None:
    """Store a stream, run learners over it, or write what they gave."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    streaming = commands.add_parser("stream")
    streaming.add_argument("source")
    streaming.add_argument("name")
    streaming.add_argument("--seed", type=int, default=0)
    racing = commands.add_parser("race")
    racing.add_argument("names", nargs="+")
    racing.add_argument("--peers", metavar="PYTHON")
    racing.add_argument("--onelearn", metavar="PYTHON")
    racing.add_argument("--learners", nargs="+", choices=LEARNERS)
    racing.add_argument("--seeds", type=int, default=3)
    writing = commands.add_parser("table")
    writing.add_argument("names", nargs="+")
    arguments = parser.parse_args()
    if arguments.command == "stream":
        store_stream(arguments.source, arguments.name, arguments.seed)
    elif arguments.command == "race":
        race(arguments)
    else:
        results = collect(arguments.names)
        RESULTS.write_text(json.dumps({"processor": processor(), **results}, indent=1) + "\n")
        write_table(table(results))
        draw(results)


if __name__ == "__main__":
    main()
