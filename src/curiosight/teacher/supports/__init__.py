"""`Points` in, `Supports` out: what things stand on, the floor and tables, and their tops.

Read `footing.py` first, the second stage. What a whole recording tells of supports is a `Survey`
(`surveyed.py`).
"""
