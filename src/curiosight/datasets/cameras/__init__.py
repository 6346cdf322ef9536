"""Files of intrinsics in; cameras out, ours and those of others, and depth registered to colour.

Read `calibration.py` first.
"""
