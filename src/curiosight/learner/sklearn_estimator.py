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


class OnlineForestClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Classify two classes with the on-line forest of curiosight.

    Features are cut into 256 levels at the quantiles of the first batch. The parameters are
    those of `curiosight.learner.forest.Forest`; the second of `classes_` is the salient one. Both
    classes weigh the same, so 0.5 means equally typical of both, not equally frequent.

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
        self._start(samples, np.unique(labels), type_of_target(labels))
        self.forest_.fit(self._bin(samples), self._is_second(labels))
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
            self._start(samples, np.unique(classes), type_of_target(classes))
        unknown = np.setdiff1d(labels, self.classes_)
        if unknown.size:
            raise ValueError(f"y: expected labels of {self.classes_}, got {unknown}")
        self.forest_.update(self._bin(samples), self._is_second(labels))
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

    def _start(self, samples: npt.NDArray[Any], classes: npt.NDArray[Any], kind: str) -> None:
        """Make an empty forest for these classes and the levels for features like these."""
        if classes.size > 2:
            raise ValueError(
                f"Only binary classification is supported. The type of the target is {kind}."
            )
        self.classes_ = classes
        self.thresholds_ = np.quantile(samples, np.linspace(0, 1, 257)[1:-1], axis=0).T
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
