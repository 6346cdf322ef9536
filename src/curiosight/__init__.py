"""Teach a camera to see the objects of its own rooms: no labels, no GPU.

Depth shows what an object is; from that a forest learns, live, how such things look; then it
finds them in plain RGB. And it decides by itself where to look next: where it learns fastest.
Implements and goes beyond Craye, Filliat and Goudou, "Environment Exploration for Object-Based
Visual Saliency Learning", ICRA 2016, which docstrings cite as eq. and sec.
"""

from curiosight.config import load_config
from curiosight.datasets import check_dataset, open_dataset
from curiosight.errors import DataError
from curiosight.experiments.components import make_learner, make_teacher
from curiosight.explore import explore
from curiosight.explorer import check_strategy, make_regions, make_strategy
from curiosight.frame import Camera, Frame, Label, Viewpoint
from curiosight.learner.learner import SaliencyLearner
from curiosight.teacher import Teacher
from curiosight.worlds import ReplayWorld, check_world

__version__ = "0.1.0"

__all__ = [
    "Camera",
    "DataError",
    "Frame",
    "Label",
    "ReplayWorld",
    "SaliencyLearner",
    "Teacher",
    "Viewpoint",
    "check_dataset",
    "check_strategy",
    "check_world",
    "explore",
    "load_config",
    "make_learner",
    "make_regions",
    "make_strategy",
    "make_teacher",
    "open_dataset",
]
