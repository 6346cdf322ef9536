"""How good a model is, against ground truth or the teacher (sec. III)."""

from curiosight.evaluation.held_out import HeldOut
from curiosight.evaluation.map_scores import PARTS, FrameScore, MapScores
from curiosight.evaluation.split import SplitKind, every_nth, make_folds

__all__ = [
    "PARTS",
    "FrameScore",
    "HeldOut",
    "MapScores",
    "SplitKind",
    "every_nth",
    "make_folds",
]
