"""Choose what a report shows of an exploration: views, and what was said of them."""

from __future__ import annotations

from collections.abc import Iterator

from curiosight.datasets import Dataset
from curiosight.datasets.dataset import GroundTruth
from curiosight.errors import DataError
from curiosight.experiments.exploring import Exploration
from curiosight.explore import Step
from curiosight.learner.observation import Teaches
from curiosight.rooms import DrawnViews
from curiosight.viewing.examples import Example

N_TEST_EXAMPLES = 3


def example_of(run: Exploration, step: Step) -> Example:
    """Return what was seen in a step, beside what the model says now."""
    frame = step.observation.frame
    return Example(
        frame.id,
        frame.rgb,
        step.observation.segmentation,
        run.learner.saliency(frame.rgb, frame.T_world_camera),
        _ground_truth(run.dataset, step.viewpoint.index),
    )


def unseen_examples(run: Exploration) -> Iterator[Example]:
    """Yield a few of the test frames, evenly spread, those that can be read."""
    indices = run.truth.indices
    n_shown = min(N_TEST_EXAMPLES, len(indices))
    teacher = _teacher_of_tests(run)
    for number in range(n_shown):
        index = indices[(2 * number + 1) * len(indices) // (2 * n_shown)]
        frame = run.truth.dataset[index]
        if frame.problem is None:
            yield Example(
                frame.id,
                frame.rgb,
                None if teacher is None else teacher.segment(frame),
                run.learner.saliency(frame.rgb, frame.T_world_camera),
                _ground_truth(run.truth.dataset, index),
            )


def _teacher_of_tests(run: Exploration) -> Teaches | None:
    """Return who can say what depth shows of a test frame; None where its place is unknown."""
    if run.truth.teacher is not None:
        return run.truth.teacher
    explored, tested = run.dataset, run.truth.dataset
    if not (isinstance(explored, DrawnViews) and isinstance(tested, DrawnViews)):
        return None
    # Whatever was moved in it: the survey is of walls and furniture.
    return run.teacher if explored.is_place_of(tested) else None


def _ground_truth(dataset: Dataset, index: int) -> GroundTruth | None:
    """Return a frame's ground truth; None where there is none, or it is damaged."""
    try:
        return dataset.ground_truth(index)
    except DataError:
        return None
