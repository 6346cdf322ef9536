"""Depth in; points with normals, planes, walls as data, and which way is up out.

Nothing here knows what a table or an object is. Read `points.py` first, then `planes.py`.
"""
