"""Depth in; salient, not salient or unknown for every pixel out (sec. II-A.2).

A depth image goes down one staircase: `cloud`, `supports`, `walls`, `things`, labels. Read
`teacher.py` first; `given.py` has the teachers that read somebody else's labels.
"""

from curiosight.teacher.given import CallTeacher
from curiosight.teacher.memory.survey import SCENES, survey_recording
from curiosight.teacher.memory.temporal import TemporalTeacher
from curiosight.teacher.paper.paper_settings import PaperSettings, PaperSupport
from curiosight.teacher.paper.paper_teacher import PaperTeacher
from curiosight.teacher.segmented import REASONS, Segmentation
from curiosight.teacher.settings import FLOOR, TABLE, SegmentationSettings, SupportSettings
from curiosight.teacher.supports.surveyed import Survey
from curiosight.teacher.teacher import Teacher
from curiosight.teacher.things.verdicts import Cluster, Verdict

__all__ = [
    "FLOOR",
    "REASONS",
    "SCENES",
    "TABLE",
    "CallTeacher",
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
