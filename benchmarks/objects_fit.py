"""Fit the weights of the catalogue on drawn homes, and tell how right they are on others.

    python benchmarks/objects_fit.py --seeds 31 33 34 --views 40 --cache FOLDER

Each home is judged by weights from the others, then the weights from all are printed, for
`curiosight.catalogue.confidence` and `.matching`. Truth is as in `objects.py`: a thing is right if
its centre lies within 15 cm of a true one's, one to one; two of different visits are one if they
are right, and the true things are the same. Figures are kept in results/objects_fit.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
from objects import judged, right_pairs, seen_visits, together
from objects_truth import read_truth

from curiosight.catalogue import Catalogue, Entry, Thing, Visit, confidence, matching
from curiosight.catalogue.catalogue import appearances_of

Array = npt.NDArray[Any]
RESULTS = Path(__file__).parent / "results" / "objects_fit.json"
# What a weight costs, in standard deviations of what it weighs.
PENALTY_OF_THINGS, PENALTY_OF_PAIRS = 3.0, 1.0


class Kept(Visit):
    """A visit whose things are found once."""

    def __init__(self, visit: Visit) -> None:
        self.__dict__.update(visit.__dict__)
        self._things = visit.things()

    def things(self) -> list[Thing]:
        return self._things


@dataclass(frozen=True, slots=True)
class Home:
    """A home that was visited twice, with the folders that have the truth."""

    folders: Sequence[Path]
    visits: Sequence[Visit]

    def entries(self) -> list[list[Entry]]:
        """Return the entries of each visit by itself, the least sure, too."""
        return [Catalogue(min_confidence=0).add(visit) for visit in self.visits]

    def keys(self, entries: Sequence[Sequence[Entry]]) -> list[list[str | None]]:
        """Return which true thing each entry of each visit is; None = it is not right."""
        found: list[list[str | None]] = []
        for folder, some in zip(self.folders, entries, strict=True):
            true = read_truth(folder)
            keys: list[str | None] = [None] * len(some)
            centres = [one.T_world_centre for one in some]
            for place, truth in right_pairs(centres, [one.centre for one in true]):
                keys[place] = true[truth].key
            found.append(keys)
        return found


def fit_logistic(x: Array, y: Array, penalty: float) -> tuple[float, list[float]]:
    """Return the intercept and the weights of a logistic regression, by Newton's steps.

    x: (n, k). y: (n,) bool. penalty: of the weights' squares, each measure having variance 1.
    """
    mean, spread = x.mean(0), x.std(0) + 1e-9
    z = np.column_stack([np.ones(len(x)), (x - mean) / spread])
    ridge = penalty * np.array([0.0] + [1.0] * x.shape[1])
    weights = np.zeros(z.shape[1])
    for _ in range(50):
        share = 1 / (1 + np.exp(-np.clip(z @ weights, -30, 30)))
        gradient = z.T @ (y - share) - ridge * weights
        hessian = (z * (share * (1 - share))[:, None]).T @ z + np.diag(ridge)
        weights += np.linalg.solve(hessian, gradient)
    of_each = weights[1:] / spread
    return float(weights[0] - of_each @ mean), of_each.tolist()


def fit_things(homes: Sequence[Home]) -> None:
    """Set the weights of `confidence`."""
    measured, right = [], []
    for home in homes:
        entries = home.entries()
        for visit, some, keys in zip(home.visits, entries, home.keys(entries), strict=True):
            sizes = [one.size_m for one in some]
            n_pixels = [int(np.prod(visit.views[one.thing.best[0]].size)) for one in some]
            things = [one.thing for one in some]
            measured.append(confidence.measure_things(things, sizes, n_pixels, visit.glimpses))
            right += [key is not None for key in keys]
    fitted = fit_logistic(np.concatenate(measured), np.array(right), PENALTY_OF_THINGS)
    _set(confidence, *fitted)


def fit_pairs(homes: Sequence[Home]) -> None:
    """Set the weights of `matching`, from things that were carried."""
    measured, is_one = [], []
    for home in homes:
        entries = home.entries()
        before, after = (appearances_of(some) for some in entries)
        carried = ~matching.are_there(before, after)
        keys = home.keys(entries)
        same = [[key is not None and key == other for other in keys[1]] for key in keys[0]]
        measured.append(matching.measure_pairs(before, after)[carried])
        is_one.append(np.array(same)[carried])
    fitted = fit_logistic(np.concatenate(measured), np.concatenate(is_one), PENALTY_OF_PAIRS)
    _set(matching, *fitted)


def _set(module: ModuleType, first: float, weights: Sequence[float]) -> None:
    module.__dict__["FIRST"] = first
    module.__dict__["WEIGHTS"] = dict(zip(module.__dict__["WEIGHTS"], weights, strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", required=True, help="of homes, two or more")
    parser.add_argument("--views", type=int, default=40, help="of a room, at each visit")
    parser.add_argument("--cache", type=Path, required=True, help="folder for recordings")
    arguments = parser.parse_args()
    homes = {}
    for seed in arguments.seeds:
        folders, visits = seen_visits(seed, arguments.views, arguments.cache)
        homes[seed] = Home(folders, [Kept(visit) for visit in visits])
    kept = {}
    for seed, home in homes.items():
        others = [other for other in homes.values() if other is not home]
        fit_things(others)
        fit_pairs(others)
        kept[f"home:{seed}"] = judged(home.visits, home.folders)
        print(seed, json.dumps(kept[f"home:{seed}"]), flush=True)
    kept["all"] = together(list(kept.values()))
    print("all", json.dumps(kept["all"]))
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
    fit_things(list(homes.values()))
    fit_pairs(list(homes.values()))
    for module in (confidence, matching):
        weights = {name: round(weight, 2) for name, weight in module.WEIGHTS.items()}
        print(module.__name__, round(module.FIRST, 2), json.dumps(weights, indent=1))


if __name__ == "__main__":
    main()
