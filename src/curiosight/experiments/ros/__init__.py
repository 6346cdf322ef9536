"""The ROS 2 node: what holds rclpy, imported at use. `node.py` first.

What it says and does is decided in `robot/ros/`, and what comes in is read by `datasets/topics/`,
both without ROS.
"""
