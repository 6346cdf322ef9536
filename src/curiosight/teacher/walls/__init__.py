"""Points in; upright planes that end nothing but the room out, with their openings.

Read `walls.py` first; `faces.py` fits one.
"""
