"""`Supports` in, `Surroundings` out: upright planes that end nothing but the room are added.

Read `surroundings.py` first, the third stage; `walls.py` finds walls, `faces.py` fits one.
"""
