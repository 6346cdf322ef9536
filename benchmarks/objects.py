"""How right a catalogue of a drawn home is, and what it says is new, moved or gone.

    python benchmarks/objects.py --seeds 11 12 13 14 15 --cache FOLDER

Two visits: the home as it is, and with `rearrange=1`, each of so many views a room, with a model
that learned off-line from the first. An entry is right if its centre lies within 15 cm of a truth
object's, one to one; of new, moved and gone, within 15 cm of one that became that. Truth objects
are those that at least two views of a visit show with 400 pixels: see `objects_truth.py`. Figures
are kept in results/objects.json. Developed on the homes 31, 33 and 34: see `objects_fit.py`.
"""

from __future__ import annotations

import argparse
import json
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from objects_truth import read_truth, recorded_visit, true_changes
from scipy.optimize import linear_sum_assignment

from curiosight.catalogue import Catalogue, Entry, Visit
from curiosight.config import load_config
from curiosight.experiments.cataloguing import Cataloguing
from curiosight.experiments.learning import OffLine
from curiosight.frame import Pose
from curiosight.worlds.sources import open_source

VISITS = "visits.pickle"
RESULTS = Path(__file__).parent / "results" / "objects.json"
MAX_AWAY = 0.15
CHANGES = ("new", "moved", "gone")
COUNTED = ("entries", "changes", "before", "after", *CHANGES)
Counts = tuple[int, int, int]  # right, said, true


def right_pairs(said: Sequence[Pose], true: Sequence[Sequence[float]]) -> list[tuple[int, int]]:
    """Return the places of centres that are right, one to one, and of the true things'."""
    if not said or not true:
        return []
    centres = np.stack([pose[:3, 3] for pose in said])
    away = np.linalg.norm(centres[:, None] - np.asarray(true)[None], axis=2)
    rows, columns = linear_sum_assignment(np.where(away < MAX_AWAY, away, 10.0))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(row, column) for row, column in pairs if away[row, column] < MAX_AWAY]


def count_right(said: Sequence[Pose], true: Sequence[Sequence[float]]) -> Counts:
    """Return how many centres are right, one to one, of how many said and how many true."""
    return len(right_pairs(said, true)), len(said), len(true)


def figures(counts: Sequence[Counts]) -> dict[str, Any]:
    """Return precision and recall of counts together."""
    right, said, true = np.sum(counts, axis=0).tolist()
    return {
        "precision": round(right / max(1, said), 4),
        "recall": round(right / max(1, true), 4),
        "right": right,
        "said": said,
        "true": true,
    }


def together(homes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of homes together, each thing counting the same."""
    return {
        name: figures([(one[name]["right"], one[name]["said"], one[name]["true"]) for one in homes])
        for name in COUNTED
    }


def score(first: Sequence[Entry], last: Sequence[Entry], folders: Sequence[Path]) -> dict[str, Any]:
    """Return figures of the entries after the first visit and after the second."""
    before, after = (read_truth(folder) for folder in folders)
    now, gone = true_changes(before, after)
    found = [one for one in last if one.seen[-1].visit == 1]
    counts = {
        "before": count_right([one.T_world_centre for one in first], [t.centre for t in before]),
        "after": count_right([one.T_world_centre for one in found], [t.centre for t in after]),
    }
    for change in CHANGES:
        true = gone if change == "gone" else [thing for thing, what in now if what == change]
        said = [one.T_world_centre for one in last if one.change == change]
        counts[change] = count_right(said, [thing.centre for thing in true])
    return {
        "entries": figures([counts["before"], counts["after"]]),
        "changes": figures([counts[change] for change in CHANGES]),
    } | {name: figures([of]) for name, of in counts.items()}


def learned(folder: Path) -> Path:
    """Return the file of a model that learned off-line from a recording; kept beside it."""
    path = folder / "model.npz"
    if not path.exists():
        off_line = OffLine(load_config(), open_source(folder))
        for _ in off_line:
            pass
        off_line.fit().save(path)
    return path


def seen_visits(seed: int, n_views: int, cache: Path) -> tuple[list[Path], list[Visit]]:
    """Return the recordings of a home before and after, and what a teacher and a map see there.

    All is kept in the cache: the visits, too, which take long, and do not depend on how detections
    are grouped and matched.
    """
    source = f"home:{seed},views={n_views}"
    sources = (source, f"{source},rearrange=1")
    folders = [recorded_visit(one, cache / one.replace(":", "-")) for one in sources]
    path = folders[0] / VISITS
    if not path.exists():
        settings = load_config(overrides={"segmentation.stride": 1})
        datasets = [open_source(folder) for folder in folders]
        cataloguing = Cataloguing(settings, learned(folders[0]), datasets)
        for _ in cataloguing:
            pass
        path.write_bytes(pickle.dumps(cataloguing.catalogue.visits))
    visits: list[Visit] = pickle.loads(path.read_bytes())
    return folders, visits


def judged(visits: Sequence[Visit], folders: Sequence[Path]) -> dict[str, Any]:
    """Return the figures of a catalogue of two visits, by the weights as they are."""
    catalogue = Catalogue()
    first = catalogue.add(visits[0])
    return score(first, catalogue.add(visits[1]), folders)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", required=True, help="of homes")
    parser.add_argument("--views", type=int, default=40, help="of a room, at each visit")
    parser.add_argument("--cache", type=Path, required=True, help="folder for recordings")
    arguments = parser.parse_args()
    kept: dict[str, Any] = {}
    for seed in arguments.seeds:
        folders, visits = seen_visits(seed, arguments.views, arguments.cache)
        source = f"home:{seed},views={arguments.views}"
        kept[source] = judged(visits, folders)
        print(source, json.dumps(kept[source]), flush=True)
    kept["all"] = together(list(kept.values()))
    print("all", json.dumps(kept["all"]))
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
