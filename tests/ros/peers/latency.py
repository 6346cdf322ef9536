"""Hear saliency as rclpy does: prints the ages of maps, milliseconds, as JSON when it ends.

latency.py SECONDS
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("latency")
    ages: list[float] = []
    times: list[float] = []

    def hear(message: Any) -> None:
        now = time.time_ns()
        stamp = message.header.stamp
        ages.append((now - stamp.sec * 10**9 - stamp.nanosec) / 1e6)
        times.append(now / 1e9)

    node.create_subscription(Image, "/curiosight/saliency", hear, qos_profile_sensor_data)
    until = time.monotonic() + float(sys.argv[1])
    while time.monotonic() < until:
        rclpy.spin_once(node, timeout_sec=0.5)
    known = ages[len(ages) // 5 :]
    told = {"n": len(ages), "p50": None, "p99": None, "hz": None}
    if known:
        told |= {"p50": float(np.percentile(known, 50)), "p99": float(np.percentile(known, 99))}
        told["hz"] = len(times) / max(1e-9, times[-1] - times[0])
    print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
