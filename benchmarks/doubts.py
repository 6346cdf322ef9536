"""Give recordings one fault each, and see which `find_doubts` names and which it invents.

    python benchmarks/doubts.py RECORDING… [--half NAME] [--code registration]

RECORDING: a folder, or a room such as room:11,views=12. Faults are made in memory: depth in a
wrong unit, as read or as stored, rotated bits, poses of the wrong kind, depth that is moved or
scaled beside colour. Prints a table and keeps it in benchmarks/results/doubts.json under the
name of the half. With --code only faults that this doubt should name, and none, are tried.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from curiosight.datasets import Dataset
from curiosight.datasets.doubts import Doubt, find_doubts
from curiosight.frame import Depth, Frame, Pose
from curiosight.worlds import open_source

RESULTS = Path(__file__).parent / "results" / "doubts.json"
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])
TURN = np.diag([1.0, -1.0, -1.0, 1.0])
USUAL_SCALE = 0.001


@dataclass(frozen=True)
class Fault:
    """What is done to a recording, and the doubt that should say so (None: no doubt)."""

    name: str
    code: str | None
    factor: float | None = None
    scale: float = 1.0
    stored: Callable[[Any], Any] = lambda units: units
    pose: Callable[[Pose], Pose] | None = None
    move: Callable[[Any], Any] = lambda units: units

    def is_named(self, doubts: Sequence[Doubt]) -> bool:
        """Tell whether the doubts are just the right one."""
        if self.code is None:
            return not doubts
        if [doubt.code for doubt in doubts] != [self.code]:
            return False
        factor = doubts[0].factor
        return self.factor is None or (factor is not None and bool(np.isclose(factor, self.factor)))


def rotated(units: Any) -> Any:
    """Rotate 16 bits to the left by three."""
    return (units << 3 | units >> 13) & 0xFFFF


def moved(factor: float) -> Callable[[Pose], Pose]:
    """Return what multiplies positions."""
    return lambda pose: np.block([[pose[:3, :3], factor * pose[:3, 3:]], [pose[3:]]])


def beside(right: float = 0, down: float = 0, scale: float = 1) -> Callable[[Any], Any]:
    """Return what scales a depth image about its middle and moves it by pixels of 640 columns."""

    def moved_image(units: Any) -> Any:
        height, width = units.shape
        middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
        u = middle_u * (1 - scale) + right * width / 640
        v = middle_v * (1 - scale) + down * width / 640
        matrix = np.array([[scale, 0, u], [0, scale, v]])
        image = units.astype(np.float32)  # exact up to 16 million
        moved = cv2.warpAffine(image, matrix, (width, height), flags=cv2.INTER_NEAREST)
        return moved.astype(np.int64)

    return moved_image


FAULTS = (
    Fault("right", None),
    Fault("unit × 5", "unit", 0.2, scale=5),
    Fault("unit ÷ 5", "unit", 5, scale=0.2),
    Fault("unit × 10", "unit", 0.1, scale=10),
    Fault("unit ÷ 10", "unit", 10, scale=0.1),
    Fault("unit × 1000", "unit", 0.001, scale=1000),
    Fault("unit ÷ 1000", "unit", 1000, scale=0.001),
    Fault("stored × 5", "unit", 0.2, stored=lambda units: 5 * units),
    Fault("stored ÷ 5", "unit", 5, stored=lambda units: np.rint(units / 5).astype(np.int64)),
    Fault("bits rotated", "bits", stored=rotated),
    Fault("poses inverted", "poses-inverted", pose=np.linalg.inv),
    Fault("poses mirrored", "poses-mirrored", pose=lambda pose: MIRROR @ pose @ MIRROR),
    Fault("determinant -1", "poses-mirrored", pose=lambda pose: pose @ MIRROR),
    Fault("camera axes of OpenGL", "poses-axes", pose=lambda pose: pose @ TURN),
    Fault("positions × 1000", "poses-unit", 0.001, pose=moved(1000)),
    Fault("8 pixels right", "registration", move=beside(right=8)),
    Fault("12 pixels left", "registration", move=beside(right=-12, down=3)),
    Fault("20 pixels down", "registration", move=beside(down=20)),
    Fault("scaled by 1.1", "registration", move=beside(scale=1.1)),
    Fault("scaled by 1 / 1.1", "registration", move=beside(scale=1 / 1.1)),
)


class Faulty:
    """A recording with a fault."""

    def __init__(self, dataset: Dataset, fault: Fault, look: Callable[[int], Frame]) -> None:
        self.dataset, self.fault, self.look = dataset, fault, look
        self.name, self.ids, self.camera = dataset.name, dataset.ids, dataset.camera
        self.has_depth, self.remarks = dataset.has_depth, dataset.remarks
        self.unit = getattr(dataset, "depth_scale", USUAL_SCALE)
        self.depth_scale = self.unit * fault.scale
        turn = fault.pose or (lambda pose: pose)
        self.poses = [None if pose is None else turn(pose) for pose in dataset.poses]

    def __len__(self) -> int:
        return len(self.dataset)

    def __getitem__(self, index: int) -> Frame:
        frame = self.look(index)
        return replace(frame, depth=self.spoilt(frame.depth), T_world_camera=self.poses[index])

    def spoilt(self, depth: Depth | None) -> Depth | None:
        """Return depth as a file with the fault would be read."""
        if depth is None:
            return None
        units = self.fault.stored(np.rint(np.nan_to_num(depth / self.unit)).astype(np.int64))
        units = self.fault.move(units)
        is_reading = (units > 0) & (units < 65535)
        return np.where(is_reading, units * self.depth_scale, np.nan).astype(np.float32)

    def has_ground_truth(self, index: int) -> bool:
        return False

    def ground_truth(self, index: int) -> None:
        return None


def main() -> None:
    """Try all faults on all recordings and keep what came out."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--half", default="all")
    parser.add_argument("--code", choices=sorted({fault.code for fault in FAULTS if fault.code}))
    arguments = parser.parse_args()
    faults = [fault for fault in FAULTS if arguments.code in (None, fault.code) or not fault.code]
    table: dict[str, Any] = {}
    for name in arguments.recordings:
        dataset = open_source(name)
        has_poses = any(pose is not None for pose in dataset.poses)
        find_doubts(dataset)  # compiles
        start = time.perf_counter()
        find_doubts(dataset)
        look = lru_cache(maxsize=64)(dataset.__getitem__)
        row: dict[str, Any] = {"seconds": round(time.perf_counter() - start, 2)}
        for fault in faults:
            if fault.pose is None or has_poses:
                doubts = find_doubts(Faulty(dataset, fault, look))
                said = [[doubt.code, doubt.factor, doubt.fix] for doubt in doubts]
                row[fault.name] = {"named": fault.is_named(doubts), "doubts": said}
        label = name if ":" in name else "/".join(Path(name).parts[-2:])
        table[label] = row
        missed = [key for key, cell in row.items() if key != "seconds" and not cell["named"]]
        print(f"{label:40s} {row['seconds']:5.2f} s  {'missed: ' if missed else ''}{missed or ''}")
    for fault in faults:
        cells = [row[fault.name]["named"] for row in table.values() if fault.name in row]
        print(f"{fault.name:24s} {sum(cells):3d} of {len(cells)}")
    kept = json.loads(RESULTS.read_text("utf-8")) if RESULTS.is_file() else {}
    RESULTS.write_text(json.dumps(kept | {arguments.half: table}, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
