"""Depth in, `Points` out: points, local planes, and where the view ends.

Read `view.py` first, the first stage; `points.py` has the value, `up.py` which way is up.
"""
