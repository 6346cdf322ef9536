"""What a model's file says of the learner that wrote it, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from curiosight.errors import DataError
from curiosight.learner.archive import find_model, read_archive, write_archive
from curiosight.learner.calibration import Calibration
from curiosight.learner.experts import Experts
from curiosight.learner.features import Describer, FeatureSet, missing_sets
from curiosight.learner.forest import Forest
from curiosight.learner.maps import Cameras
from curiosight.learner.places import Places

KIND = "saliency model"
# What a header makes of us that is one by its checksum, but not by what it says.
NONSENSE = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError)


class Model(Protocol):
    """What a file keeps of a learner, see `SaliencyLearner`."""

    describer: Describer
    experts: Experts
    calibration: Calibration | None
    cameras: Cameras
    notes: dict[str, Any]
    n_pixels: int
    blind_share: float
    salient_share: float
    follow_edges: bool
    edge_stride: int
    threshold: float


Learner = TypeVar("Learner", bound=Model)


def write_model(learner: Model, path: Path, *, is_packed: bool) -> None:
    """Write a learner with its samples; raises what `write_archive` does."""
    header: dict[str, Any] = {
        "features": learner.describer.definition(),
        "n_pixels": learner.n_pixels,
        "blind_share": learner.blind_share,
        "follow_edges": learner.follow_edges,
        "threshold": learner.threshold,
        "forest": learner.experts.settings(),
        "notes": learner.notes,
    }
    # Without these the header is that of version 0.1.
    if learner.edge_stride > 1:
        header["edge_stride"] = learner.edge_stride
    if learner.salient_share:
        header["salient_share"] = learner.salient_share
    if learner.experts.places is not None:
        header["places"] = learner.experts.places.settings()
    if cameras := learner.cameras.tables():
        header["cameras"] = cameras
    arrays = learner.experts.state_arrays()
    if learner.calibration is not None:
        arrays |= learner.calibration.state_arrays()
    write_archive(path, KIND, header, arrays, is_packed=is_packed)


def read_model(
    make: Callable[..., Learner],
    path: Path | str,
    own: tuple[FeatureSet, ...],
    rng: np.random.Generator,
    n_threads: int,
) -> Learner:
    """Return the learner of a file or of a run's folder; `DataError` where there is none.

    make: the learner, from its forest and settings.
    own: sets of features that are not ours, which the model may have been made with.
    """
    path = find_model(path)
    header, arrays = read_archive(path, KIND)
    try:
        said = header["features"]
        if missing := missing_sets(said, own):
            found = f"was made with other features: {', '.join(missing)}"
            raise DataError(path, found, "give them: SaliencyLearner.load(path, features=[…])")
        forest = Forest(**header["forest"], seed=rng, n_threads=n_threads)
        settings = _settings(header, own) | {"is_calibrated": "calibration" in arrays}
        learner = make(forest, **settings, seed=rng)
        learner.experts.restore(arrays)
        if learner.calibration is not None:
            learner.calibration.restore(arrays)
        if not isinstance(header["notes"], dict):
            raise ValueError(f"notes: expected a table, got {header['notes']!r:.60}")
        learner.notes = header["notes"]
        learner.cameras = Cameras.of_tables(header.get("cameras", ()))
    except NONSENSE as error:
        raise DataError(path, f"holds no usable model ({error})", "learn it anew") from error
    if said != learner.describer.definition():
        raise DataError(path, "was made with other features", "learn it anew")
    return learner


def _settings(header: dict[str, Any], own: Iterable[FeatureSet]) -> dict[str, Any]:
    """Return what a learner is made with, by its header; version 0.1 did not know all of it."""
    describer, places = Describer.of_definition(header["features"], own), header.get("places")
    return {
        **describer.settings(),
        "n_pixels": header["n_pixels"],
        "blind_share": header["blind_share"],
        "follow_edges": header["follow_edges"],
        "edge_stride": header.get("edge_stride", 1),
        "salient_share": header.get("salient_share", 0.0),
        "threshold": header["threshold"],
        "places": None if places is None else Places(**places),
    }
