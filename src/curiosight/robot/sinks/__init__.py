"""What a watch tells, handed on: to a log file (`mcap_log.py`), to a viewer (`rerun_view.py`).

In: a `Watch`. Out: `Moment`s, by a `Recorder`, to each `Sink`.
"""
