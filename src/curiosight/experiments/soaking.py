"""Look for weeks in some hours: does memory grow, and what is written?"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.dataset import GroundTruth
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Frame, Pose

# Frames that are looked at, and how large they are at most.
N_FRAMES, MOST_PX = 64, 80
# After each round of so many looks the world is so much farther: space without end.
STEP_METRES = 0.5
# Memory is compared with what it is after so many looks, or a tenth of all.
N_WARM_UP = 5_000
# So many readings of it are kept, evenly spread.
N_READINGS = 100


class SmallFrames:
    """Some frames of another dataset, shrunk and kept in memory; a `Dataset` without truth."""

    has_depth = True
    remarks: tuple[str, ...] = ()

    def __init__(self, dataset: Dataset) -> None:
        chosen = np.linspace(0, len(dataset) - 1, min(N_FRAMES, len(dataset))).round()
        found = [dataset[index] for index in dict.fromkeys(chosen.astype(int).tolist())]
        self._frames = [_shrunk(frame) for frame in found if frame.problem is None]
        if not any(frame.depth is not None for frame in self._frames):
            raise ValueError("source: expected frames with depth, got none that can be used")
        self.name, self.path = dataset.name, getattr(dataset, "path", dataset.name)
        self.ids: Sequence[str] = [frame.id for frame in self._frames]
        self.poses: Sequence[Pose | None] = [frame.T_world_camera for frame in self._frames]
        self.camera = self._frames[0].camera

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: int) -> Frame:
        return self._frames[index]

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> GroundTruth | None:
        return None


def _shrunk(frame: Frame) -> Frame:
    height, width = frame.rgb.shape[:2]
    share = min(1.0, MOST_PX / max(height, width))
    size = max(1, round(share * width)), max(1, round(share * height))
    depth, camera = frame.depth, frame.camera
    return replace(
        frame,
        rgb=cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA),
        depth=None if depth is None else cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST),
        camera=None if camera is None else scaled_camera(camera, size),
    )


class Soak:
    """Explore small frames for so many looks, in ever new space, and watch memory.

    It is `explore` itself, with all that it writes. out: where it does.
    readings: looks done and resident megabytes then.
    """

    def __init__(self, config: Config, dataset: Dataset, out: OutputFolder, n_looks: int) -> None:
        if n_looks < 10:
            raise ValueError(f"soak: expected 10 looks or more, got {n_looks}")
        explorer = replace(config.explorer, n_steps=n_looks)
        self.n_looks, self.n_done = n_looks, 0
        self.readings: list[tuple[int, float]] = []
        self._frames = SmallFrames(dataset)
        self._out = out
        self._run = Exploration(replace(config, explorer=explorer), self._frames, out)
        self._capture = self._run.world.capture
        self._run.world.capture = self._elsewhere  # type: ignore[method-assign]
        self._every = max(1, n_looks // N_READINGS)
        self._started = time.perf_counter()

    def __iter__(self) -> Iterator[int]:
        """Yield the number of looks after each."""
        for _ in self._run:
            self.n_done += 1
            if self.n_done % self._every == 0 or self.n_done == self._warm_up:
                self.readings.append((self.n_done, resident_mb()))
            yield self.n_done
        self._run.finish()

    @property
    def _warm_up(self) -> int:
        return min(N_WARM_UP, self.n_looks // 10)

    def _elsewhere(self) -> Frame:
        """Return what is seen; of each round at another place of the world."""
        frame, pose = self._capture(), None
        if frame.T_world_camera is not None:
            pose = frame.T_world_camera.copy()
            pose[0, 3] += STEP_METRES * (self.n_done // len(self._frames))
        return replace(frame, T_world_camera=pose)

    def figures(self) -> dict[str, Any]:
        """Return what was measured, JSON-able.

        deviation: of the resident memory since the first looks, as a share of what it was then.
        """
        seconds = time.perf_counter() - self._started
        after = [mb for look, mb in self.readings if look >= self._warm_up]
        files = {path.name: path.stat().st_size for path in _files(self._out.path)}
        height, width = self._frames[0].rgb.shape[:2]
        return {
            "looks": self.n_done,
            "image": f"{width}x{height}",
            "ms_a_look": round(1000 * seconds / max(1, self.n_done), 3),
            "resident_mb": [[look, round(mb, 1)] for look, mb in self.readings],
            "deviation": max((abs(mb / after[0] - 1) for mb in after), default=None),
            "bytes": files,
            "bytes_a_look": {
                name: round(size / max(1, self.n_done), 1)
                for name, size in files.items()
                if name.endswith(".csv")
            },
        }


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_file()) if folder.is_dir() else []


def resident_mb() -> float:
    """Return the megabytes of memory that this process has now; its peak where none can tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except (OSError, ValueError, IndexError):
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    return pages * resource.getpagesize() / (1 << 20)
