"""What is there: things followed over views into entries, and over visits: new, moved, gone.

visit = Visit("kitchen")
for frame in dataset:
    visit.add(frame, teacher.segment(frame), learner.saliency(frame.rgb))
entries = Catalogue().add(visit)
"""

from curiosight.catalogue.catalogue import (
    CHANGES,
    MIN_CONFIDENCE,
    Catalogue,
    Change,
    Entry,
    Sighting,
)
from curiosight.catalogue.detection import Detection, find_detections
from curiosight.catalogue.things import Thing, find_things
from curiosight.catalogue.visit import View, Visit

__all__ = [
    "CHANGES",
    "MIN_CONFIDENCE",
    "Catalogue",
    "Change",
    "Detection",
    "Entry",
    "Sighting",
    "Thing",
    "View",
    "Visit",
    "find_detections",
    "find_things",
]
