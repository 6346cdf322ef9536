"""What a ROS 2 node says and does, without ROS: plain values in and out.

Boxes of a map (`detections.py`), squares of the floor and how well they are known (`squares.py`),
where a robot may go (`goals.py`), when to stop (`falling.py`), what is missing (`missing.py`), and
the exploring itself (`exploring.py`).
"""
