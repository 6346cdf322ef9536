"""Measure what the first run on a machine pays: all kernels compiled into an empty cache.

python benchmarks/compile_time.py
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile

PROBE = """
import time
import numpy as np
from numba.core import event
import curiosight as cs
from curiosight.datasets.cameras.registration import register_depth
from curiosight.datasets.layouts.seven_scenes import COLOUR_CAMERA, DEPTH_CAMERA
from curiosight.worlds import open_source

spent = {}
class Listener(event.Listener):
    depth = 0
    def on_start(self, e):
        Listener.depth += 1
        if Listener.depth == 1:
            self.start = time.perf_counter()
    def on_end(self, e):
        Listener.depth -= 1
        if Listener.depth == 0:
            name = e.data["dispatcher"].py_func.__name__
            spent[name] = spent.get(name, 0) + time.perf_counter() - self.start

rng = np.random.default_rng(0)
depth = np.full((480, 640), 1.5, np.float32)
depth += rng.normal(0, 0.001, depth.shape).astype(np.float32)
rgb = rng.integers(0, 255, (480, 640, 3), np.uint8)
frame = cs.Frame("0", rgb, depth, COLOUR_CAMERA)
with event.install_listener("numba:compile", Listener()):
    register_depth(depth, DEPTH_CAMERA, COLOUR_CAMERA, np.eye(4))
    for preset in ("default", "paper"):
        learner = cs.make_learner(cs.load_config(preset), cs.Teacher())
        learner.observe(frame)
        description = learner.describe(rgb)
        labels = np.zeros(description.row_of_pixel.shape, np.uint8)
        labels[:, ::2] = 255
        learner.learn(description, labels)
        learner.predict(description)
    open_source("room:0,views=1,blur=yes")[0]
for name, seconds in sorted(spent.items(), key=lambda item: -item[1]):
    print(f"{seconds:6.2f} s  {name}")
print(f"{sum(spent.values()):6.2f} s  all {len(spent)} kernels")
"""


def main() -> None:
    """Run the probe in a process of its own with an empty cache."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        subprocess.run([sys.executable, "-c", PROBE], env=environment, check=True)


if __name__ == "__main__":
    main()
