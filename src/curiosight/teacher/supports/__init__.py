"""Points and planes in; what things stand on out: the floor, tables, and their tops.

What a whole recording tells of them is a `Survey` (`surveyed.py`). Read `supports.py` first.
"""
