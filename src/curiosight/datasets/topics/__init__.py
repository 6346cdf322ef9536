"""ROS messages as they come, turned into frames: paired by stamp, decoded, located by tf.

Without ROS: whatever has the fields of the messages will do. `frames.py` first.
"""
