"""How good a model and its teacher are, against ground truth or each other (sec. III)."""

from curiosight.evaluation.bootstrap import Interval, bootstrap_interval
from curiosight.evaluation.held_out import HeldOut, TestView, describe_tests
from curiosight.evaluation.instances import InstanceScore, instance_table, score_instances
from curiosight.evaluation.map_scores import PARTS, FrameScore, MapScores
from curiosight.evaluation.method_scores import MethodScores
from curiosight.evaluation.object_metrics import ObjectScore, score_objects
from curiosight.evaluation.object_scores import MEASURES, ObjectScores
from curiosight.evaluation.object_truth import ObjectTruth
from curiosight.evaluation.reliability import Reliability
from curiosight.evaluation.score_histograms import (
    average_precision,
    precision_recall,
    roc_auc,
    score_histogram,
)
from curiosight.evaluation.split import SplitKind, away_from, every_nth, make_folds
from curiosight.evaluation.teacher_counts import (
    TeacherCounts,
    missed_by_reason,
    teacher_counts,
    whole_objects,
)
from curiosight.evaluation.teacher_scores import ScoredFrame, TeacherScores, score_frame
from curiosight.metrics import f1_error_of_rows

__all__ = [
    "MEASURES",
    "PARTS",
    "FrameScore",
    "HeldOut",
    "InstanceScore",
    "Interval",
    "MapScores",
    "MethodScores",
    "ObjectScore",
    "ObjectScores",
    "ObjectTruth",
    "Reliability",
    "ScoredFrame",
    "SplitKind",
    "TeacherCounts",
    "TeacherScores",
    "TestView",
    "average_precision",
    "away_from",
    "bootstrap_interval",
    "describe_tests",
    "every_nth",
    "f1_error_of_rows",
    "instance_table",
    "make_folds",
    "missed_by_reason",
    "precision_recall",
    "roc_auc",
    "score_frame",
    "score_histogram",
    "score_instances",
    "score_objects",
    "teacher_counts",
    "whole_objects",
]
