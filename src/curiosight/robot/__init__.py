"""On a robot: frames come in live, maps of them go out at once, learning takes what time is left.

In: a `Feed` of frames (a recording or drive that is replayed; a camera). Out: the `Watch`, and the
page that shows it (`Shown`, `page/`). Read `watch.py` first, then `feed.py`.
"""
