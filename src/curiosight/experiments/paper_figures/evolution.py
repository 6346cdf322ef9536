"""How the map of one view becomes what it is, while the source is learned in its order (fig. 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
import numpy.typing as npt

from curiosight.datasets import KnowsInstances
from curiosight.evaluation import MapScores
from curiosight.evaluation.baselines import Saliency
from curiosight.experiments.contest.running import Run
from curiosight.experiments.paper_figures.subject import Subject
from curiosight.frame import Frame, Label
from curiosight.learner.description import Labels
from curiosight.rooms.drawn_views import DrawnViews

# A thing counts as seen from this share of the image on, and is worth to be followed from that.
SEEN_SHARE, FOLLOWED_SHARE = 0.005, 0.02
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class LateThing:
    """What the view shows that comes late: its pixels, and the look that shows it first.

    first_look: number, from 1.
    """

    mask: Mask
    first_look: int


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """The view whose map is followed; late: None where things cannot be told apart."""

    frame: Frame
    labels: Labels
    late: LateThing | None


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """A map after so many looks.

    error: 1 - F1 of the view; None where nothing of it is salient. on_late, elsewhere: mean
    score of the late thing, and of what is not salient; None without one.
    """

    looks: int
    saliency: Saliency
    error: float | None
    on_late: float | None
    elsewhere: float | None


def choose_target(subject: Subject) -> Target:
    """Return the test view with the thing that is seen last, else that which shows most things."""
    seen = _first_looks(subject)
    best, most = None, -1.0
    for index, frame, labels in subject.labelled():
        late = _late_thing(subject, index, labels, seen) if seen is not None else None
        interest = float((labels == Label.SALIENT).mean()) if late is None else late.first_look
        if interest > most:
            best, most = Target(frame, labels, late), interest
    assert best is not None  # a source without a usable test frame is not prepared
    return best


def evolve(subject: Subject, target: Target) -> Iterator[Snapshot | None]:
    """Look at all views in their order; yield a snapshot where one is due, else None."""
    config = subject.config
    explorer = replace(config.explorer, strategy="chronological")
    run = Run(subject.prepared, replace(config, explorer=explorer), config.run.seed)
    n_looks = len(subject.prepared.ids)
    due = _due(n_looks, target.late)
    for row in run.looks(n_looks):
        if row.look not in due:
            yield None
            continue
        frame, learner = target.frame, run.learner
        saliency = learner.saliency(frame.rgb, frame.T_world_camera)
        scores = MapScores(threshold=learner.threshold)
        scores.add(frame.id, saliency, target.labels)
        error = scores.frames[0][1]["all"].error
        on_late = elsewhere = None
        if target.late is not None:
            on_late = float(saliency[target.late.mask].mean())
            elsewhere = float(saliency[target.labels == Label.NOT_SALIENT].mean())
        yield Snapshot(row.look, saliency, error, on_late, elsewhere)


def _due(n_looks: int, late: LateThing | None) -> set[int]:
    """Return after which looks the map is shown: 1, 2, 5, 10, …, and before a thing is seen."""
    steps = (factor * 10**power for power in count() for factor in (1, 2, 5))
    due = {n_looks}
    for step in steps:
        if step >= n_looks:
            break
        due.add(step)
    if late is not None and late.first_look > 1:
        due.add(late.first_look - 1)
    return due


def _first_looks(subject: Subject) -> dict[int, int] | None:
    """Return by which look each thing is seen first; None where that is not known."""
    dataset = subject.dataset
    if not isinstance(dataset, DrawnViews) or len(subject.prepared.phases) > 1:
        return None
    first: dict[int, int] = {}
    for index in range(len(dataset)):
        for thing in _things(dataset, index, SEEN_SHARE):
            first.setdefault(thing, index + 1)
    return first


def _things(dataset: KnowsInstances, index: int, share: float) -> list[int]:
    instances = dataset.instance_truth(index)
    if instances is None:
        return []
    numbers, counts = np.unique(instances, return_counts=True)
    is_seen = (numbers > 0) & (counts >= share * instances.size)
    return [int(number) for number in numbers[is_seen]]


def _late_thing(
    subject: Subject, index: int, labels: Labels, first: dict[int, int]
) -> LateThing | None:
    """Return the thing of a test view that the looks show last; one that none shows is none."""
    tests = subject.truth.dataset
    assert isinstance(tests, DrawnViews)
    known = [thing for thing in _things(tests, index, FOLLOWED_SHARE) if thing in first]
    if not known:
        return None
    latest = max(known, key=lambda thing: first[thing])
    mask = (tests.instance_truth(index) == latest) & (labels == Label.SALIENT)
    return LateThing(mask, first[latest]) if mask.any() else None
