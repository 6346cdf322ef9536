"""Depth in; labels out as the paper makes them (sec. II-A.2), each frame alone.

Read `paper_teacher.py` first.
"""
