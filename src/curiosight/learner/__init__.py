"""Colour and labels in; a saliency map in [0, 1] out (sec. II-A.1, 3).

A forest over features of superpixels is regrown a little with every frame. Read `learner.py`
first, then `forest.py`; `features/` says what an image is described by.
"""

from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Observation, Teaches

__all__ = ["Forest", "Observation", "SaliencyLearner", "Teaches"]
