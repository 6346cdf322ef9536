"""Time `segment` beside what else cuts depth into planes and clusters, in the same run.

    python benchmarks/teacher_peers.py RECORDING… [--frames 20]

Peers, on the same frames and points within 4 m. One thread is asked for, but Open3D takes more
where cores are free, so the ratios that count are those of processor time:
- Open3D's usual recipe: 1-cm voxels, RANSAC planes until none is large, DBSCAN;
- scikit-learn's DBSCAN on the points that Open3D's planes leave;
- OpenCV 5: points, normals and `findPlanes` (planes only, nothing is clustered).
What is not installed is left out, and the result says so: `pip install open3d` is 400 MB.
Prints a table, keeps benchmarks/results/teacher-peers.json.
"""

from __future__ import annotations

import os

# Before the libraries are loaded: afterwards they do not look at it any more.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}

import argparse
import importlib
import json
import platform
from collections import defaultdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import curiosight as cs
from curiosight.datasets import Dataset
from curiosight.experiments.components import make_teacher
from curiosight.experiments.timing import StageTimes, one_thread, processor
from curiosight.worlds.sources import open_source

RESULTS = Path(__file__).parent / "results" / "teacher-peers.json"
MAX_RANGE = 4.0
VOXEL = 0.01
PLANE_BAND = 0.015
N_HYPOTHESES = 1000
MIN_PLANE_SHARE = 0.10  # of the voxels; below that a plane may be an object's side
MAX_PLANES = 6
CLUSTER_GAP = 0.03
MIN_CLUSTER = 10

Times = defaultdict[str, StageTimes]


def time_ours(teacher: cs.Teacher, frame: cs.Frame, times: Times) -> None:
    """Time the whole of our segmentation."""
    times["curiosight segment"].run(lambda: teacher.segment(frame))


def time_opencv(frame: cs.Frame, times: Times) -> None:
    """Time OpenCV's points, normals and planes."""
    assert frame.depth is not None
    assert frame.camera is not None
    camera, depth = frame.camera, np.where(frame.depth <= MAX_RANGE, frame.depth, np.nan)
    intrinsics = np.array(
        [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]], np.float32
    )
    normals_of = cv2.RgbdNormals.create(
        camera.height,
        camera.width,
        cv2.CV_32F,
        intrinsics,
        5,
        50,
        cv2.RgbdNormals_RGBD_NORMALS_METHOD_FALS,
    )

    def planes() -> None:
        points = cv2.depthTo3d(depth, intrinsics)
        normals = normals_of.apply(points)
        cv2.findPlanes(points, normals, block_size=40, threshold=PLANE_BAND)

    times["OpenCV normals + findPlanes (planes only)"].run(planes)


def time_open3d(open3d: Any, frame: cs.Frame, times: Times) -> Any:
    """Time Open3D's recipe; return the (n, 3) points that its planes leave."""
    points = points_of(frame)

    def planes_removed() -> Any:
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
        cloud = cloud.voxel_down_sample(VOXEL)
        n_voxels = len(cloud.points)
        for _ in range(MAX_PLANES):
            if len(cloud.points) < 3:
                break
            _, inliers = cloud.segment_plane(PLANE_BAND, 3, N_HYPOTHESES)
            if len(inliers) < MIN_PLANE_SHARE * n_voxels:
                break
            cloud = cloud.select_by_index(inliers, invert=True)
        return cloud

    cloud = times["Open3D voxels + planes"].run(planes_removed)
    times["Open3D DBSCAN"].run(lambda: cloud.cluster_dbscan(CLUSTER_GAP, MIN_CLUSTER))
    return np.asarray(cloud.points)


def time_scikit_learn(cluster: Any, left: Any, times: Times) -> None:
    """Time scikit-learn's clustering of what is on no plane."""
    dbscan = cluster.DBSCAN(eps=CLUSTER_GAP, min_samples=MIN_CLUSTER, n_jobs=1)
    if len(left):
        times["scikit-learn DBSCAN (after Open3D's planes)"].run(lambda: dbscan.fit_predict(left))


def points_of(frame: cs.Frame) -> Any:
    """Return the points within range, (n, 3) float64 metres."""
    assert frame.depth is not None
    assert frame.camera is not None
    v, u = np.nonzero(frame.depth <= MAX_RANGE)
    z = frame.depth[v, u].astype(np.float64)
    camera = frame.camera
    return np.column_stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z])


def time_recording(dataset: Dataset, n_frames: int, modules: dict[str, Any]) -> dict[str, Any]:
    """Time everything that is installed on evenly spaced frames, after a warm-up on the first."""
    teacher = make_teacher(cs.load_config(), dataset)
    indices = np.linspace(0, len(dataset) - 1, min(n_frames, len(dataset))).round().astype(int)
    warm_up: Times = defaultdict(StageTimes)
    kept: Times = defaultdict(StageTimes)
    for place, index in enumerate([indices[0], *indices]):
        times, frame = kept if place else warm_up, dataset[int(index)]
        time_ours(teacher, frame, times)
        if hasattr(cv2, "findPlanes"):
            time_opencv(frame, times)
        if modules["open3d"] is not None:
            left = time_open3d(modules["open3d"], frame, times)
            if modules["sklearn.cluster"] is not None:
                time_scikit_learn(modules["sklearn.cluster"], left, times)
    figures = {name: one.summary() for name, one in kept.items()}
    if modules["open3d"] is not None:
        recipe = StageTimes()
        parts = [kept["Open3D voxels + planes"], kept["Open3D DBSCAN"]]
        recipe.wall_ms = np.sum([part.wall_ms for part in parts], axis=0).tolist()
        recipe.processor_ms = np.sum([part.processor_ms for part in parts], axis=0).tolist()
        figures["Open3D, the whole recipe"] = recipe.summary()
    ours = figures["curiosight segment"]
    for one in figures.values():
        one["ratio"] = round(one["median_ms"] / ours["median_ms"], 2)
        one["processor_ratio"] = round(one["processor_median_ms"] / ours["processor_median_ms"], 2)
    return figures


def installed(name: str) -> Any | None:
    """Return a module, None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def main() -> None:
    """Time, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sources", nargs="+", help="recordings with depth, or room:SEED")
    parser.add_argument("--frames", type=int, default=20)
    arguments = parser.parse_args()
    modules = {name: installed(name) for name in ("open3d", "sklearn.cluster")}
    results: dict[str, Any] = {
        "threads": "1 asked for; Open3D takes more where cores are free: compare processor times",
        "processor": processor(),
        "python": platform.python_version(),
        "opencv": cv2.__version__,
        "open3d": getattr(modules["open3d"], "__version__", "not installed"),
        "scikit-learn": getattr(installed("sklearn"), "__version__", "not installed"),
        "frames": arguments.frames,
        "sources": {},
    }
    with one_thread():
        for source in arguments.sources:
            figures = time_recording(open_source(source), arguments.frames, modules)
            results["sources"][Path(source).name] = figures
            print(source)
            for name, one in figures.items():
                print(
                    f"  {name:44} {one['median_ms']:8.1f} ms, p90 {one['p90_ms']:8.1f}, "
                    f"processor {one['processor_median_ms']:8.1f}, "
                    f"{one['processor_ratio']:6.1f} x ours"
                )
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
