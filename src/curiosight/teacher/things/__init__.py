"""`Surroundings` in, `Things` out: clusters on the supports, each with its verdict.

Read `objects.py` first, the fourth stage; `verdicts.py` says what is an object.
"""
