"""Score the teacher against ground truth: precision, recall, coverage, time.

    python benchmarks/teacher.py DATA [--every K] [--sheet DIR]

The frames' first half is for tuning, the second for reporting; both are printed. `curiosight
score-teacher` says more, and counts in the same way.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.evaluation import TeacherCounts, teacher_counts
from curiosight.experiments.components import survey_dataset
from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation, Teacher, Verdict

Labels = npt.NDArray[np.uint8]

COLOUR_OF_LABEL = {Label.NOT_SALIENT: (60, 60, 160), Label.UNAVAILABLE: (0, 0, 0)}
COLOUR_OF_VERDICT = {
    Verdict.OBJECT: (255, 255, 255),
    Verdict.CUT: (230, 200, 40),
    Verdict.FAR: (120, 120, 120),
    Verdict.SMALL: (255, 140, 0),
    Verdict.LARGE: (0, 200, 200),
    Verdict.HIGH: (0, 130, 160),
    Verdict.FLAT: (200, 80, 200),
    Verdict.FLOATING: (220, 40, 40),
    Verdict.FURNITURE: (240, 130, 110),
    Verdict.WALL_PART: (120, 40, 160),
}
COLOUR_OF_UNKNOWN = (150, 150, 110)


def segment_timed(
    teacher: Teacher, frames: Iterator[Frame]
) -> Iterator[tuple[Segmentation, float]]:
    """Segment frames, with the milliseconds that each took; the first is done twice."""
    for place, frame in enumerate(frames):
        if place == 0:
            teacher.segment(frame)
        start = time.perf_counter()
        segmentation = teacher.segment(frame)
        yield segmentation, 1000 * (time.perf_counter() - start)


def paint(segmentation: Segmentation) -> npt.NDArray[np.uint8]:
    """(H, W, 3) RGB: the labels, and for unknown clusters the reason."""
    picture = np.full((*segmentation.labels.shape, 3), COLOUR_OF_UNKNOWN, np.uint8)
    for label, colour in COLOUR_OF_LABEL.items():
        picture[segmentation.labels == label] = colour
    for number, cluster in enumerate(segmentation.clusters, start=1):
        picture[segmentation.cluster_of_pixel == number] = COLOUR_OF_VERDICT[cluster.verdict]
    return picture


def write_sheet(
    path: Path, frame: Frame, ground_truth: Labels | None, segmentation: Segmentation
) -> None:
    """Write colour, ground truth and verdicts side by side."""
    truth = np.full(frame.rgb.shape[:2], 125, np.uint8) if ground_truth is None else ground_truth
    panels = [frame.rgb, np.dstack([truth] * 3), paint(segmentation)]
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.hstack(panels)[::2, ::2, ::-1])


def report(name: str, counts: list[TeacherCounts]) -> None:
    """Print one line of scores for a part of the frames."""
    total = sum(counts, TeacherCounts())
    print(
        f"{name:9} {len(counts):4} frames  precision {total.precision:.4f}  "
        f"recall {total.recall:.4f}  coverage {total.coverage:.4f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="a recording")
    parser.add_argument("--every", type=int, default=1, help="use every K-th frame (with truth)")
    parser.add_argument("--sheet", type=Path, help="write a picture a frame into this folder")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)

    dataset = open_dataset(arguments.data)
    config = load_config()
    found = survey_dataset(config, dataset)
    print(f"{dataset.name}: scene {found.scene}, up {found.up_world}, floor {found.floor_height}")
    indices = [index for index in range(len(dataset)) if dataset.has_ground_truth(index)]
    indices = (indices or list(range(len(dataset))))[:: arguments.every]
    counts: list[TeacherCounts] = []
    verdicts: Counter[str] = Counter()
    times_ms: list[float] = []
    teacher = Teacher(found, config.segmentation)
    results = segment_timed(teacher, (dataset[index] for index in indices))
    for index, (segmentation, time_ms) in zip(indices, results, strict=True):
        truth = dataset.ground_truth(index)
        if truth is not None:
            counts.append(teacher_counts(segmentation.labels, truth))
        times_ms.append(time_ms)
        verdicts.update(cluster.verdict.value for cluster in segmentation.clusters)
        verdicts["(frame without a support)"] += segmentation.problem is not None
        if arguments.sheet:
            path = arguments.sheet / f"{dataset.ids[index].replace('/', '_')}.png"
            write_sheet(path, dataset[index], truth, segmentation)
    if counts:
        half = len(counts) // 2
        report("tuning", counts[:half])
        report("reporting", counts[half:])
        report("all", counts)
    median, p90 = np.percentile(times_ms, (50, 90))
    print(f"one thread: median {median:.1f} ms, p90 {p90:.1f} ms over {len(times_ms)} frames")
    print("; ".join(f"{name} {count}" for name, count in verdicts.most_common() if count))


if __name__ == "__main__":
    main()
