"""How good a model and its teacher are, against ground truth or each other (sec. III)."""

from curiosight.evaluation.held_out import HeldOut
from curiosight.evaluation.instances import InstanceScore, instance_table, score_instances
from curiosight.evaluation.map_scores import PARTS, FrameScore, MapScores
from curiosight.evaluation.split import SplitKind, every_nth, make_folds
from curiosight.evaluation.teacher_counts import (
    TeacherCounts,
    missed_by_reason,
    teacher_counts,
    whole_objects,
)
from curiosight.evaluation.teacher_scores import ScoredFrame, TeacherScores, score_frame

__all__ = [
    "PARTS",
    "FrameScore",
    "HeldOut",
    "InstanceScore",
    "MapScores",
    "ScoredFrame",
    "SplitKind",
    "TeacherCounts",
    "TeacherScores",
    "every_nth",
    "instance_table",
    "make_folds",
    "missed_by_reason",
    "score_frame",
    "score_instances",
    "teacher_counts",
    "whole_objects",
]
