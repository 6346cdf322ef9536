"""ROS bags, read without ROS: files are scanned by ours, messages decoded by rosbags.

In comes a file or folder, out go topics and the bytes of their messages (`bag.Bag`), which the
layout `RosBag` makes frames of. Read `bag.py` first.
"""
