"""Frames with poses in; what several views tell together out: a survey, votes on voxels.

Read `survey.py` first, then `temporal.py`.
"""
