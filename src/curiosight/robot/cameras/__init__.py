"""Cameras as live sources: each is a `Device` that a `CameraFeed` asks, read `camera.py` first.

What drives a camera is imported when one is opened, and is an extra of ours.
"""
