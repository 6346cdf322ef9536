"""The forest as a scikit-learn classifier (extra `curiosight[sklearn]`)."""

from __future__ import annotations

from typing import Any, Literal, Self

import numpy as np
import numpy.typing as npt

from curiosight.learner.forest import Forest

try:
    from sklearn.base import BaseEstimator, ClassifierMixin
    from sklearn.utils import Tags, check_random_state
    from sklearn.utils.multiclass import check_classification_targets, type_of_target
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError as error:
    raise ImportError(
        "curiosight.learner.sklearn_estimator needs scikit-learn: pip install 'curiosight[sklearn]'"
    ) from error


Samples = npt.NDArray[np.float64]

N_LEVELS = 256
# Times its share of the samples that a level may hold before the levels are cut anew.
MAX_CROWD = 4
MAX_ID = 2**31  # the forest's groups are int32


class OnlineForestClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Classify two classes with the on-line forest of curiosight.

    Features are cut into 256 levels at the quantiles of what has been seen. With every batch of
    `partial_fit` it is asked whether these still tell the samples apart; where too many different
    values share a level, the levels are cut anew and all trees grow again. For that the samples
    in the buffer are kept as they came too, 8 bytes a number.

    The parameters are those of `curiosight.learner.forest.Forest`; the second of `classes_` is the
    salient one. Both classes weigh the same, so 0.5 means equally typical of both, not equally
    frequent.

    >>> from sklearn.datasets import make_classification
    >>> X, y = make_classification(random_state=0)
    >>> OnlineForestClassifier(random_state=0).fit(X, y).score(X, y) > 0.9
    True
    """

    def __init__(
        self,
        n_trees: int = 30,
        n_regrown: int = 4,
        share: float = 0.7,
        max_samples: int = 100_000,
        max_depth: int = 10,
        min_split: int = 11,
        n_split_features: int | None = None,
        vote: Literal["hard", "soft"] = "soft",
        random_state: int | np.random.RandomState | None = None,
    ) -> None:
        self.n_trees = n_trees
        self.n_regrown = n_regrown
        self.share = share
        self.max_samples = max_samples
        self.max_depth = max_depth
        self.min_split = min_split
        self.n_split_features = n_split_features
        self.vote = vote
        self.random_state = random_state

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> Self:
        """Forget what was learned and grow all trees on (n, F) `X` with (n,) labels `y`."""
        samples, labels = validate_data(self, X, y)
        check_classification_targets(labels)
        self._start(np.unique(labels), type_of_target(labels))
        self._learn(np.asarray(samples, np.float64), self._is_second(labels))
        return self

    def partial_fit(
        self, X: npt.ArrayLike, y: npt.ArrayLike, classes: npt.ArrayLike | None = None
    ) -> Self:
        """Add a batch and regrow some trees; the first batch needs the two `classes`.

        Until the batches have held both, the answer is the first class.
        """
        is_first = not hasattr(self, "forest_")
        samples, labels = validate_data(self, X, y, reset=is_first)
        if is_first:
            if classes is None:
                raise ValueError("classes: expected both labels in the first call, got None")
            self._start(np.unique(classes), type_of_target(classes))
        unknown = np.setdiff1d(labels, self.classes_)
        if unknown.size:
            raise ValueError(f"y: expected labels of {self.classes_}, got {unknown}")
        self._learn(np.asarray(samples, np.float64), self._is_second(labels))
        return self

    def predict_proba(self, X: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return (n, n_classes) class shares of (n, F) `X`."""
        check_is_fitted(self)
        samples = validate_data(self, X, reset=False)
        if self.classes_.size == 1:
            return np.ones((len(samples), 1))
        share = self.forest_.predict(self._bin(samples)).astype(np.float64)
        return np.column_stack([1 - share, share])

    def predict(self, X: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the (n,) likelier labels of (n, F) `X`."""
        check_is_fitted(self)
        labels: npt.NDArray[Any] = self.classes_[self.predict_proba(X).argmax(axis=1)]
        return labels

    def _start(self, classes: npt.NDArray[Any], kind: str) -> None:
        """Make an empty forest for these classes, that has no levels yet."""
        if classes.size > 2:
            raise ValueError(
                f"Only binary classification is supported. The type of the target is {kind}."
            )
        self.classes_ = classes
        # One level for all: the first batch finds it crowded, or has nothing to tell apart.
        self.thresholds_ = np.empty((self.n_features_in_, 0))
        self._samples = np.empty((0, self.n_features_in_))
        self._n_seen = 0
        self.forest_ = Forest(
            n_features=self.n_features_in_,
            n_trees=self.n_trees,
            n_regrown=self.n_regrown,
            share=self.share,
            max_samples=self.max_samples,
            max_depth=self.max_depth,
            min_split=self.min_split,
            n_split_features=self.n_split_features,
            vote=self.vote,
            seed=int(check_random_state(self.random_state).randint(2**31)),
        )

    def _learn(self, samples: Samples, is_second: npt.NDArray[np.bool_]) -> None:
        """Add samples (n, F) to the forest, with new levels where the old ones do not fit."""
        ids = (self._n_seen + np.arange(len(samples))) % MAX_ID
        self._n_seen += len(samples)
        kept = self.forest_.groups, self.forest_.is_salient
        all_ids = np.concatenate([kept[0], ids]).astype(np.int32)
        together = np.concatenate([self._samples, samples])
        if self._are_crowded(together):
            self.thresholds_ = np.quantile(
                together, np.linspace(0, 1, N_LEVELS + 1)[1:-1], axis=0
            ).T
            are_second = np.concatenate([kept[1], is_second])
            self.forest_.fit(self._bin(together), are_second, all_ids)
        else:
            self.forest_.update(self._bin(samples), is_second, all_ids[len(kept[0]) :])
        # The forest sorts and evicts; by its groups we know what is where.
        order = np.argsort(all_ids)
        places = order[np.searchsorted(all_ids, self.forest_.groups, sorter=order)]
        self._samples = together[places]

    def _are_crowded(self, samples: Samples) -> bool:
        """Tell whether a level holds far more different values than its share of the samples.

        Only values above the level's lower end count: many equal ones have a level for themselves,
        which no other levels could part. New levels are never crowded.
        """
        most = max(MAX_CROWD, MAX_CROWD * len(samples) / N_LEVELS)
        for values, thresholds in zip(samples.T, self.thresholds_, strict=True):
            levels = np.searchsorted(thresholds, values, side="right")
            ends = np.concatenate([[-np.inf], thresholds])
            if np.bincount(levels[values > ends[levels]], minlength=1).max() > most:
                return True
        return False

    def _bin(self, samples: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
        """Return the level, 0 to 255, of each feature."""
        rows = np.empty(samples.shape, np.uint8)
        for feature, thresholds in enumerate(self.thresholds_):
            rows[:, feature] = np.searchsorted(thresholds, samples[:, feature], side="right")
        return rows

    def _is_second(self, labels: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        return np.asarray(labels == self.classes_[-1], np.bool_)

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.classifier_tags.multi_class = False
        return tags
