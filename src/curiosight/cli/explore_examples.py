"""Choose what a report shows of an exploration: views, and what was said of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from curiosight.datasets import Dataset
from curiosight.datasets.dataset import GroundTruth
from curiosight.errors import DataError, printable
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.steps import StepRow
from curiosight.learner.observation import Teaches
from curiosight.rooms import DrawnViews
from curiosight.viewing.examples import Example

N_TAUGHT, N_TEST_EXAMPLES = 4, 3


def taught_examples(run: Exploration) -> list[Example]:
    """Return the latest look of every quarter of a run, each frame once, beside what it says now.

    Only looks that show something salient count. They are looked at again.
    """
    chosen = _latest_of_quarters(run.rows, run.config.explorer.n_steps)
    view_of = {printable(run.dataset.ids[view.index]): view.index for view in run.world.views}
    return [_example_of(run, view_of[row.id], row.step) for row in chosen]


def _latest_of_quarters(rows: Sequence[StepRow], n_steps: int) -> list[StepRow]:
    chosen: list[StepRow] = []
    for row in rows:
        if row.error is None:
            continue
        quarter = row.step * N_TAUGHT // n_steps
        others = [kept for kept in chosen if kept.step * N_TAUGHT // n_steps != quarter]
        if all(kept.id != row.id for kept in others):
            chosen = [*others, row]
    return chosen


def _example_of(run: Exploration, view: int, step: int) -> Example:
    frame = run.world.look_again(view, step)
    return Example(
        frame.id,
        frame.rgb,
        run.segment_again(frame),
        run.learner.saliency(frame.rgb, frame.T_world_camera),
        _ground_truth(run.dataset, view),
    )


def unseen_examples(run: Exploration) -> Iterator[Example]:
    """Yield a few of the test frames, evenly spread, those that can be read."""
    indices = run.tests.truth.indices
    n_shown = min(N_TEST_EXAMPLES, len(indices))
    teacher = _teacher_of_tests(run)
    for number in range(n_shown):
        index = indices[(2 * number + 1) * len(indices) // (2 * n_shown)]
        frame = run.tests.truth.dataset[index]
        if frame.problem is None:
            yield Example(
                frame.id,
                frame.rgb,
                None if teacher is None else teacher.segment(frame),
                run.learner.saliency(frame.rgb, frame.T_world_camera),
                _ground_truth(run.tests.truth.dataset, index),
            )


def _teacher_of_tests(run: Exploration) -> Teaches | None:
    """Return who can say what depth shows of a test frame; None where its place is unknown."""
    if run.tests.truth.teacher is not None:
        return run.tests.truth.teacher
    explored, tested = run.dataset, run.tests.truth.dataset
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
