"""Points above a support in; clusters with a verdict each out: object, cut, part of a wall.

Read `objects.py` first; what is an object is decided in `verdicts.py` and nowhere else.
"""
