"""One model of two that learned in the same home."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from curiosight.learner.calibration import Calibration
from curiosight.learner.experts import Experts
from curiosight.learner.forest import Forest
from curiosight.learner.joining import join_places
from curiosight.learner.learner import SaliencyLearner

# What two models must have in common, beside their features, forests and places.
SAME = ("n_pixels", "blind_share", "salient_share", "follow_edges", "edge_stride", "threshold")


def merge_learners(
    one: SaliencyLearner, other: SaliencyLearner, *, n_threads: int = 1
) -> SaliencyLearner:
    """Return a model that knows what two know; which comes first does not matter.

    Places that are one by poses, or by looks, are one; the samples of both are kept as far as
    `max_samples` of the forest lets. What one of them knows alone it keeps as it knew it; trees of
    what both know are grown anew. Raises ValueError for models with other settings.
    """
    check_mergeable(one, other)
    first, second = sorted((one, other), key=fingerprint)
    merged = _empty_like(first, n_threads)
    places, spots = None, np.zeros(1, np.int64)
    if first.experts.places is not None and second.experts.places is not None:
        places, spots = join_places(first.experts.places, second.experts.places)
    own = np.arange(len(places.place_of_spot)) if places is not None else np.zeros(1, np.int64)
    merged.experts.take_in([(first.experts, own), (second.experts, spots)], places)
    for known in (first, second):
        merged.cameras.note_all(known.cameras)
    if first.calibration is not None and second.calibration is not None:
        merged.calibration = _calibrated(first.calibration, second.calibration)
    merged.notes = {"frames": _learned_from(first, second)}
    return merged


def check_mergeable(one: SaliencyLearner, other: SaliencyLearner) -> None:
    """Raise ValueError where two models cannot become one."""
    for name, mine, theirs in (
        ("features", one.describer.definition(), other.describer.definition()),
        ("forest", one.experts.settings(), other.experts.settings()),
        ("places", _place_settings(one.experts), _place_settings(other.experts)),
        ("calibration", one.calibration is not None, other.calibration is not None),
        *((name, getattr(one, name), getattr(other, name)) for name in SAME),
    ):
        if mine != theirs:
            found = f"got {theirs!s:.200}"
            raise ValueError(f"{name}: expected that of the first model, {mine!s:.200}, {found}")


def fingerprint(learner: SaliencyLearner) -> str:
    """Return what tells a model from every other: a hash of what it has learned."""
    digest, arrays = hashlib.sha256(), learner.experts.state_arrays()
    if learner.calibration is not None:
        arrays |= learner.calibration.state_arrays()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _empty_like(learner: SaliencyLearner, n_threads: int) -> SaliencyLearner:
    settings: dict[str, Any] = learner.experts.settings()
    rng = np.random.default_rng(0)
    return SaliencyLearner(
        None,
        Forest(**settings, seed=rng, n_threads=n_threads),
        **learner.describer.settings(),
        **{name: getattr(learner, name) for name in SAME},
        is_calibrated=learner.calibration is not None,
        seed=rng,
    )


def _calibrated(one: Calibration, other: Calibration) -> Calibration:
    """Return what the scores of both mean, each view counting as it did."""
    merged = Calibration()
    merged.counts = one.counts + other.counts
    merged.n_frames = one.n_frames + other.n_frames
    return merged


def _learned_from(*learners: SaliencyLearner) -> dict[str, list[str]]:
    """Return the frames that models have learned from, by their recording."""
    frames: dict[str, set[str]] = {}
    for learner in learners:
        for source, ids in learner.notes.get("frames", {}).items():
            frames.setdefault(source, set()).update(ids)
    return {source: sorted(frames[source]) for source in sorted(frames)}


def _place_settings(experts: Experts) -> dict[str, int] | None:
    return None if experts.places is None else experts.places.settings()


def merge_all(learners: Sequence[SaliencyLearner], *, n_threads: int = 1) -> SaliencyLearner:
    """Return one model of two or more, see `merge_learners`; their order does not matter."""
    if len(learners) < 2:
        raise ValueError(f"learners: expected at least two, got {len(learners)}")
    first, *others = sorted(learners, key=fingerprint)
    for other in others:
        first = merge_learners(first, other, n_threads=n_threads)
    return first
