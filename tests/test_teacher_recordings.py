"""The teacher against ground truth on real recordings, where they are at hand."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from curiosight import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.components import survey_dataset
from curiosight.frame import Label
from curiosight.teacher import Teacher

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The benchmark defines how a teacher is scored."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    return importlib.import_module("teacher")


def test_recall_leaves_out_what_the_image_cuts(benchmark: ModuleType) -> None:
    truth = np.zeros((60, 80), np.uint8)
    truth[20:30, 5:25] = 255  # touches the frame
    truth[20:30, 40:60] = 255
    truth[40:50, 40:60] = 125
    labels = np.full_like(truth, Label.UNKNOWN)
    labels[20:30, 50:70] = Label.SALIENT
    labels[40:50, 40:60] = Label.SALIENT
    labels[50:] = Label.NOT_SALIENT
    counts = benchmark.teacher_counts(labels, truth)
    assert counts.recall == 100 / 200
    assert counts.precision == 100 / 200
    assert counts.coverage == (200 + 800) / (60 * 80 - 200)


def test_counts_add_up(benchmark: ModuleType) -> None:
    truth = np.zeros((60, 80), np.uint8)
    truth[20:30, 40:60] = 255
    none = benchmark.teacher_counts(np.full_like(truth, Label.UNKNOWN), truth)
    all_of_it = benchmark.teacher_counts(np.full_like(truth, Label.SALIENT), truth)
    assert np.isnan(none.precision)
    assert none.recall == 0
    assert (none + all_of_it).recall == 0.5


@pytest.mark.skipif(
    "CURIOSIGHT_TEST_DATA" not in os.environ, reason="CURIOSIGHT_TEST_DATA is not set"
)
@pytest.mark.parametrize(
    ("name", "least_precision", "least_recall"),
    [("redkitchen", 0.90, 0.68), ("osd_learn", 0.995, 0.94)],
)
def test_teacher_on_a_real_recording(
    benchmark: ModuleType, name: str, least_precision: float, least_recall: float
) -> None:
    dataset = open_dataset(Path(os.environ["CURIOSIGHT_TEST_DATA"]) / "data" / name)
    teacher = Teacher(survey_dataset(load_config(), dataset))
    total = benchmark.TeacherCounts()
    with_truth = [index for index in range(len(dataset)) if dataset.has_ground_truth(index)]
    for index in with_truth[::2]:
        labels = teacher.segment(dataset[index]).labels
        total += benchmark.teacher_counts(labels, dataset.ground_truth(index))
    assert total.precision > least_precision
    assert total.recall > least_recall
