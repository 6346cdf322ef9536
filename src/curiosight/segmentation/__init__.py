"""The teacher's depth segmentation: salient, not salient, unknown (sec. II-A.2)."""

from curiosight.segmentation.paper_settings import PaperSettings, PaperSupport
from curiosight.segmentation.paper_teacher import PaperTeacher
from curiosight.segmentation.segmented import REASONS, Segmentation
from curiosight.segmentation.settings import FLOOR, TABLE, SegmentationSettings, SupportSettings
from curiosight.segmentation.survey import SCENES, Survey, survey_recording
from curiosight.segmentation.teacher import Teacher
from curiosight.segmentation.temporal import TemporalTeacher
from curiosight.segmentation.verdicts import Cluster, Verdict

__all__ = [
    "FLOOR",
    "REASONS",
    "SCENES",
    "TABLE",
    "Cluster",
    "PaperSettings",
    "PaperSupport",
    "PaperTeacher",
    "Segmentation",
    "SegmentationSettings",
    "SupportSettings",
    "Survey",
    "Teacher",
    "TemporalTeacher",
    "Verdict",
    "survey_recording",
]
