"""One small forest a place and one for everywhere: what is salient depends on where one is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest import Forest, Rows

Labels = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.int64]
Weights = npt.NDArray[np.float32]
Arrays = dict[str, npt.NDArray[np.generic]]

COMMON = -1
# The part of the samples, and of each frame's, that the common forest keeps beside others.
COMMON_SHARE = 0.25
# A place that a view is less likely of is not asked.
MIN_WEIGHT = 0.02


# Forests, and how much each counts.
Asked = tuple[tuple[Forest, float], ...]


class Change(NamedTuple):
    """What learning from a frame changed.

    trees: of each forest, by its place or `COMMON`, those that were grown anew.
    is_rearranged: places were divided anew, so that every forest may be another.
    """

    trees: Mapping[int, tuple[int, ...]]
    is_rearranged: bool = False

    @property
    def n_regrown(self) -> int:
        return sum(map(len, self.trees.values()))


class Experts:
    """Forests that share the work by place; a single one as long as there is one place.

    common: learns from everywhere. Its `max_samples` are those of all forests together.

    A sample carries the spot that it was seen from, so that it moves with it where places are
    divided anew; a new place starts with the trees of the one that most of its samples come
    from.
    """

    def __init__(self, common: Forest) -> None:
        self.common = common
        self.of_place: tuple[Forest, ...] = ()
        self._max_samples = common.max_samples
        self._n_regrown = common.n_regrown
        self._place_of_spot: Numbers = np.empty(0, np.int64)
        self._is_rearranged = False

    @property
    def is_trained(self) -> bool:
        return self.common.is_trained or any(forest.is_trained for forest in self.of_place)

    @property
    def n_samples(self) -> int:
        return self.common.n_samples + sum(forest.n_samples for forest in self.of_place)

    def forests(self) -> dict[int, Forest]:
        """Return all of them, by place."""
        return {COMMON: self.common, **dict(enumerate(self.of_place))}

    def chosen(self, weights: Weights | None) -> dict[int, float]:
        """Return which forests to ask, and how much each counts, in all 1.

        weights: (n_places,) how likely a view is of each place; None = not known.
        """
        of_place, asked = self.of_place, dict[int, float]()
        likely = np.flatnonzero(weights > MIN_WEIGHT).tolist() if weights is not None else []
        for place in likely:
            is_known = place < len(of_place) and of_place[place].is_trained
            key = place if is_known else COMMON
            asked[key] = asked.get(key, 0.0) + float(weights[place])
        total = sum(asked.values())
        return {key: weight / total for key, weight in asked.items()} or {COMMON: 1.0}

    def asked(self, weights: Weights | None) -> Asked:
        """Return those forests themselves."""
        forests = self.forests()
        return tuple((forests[key], weight) for key, weight in self.chosen(weights).items())

    def predict(self, rows: Rows, asked: Asked) -> npt.NDArray[np.float32]:
        """Return the (n,) mean votes for (n, F) rows of a view, in [0, 1]; 0 while untrained."""
        if len(asked) == 1:
            return asked[0][0].predict(rows)
        scores = np.zeros(len(rows), np.float32)
        for forest, weight in asked:
            scores += np.float32(weight) * forest.predict(rows)
        return scores

    def update(self, rows: Rows, is_salient: Labels, spot: int) -> Change:
        """Learn from a frame's samples, drawn in random order: its place all, the common some.

        spot: where they were seen from, known from `arrange`.
        """
        is_rearranged, self._is_rearranged = self._is_rearranged, False
        if not self.of_place:
            return Change({COMMON: self.common.update(rows, is_salient, spot)}, is_rearranged)
        place = int(self._place_of_spot[spot])
        n_common = int(np.ceil(COMMON_SHARE * len(rows)))
        drawn = slice(None, None, max(1, len(rows) // max(n_common, 1)))
        trees = {
            COMMON: self.common.update(rows[drawn], is_salient[drawn], spot),
            place: self.of_place[place].update(rows, is_salient, spot),
        }
        return Change(trees, is_rearranged)

    def fit(
        self, rows: Rows, is_salient: Labels, spots: npt.NDArray[np.int32], place_of_spot: Numbers
    ) -> None:
        """Forget everything, then grow all trees on these samples: the off-line model.

        spots: (n,) where each sample was seen from.
        """
        self._place_of_spot = place_of_spot.copy()
        n_places = int(place_of_spot.max(initial=0)) + 1
        self.of_place = ()
        self._share_out(n_places)
        self.common.fit(rows, is_salient, spots)
        if n_places > 1:
            self.of_place = tuple(self._new_forest(n_places) for _ in range(n_places))
            for place, forest in enumerate(self.of_place):
                here = place_of_spot[spots] == place
                forest.fit(rows[here], is_salient[here], spots[here])

    def arrange(self, place_of_spot: Numbers) -> None:
        """Let samples follow their spots to other places.

        place_of_spot: (n_spots,) places as they are now.
        """
        before = self._place_of_spot
        self._place_of_spot = place_of_spot.copy()
        n_places = int(place_of_spot.max(initial=0)) + 1
        is_as_before = np.array_equal(place_of_spot[: len(before)], before)
        if is_as_before and n_places == max(1, len(self.of_place)):
            return
        sources = self.of_place or (self.common,)
        self._share_out(n_places)
        arrived = range(n_places if n_places > 1 else 0)
        self.of_place = tuple(self._gather(sources, place, place_of_spot) for place in arrived)
        self._is_rearranged = True

    def _gather(self, sources: Iterable[Forest], place: int, place_of_spot: Numbers) -> Forest:
        """Return the forest of a place: its samples, and the trees of who had most of them."""
        parts, most, trees_of = [], -1, self.common
        for source in sources:
            here = place_of_spot[source.groups] == place
            parts.append((source.rows[here], source.is_salient[here], source.groups[here]))
            if source.is_trained and np.count_nonzero(here) > most:
                most, trees_of = np.count_nonzero(here), source
        rows, is_salient, groups = (np.concatenate(some) for some in zip(*parts, strict=True))
        forest = self._new_forest(int(place_of_spot.max()) + 1)
        samples = {"rows": rows, "is_salient": is_salient, "groups": groups}
        forest.restore(trees_of.state_arrays() | samples)
        return forest

    def _share_out(self, n_places: int) -> None:
        """Divide what may be kept among the forests."""
        common, whole = self.common, self._max_samples
        if n_places == 1:
            common.max_samples, common.n_regrown = whole, self._n_regrown
            return
        common.max_samples, common.n_regrown = max(1, int(COMMON_SHARE * whole)), 1
        for forest in self.of_place:
            forest.max_samples = self._share(n_places)

    def _share(self, n_places: int) -> int:
        return max(1, (self._max_samples - self.common.max_samples) // n_places)

    def settings(self) -> dict[str, int | float | str]:
        """Return those of the forest of everywhere, as it was given."""
        return self.common.settings() | {
            "max_samples": self._max_samples,
            "n_regrown": self._n_regrown,
        }

    def state_arrays(self) -> Arrays:
        """Return the arrays of all forests, those of place 3 after `place3_`."""
        arrays = self.common.state_arrays()
        for place, forest in enumerate(self.of_place):
            for name, array in forest.state_arrays().items():
                arrays[f"place{place}_{name}"] = array
        return arrays

    def restore(self, arrays: Arrays, place_of_spot: Numbers | None = None) -> None:
        """Take over what `state_arrays` of experts with the same settings returned.

        Raises ValueError if the arrays do not fit.
        """
        known = np.empty(0, np.int64) if place_of_spot is None else place_of_spot
        n_places = int(known.max(initial=0)) + 1
        self._place_of_spot = known.copy()
        self._share_out(n_places)
        self.common.restore(arrays)
        of_place = []
        for place in range(n_places if n_places > 1 else 0):
            prefix = f"place{place}_"
            own = {name.removeprefix(prefix): a for name, a in arrays.items() if prefix in name}
            forest = self._new_forest(n_places)
            forest.restore(own)
            of_place.append(forest)
        self.of_place = tuple(of_place)

    def _new_forest(self, n_places: int) -> Forest:
        """Return an empty forest for one of so many places; all share one source of chance."""
        return self.common.another(max_samples=self._share(n_places), n_regrown=self._n_regrown)
