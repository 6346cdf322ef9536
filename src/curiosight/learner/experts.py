"""One small forest a place and one for everywhere: what is salient depends on where one is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from threading import Lock
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.learner.drift import Alarm
from curiosight.learner.features import Rows
from curiosight.learner.forest import Forest
from curiosight.learner.lesson import Labels, Lesson, join_lessons
from curiosight.learner.places import Places
from curiosight.learner.scenery import Scenery, Signs
from curiosight.learner.sight import Sight
from curiosight.learner.staleness import Staleness

Numbers = npt.NDArray[np.int64]
Arrays = dict[str, npt.NDArray[np.generic]]
# A forest with its samples' rows, whether each is salient, and the spot of each.
Source = tuple[Forest, Rows, Labels, npt.NDArray[np.int32]]

COMMON = -1
# The part of the samples, and of each frame's, that the common forest keeps beside others.
COMMON_SHARE = 0.25
# From so many views a place is known well enough to say what its scores mean.
MIN_VIEWS = 8
# A place that a view is less likely of is not asked.
MIN_WEIGHT = 0.02


class Change(NamedTuple):
    """What learning from a frame changed.

    trees: of each forest, by its place or `COMMON`, those that were grown anew.
    is_rearranged: places were divided anew, so that every forest may be another.
    alarm: its place is no longer what was learned of it, see `Drift`; None = it is.
    """

    trees: Mapping[int, tuple[int, ...]]
    is_rearranged: bool = False
    alarm: Alarm | None = None

    @property
    def has_drifted(self) -> bool:
        return self.alarm is not None

    @property
    def n_regrown(self) -> int:
        return sum(map(len, self.trees.values()))


class Experts:
    """Forests that share the work by place; a single one as long as there is one place.

    common: learns from everywhere. Its `max_samples` are those of all forests together.
    places: tells which place a view is of; None = all views are of one.

    A sample carries the spot that it was seen from, so that it moves with it where places are
    divided anew; a new place starts with the trees of the one that most of its samples come
    from. Where a place has changed, what was learned before leaves first.
    """

    def __init__(self, common: Forest, places: Places | None = None) -> None:
        self.common = common
        self.places = places
        self.of_place: tuple[Forest, ...] = ()
        self._max_samples = common.max_samples
        self._n_regrown = common.n_regrown
        self._place_of_spot: Numbers = np.empty(0, np.int64)
        self._is_rearranged = False
        self._staleness = Staleness()
        self._scenery = Scenery()
        # Of the view that was noted last.
        self._signs = Signs()
        self._pose: Pose | None = None
        # Held where places and their forests must fit each other.
        self._lock = Lock()

    def __getstate__(self) -> dict[str, object]:
        """Return what is copied and pickled: all but the lock."""
        return {name: value for name, value in vars(self).items() if name != "_lock"}

    def __setstate__(self, state: dict[str, object]) -> None:
        vars(self).update(state, _lock=Lock())

    @property
    def is_trained(self) -> bool:
        return self.common.is_trained or any(forest.is_trained for forest in self.of_place)

    @property
    def n_samples(self) -> int:
        return self.common.n_samples + sum(forest.n_samples for forest in self.of_place)

    def n_views(self) -> list[int]:
        """Return of how many views each place is known; none where places are not told apart."""
        return [] if self.places is None else self.places.n_views.tolist()

    def forests(self) -> dict[int, Forest]:
        """Return all of them, by place."""
        return {COMMON: self.common, **dict(enumerate(self.of_place))}

    def knows(self, sight: Sight | None) -> bool:
        """Tell whether the place of a view was seen often; always where places do not count."""
        if self.places is None or sight is None:
            return True
        with self._lock:
            weights, n_views = self.places.locate(sight.T_world_camera, sight.look), self.n_views()
        return len(weights) > 0 and n_views[int(weights.argmax())] >= MIN_VIEWS

    def chosen(self, sight: Sight | None) -> dict[int, float]:
        """Return which forests to ask of a view, and how much each counts, in all 1."""
        with self._lock:
            return self._chosen(sight)

    def vote(self, rows: Rows, sight: Sight | None = None) -> npt.NDArray[np.float32]:
        """Return the (n,) mean votes for (n, F) rows of a view, in [0, 1]; 0 while untrained.

        They are those of the forests that know its place.
        """
        with self._lock:
            forests = self.forests()
            asked = [(forests[key], weight) for key, weight in self._chosen(sight).items()]
        if len(asked) == 1:
            return asked[0][0].predict(rows)
        votes = np.zeros(len(rows), np.float32)
        for forest, weight in asked:
            votes += np.float32(weight) * forest.predict(rows)
        return votes

    def disagreement(self, rows: Rows, sight: Sight | None = None) -> npt.NDArray[np.float32]:
        """Return (n,) in [0, 0.5] how far votes for (n, F) rows of a view are from being one.

        It is the standard deviation of the votes of all trees that are asked: 0.5 = half of them
        say yes, half no. Beside a place's forest that of everywhere is asked, and counts as
        much, so that experts that contradict each other are heard.
        """
        with self._lock:
            forests = self.forests()
            weights = self._chosen(sight)
        if COMMON not in weights and self.common.is_trained:
            weights = {key: weight / 2 for key, weight in weights.items()} | {COMMON: 0.5}
        mean, square = np.zeros((2, len(rows)), np.float32)
        for key, weight in weights.items():
            votes = forests[key].votes(rows)
            mean += np.float32(weight) * votes.mean(axis=1)
            square += np.float32(weight) * (votes**2).mean(axis=1)
        return np.asarray(np.sqrt(np.maximum(square - mean**2, 0)))

    def seen_rows(self) -> list[Rows]:
        """Return the rows of all samples, of each forest by itself."""
        with self._lock:
            forests = self.forests()
        return [forest.rows for forest in forests.values()]

    def _chosen(self, sight: Sight | None) -> dict[int, float]:
        if self.places is None or sight is None:
            return {COMMON: 1.0}
        asked: dict[int, float] = {}
        weights = self.places.locate(sight.T_world_camera, sight.look)
        for place in np.flatnonzero(weights > MIN_WEIGHT).tolist():
            is_known = place < len(self.of_place) and self.of_place[place].is_trained
            key = place if is_known else COMMON
            asked[key] = asked.get(key, 0.0) + float(weights[place])
        total = sum(asked.values())
        return {key: weight / total for key, weight in asked.items()} or {COMMON: 1.0}

    def note(self, sight: Sight | None) -> int:
        """Take in where a view was taken, and return that spot; 0 where places do not count.

        What tells whether the place has changed is kept for `update`.
        """
        self._signs, self._pose = Signs(), None if sight is None else sight.T_world_camera
        if self.places is None or sight is None:
            return 0
        if sight.glance is not None:
            self._signs = self._scenery.look(sight.glance)
        with self._lock:
            spot = self.places.add(sight)
            self._arrange(self.places.place_of_spot)
        return spot

    def update(
        self, rows: Rows, is_salient: Labels, spot: int, error: float | None = None
    ) -> Change:
        """Learn from a frame's samples, drawn in random order: its place all, the common some.

        spot: where they were seen from, see `note`.
        error: of the frame before it is learned from; None = nothing in it was salient.
        """
        is_rearranged, self._is_rearranged = self._is_rearranged, False
        place = int(self._place_of_spot[spot]) if self.of_place else COMMON
        forest = self._forest(place)
        alarm = self._note_signs(place, spot, error) if self.is_trained else None
        if alarm is not None:
            self._staleness.begin(alarm, self._forest(alarm.place))
        self._staleness.make_room(place, forest, len(rows))
        regrown = forest.update(rows, is_salient, spot)
        trees = {place: self._staleness.regrow(place, forest, regrown)}
        if place != COMMON:
            some = slice(None, None, round(1 / COMMON_SHARE))
            trees[COMMON] = self.common.update(rows[some], is_salient[some], spot)
        return Change(trees, is_rearranged, alarm)

    def _note_signs(self, place: int, spot: int, error: float | None) -> Alarm | None:
        """Tell whether a place has changed.

        Only at a spot that was seen from before does an error tell: where all is new, errors are
        high anyway, and who goes through a place by short ways has many such looks one after the
        other.
        """
        if self.places is None:
            return None
        told = error if self.places.is_known(spot) else None
        return self._staleness.note(place, self._pose, self._signs, told)

    def _forest(self, place: int) -> Forest:
        return self.common if place == COMMON else self.of_place[place]

    def fit(self, lessons: Sequence[Lesson]) -> None:
        """Forget everything, then learn from views at once: the off-line model."""
        spots, place_of_spot = np.zeros(len(lessons), np.int32), np.zeros(1, np.int64)
        if self.places is not None:
            self.places = places = Places(**self.places.settings())
            spots = np.array([_spot(places, lesson) for lesson in lessons], np.int32)
            places.tell_apart()
            place_of_spot = places.place_of_spot
        rows, is_salient = join_lessons(lessons, self.common.n_features)
        spot_of_row = np.repeat(spots, [len(lesson.rows) for lesson in lessons])
        n_places = int(place_of_spot.max(initial=0)) + 1
        self._place_of_spot = place_of_spot.copy()
        self.of_place = ()
        self._share_out(n_places)
        self.common.fit(rows, is_salient, spot_of_row)
        forests = [self._new_forest(n_places) for _ in range(n_places if n_places > 1 else 0)]
        for place, forest in enumerate(forests):
            here = place_of_spot[spot_of_row] == place
            forest.fit(rows[here], is_salient[here], spot_of_row[here])
        self.of_place = tuple(forests)

    def take_in(self, others: Sequence[tuple[Experts, Numbers]], places: Places | None) -> None:
        """Forget everything, then know what others know.

        A place that one of them knows keeps its trees; where several know it, and everywhere,
        trees are grown anew on the samples of all, before those that are too many leave.

        others: with each (n,) the spots here that its spots are. places: of these spots.
        """
        self.places = places
        place_of_spot = np.zeros(1, np.int64) if places is None else places.place_of_spot
        n_places = int(place_of_spot.max(initial=0)) + 1
        self._place_of_spot = place_of_spot.copy()
        self.of_place = ()
        self._share_out(n_places)
        of_places = [
            _source(forest, spots)
            for experts, spots in others
            for forest in experts.of_place or (experts.common,)
        ]
        common = [_source(experts.common, spots) for experts, spots in others]
        self._grow_on_all(self.common, common if n_places > 1 else of_places)
        self.of_place = tuple(
            self._taken_in(of_places, place) for place in range(n_places if n_places > 1 else 0)
        )

    def _taken_in(self, sources: Sequence[Source], place: int) -> Forest:
        """Return the forest of a place, of all that is known of it."""
        here = [_part(one, self._place_of_spot[one[3]] == place) for one in sources]
        if sum(len(rows) > 0 for _, rows, *_ in here) == 1:
            return self._gather(sources, place)
        forest = self._new_forest(int(self._place_of_spot.max()) + 1)
        self._grow_on_all(forest, here)
        return forest

    def _grow_on_all(self, forest: Forest, sources: Sequence[Source]) -> None:
        """Grow trees on all samples, more than a forest may keep; then those too many leave."""
        rows, is_salient, spots = _joined(sources)
        whole = forest.another(max_samples=max(1, len(rows)), n_regrown=self._n_regrown)
        whole.fit(rows, is_salient, spots)
        forest.restore(whole.state_arrays())
        _evict(forest)

    def _arrange(self, place_of_spot: Numbers) -> None:
        """Let samples follow their spots to other places."""
        before = self._place_of_spot
        self._place_of_spot = place_of_spot.copy()
        n_places = int(place_of_spot.max(initial=0)) + 1
        is_as_before = np.array_equal(place_of_spot[: len(before)], before)
        if is_as_before and n_places == max(1, len(self.of_place)):
            return
        sources = self.of_place or (self.common,)
        # Before the common forest makes room: else a first place would get no more than it keeps.
        samples = [(one, one.rows, one.is_salient, one.groups) for one in sources]
        self._share_out(n_places)
        arrived = range(n_places if n_places > 1 else 0)
        self.of_place = tuple(self._gather(samples, place) for place in arrived)
        self._is_rearranged = True
        self._staleness.move(_origins(before, self._place_of_spot))

    def _gather(self, sources: Iterable[Source], place: int) -> Forest:
        """Return the forest of a place: its samples, and the trees of who had most of them."""
        parts, most, trees_of = [], -1, self.common
        for source, all_rows, all_salient, spots in sources:
            here = self._place_of_spot[spots] == place
            parts.append((all_rows[here], all_salient[here], spots[here]))
            if source.is_trained and np.count_nonzero(here) > most:
                most, trees_of = int(np.count_nonzero(here)), source
        rows, is_salient, groups = (np.concatenate(some) for some in zip(*parts, strict=True))
        forest = self._new_forest(int(self._place_of_spot.max()) + 1)
        samples = {"rows": rows, "is_salient": is_salient, "groups": groups}
        forest.restore(trees_of.state_arrays() | samples)
        _evict(forest)
        return forest

    def _share_out(self, n_places: int) -> None:
        """Divide what may be kept among the forests."""
        common, whole = self.common, self._max_samples
        if n_places == 1:
            common.max_samples, common.n_regrown = whole, self._n_regrown
            return
        common.max_samples, common.n_regrown = max(1, int(COMMON_SHARE * whole)), 1
        _evict(common)

    def _share(self, n_places: int) -> int:
        return max(1, (self._max_samples - self.common.max_samples) // n_places)

    def _new_forest(self, n_places: int) -> Forest:
        """Return an empty forest for one of so many places; all share one source of chance."""
        return self.common.another(max_samples=self._share(n_places), n_regrown=self._n_regrown)

    def settings(self) -> dict[str, int | float | str]:
        """Return those of the forest of everywhere, as it was given."""
        return self.common.settings() | {
            "max_samples": self._max_samples,
            "n_regrown": self._n_regrown,
        }

    def state_arrays(self) -> Arrays:
        """Return the arrays of all forests, those of place 3 after `place3_`, and of the places."""
        with self._lock:
            arrays = self.common.state_arrays()
            for place, forest in enumerate(self.of_place):
                for name, array in forest.state_arrays().items():
                    arrays[f"place{place}_{name}"] = array
            return arrays if self.places is None else arrays | self.places.state_arrays()

    def restore(self, arrays: Arrays) -> None:
        """Take over what `state_arrays` of experts with the same settings returned.

        Raises ValueError if the arrays do not fit.
        """
        known: Numbers = np.zeros(1, np.int64)
        if self.places is not None:
            self.places.restore(arrays)
            known = self.places.place_of_spot.copy()
        n_places = int(known.max(initial=0)) + 1
        self._place_of_spot = known
        self._share_out(n_places)
        self._take_over(self.common, arrays)
        of_place = []
        for place in range(n_places if n_places > 1 else 0):
            prefix = f"place{place}_"
            own = {n.removeprefix(prefix): a for n, a in arrays.items() if n.startswith(prefix)}
            of_place.append(self._new_forest(n_places))
            self._take_over(of_place[-1], own)
        self.of_place = tuple(of_place)

    def _take_over(self, forest: Forest, arrays: Arrays) -> None:
        """Restore a forest whose samples are of spots that there are."""
        forest.restore(arrays)
        if forest.n_samples > forest.max_samples:
            raise ValueError(f"rows: expected {forest.max_samples} at most, got {forest.n_samples}")
        groups, n_spots = forest.groups, len(self._place_of_spot)
        if self.places is not None and not ((groups >= 0) & (groups < max(1, n_spots))).all():
            raise ValueError(f"groups: expected numbers of {n_spots} spots")


def _evict(forest: Forest) -> None:
    """Let go of the samples that are too many."""
    none = np.empty((0, forest.n_features), np.uint8), np.empty(0, np.bool_)
    forest.add(*none)


def _origins(before: Numbers, after: Numbers) -> dict[int, int]:
    """Return of each place the one that most of its spots were of, if they were of any."""
    now = after[: len(before)]
    return {
        place: int(np.bincount(before[now == place]).argmax()) for place in np.unique(now).tolist()
    }


def _spot(places: Places, lesson: Lesson) -> int:
    return 0 if lesson.sight is None else places.add(lesson.sight)


def _source(forest: Forest, spots: Numbers) -> Source:
    """Return a forest with its samples; spots: (n,) what its groups are called elsewhere."""
    return forest, forest.rows, forest.is_salient, spots[forest.groups].astype(np.int32)


def _part(source: Source, here: Labels) -> Source:
    """Return some samples of a source; here: (n,) which."""
    forest, rows, is_salient, spots = source
    return forest, rows[here], is_salient[here], spots[here]


def _joined(sources: Iterable[Source]) -> tuple[Rows, Labels, npt.NDArray[np.int32]]:
    """Return the samples of all sources, one after the other."""
    _, rows, is_salient, spots = zip(*sources, strict=True)
    return np.concatenate(rows), np.concatenate(is_salient), np.concatenate(spots)
