"""Score the teacher on images of several sizes of the same views.

    python benchmarks/sizes.py SOURCE… [--sizes 160x120 640x480 …] [--views N] [--sheet DIR]

SOURCE: a folder, or rooms such as room:21 or room:21,sensor=lidar. A room is rendered anew at each
size, its sensor with it. A recording's images are resampled: smaller ones hold every so many
pixels, larger ones each reading many times, as depth does that was brought to colour's size.
Prints a table; with --name it is added to benchmarks/results/sizes.json.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from teacher import write_sheet

from curiosight import load_config, make_teacher
from curiosight.datasets import Dataset
from curiosight.datasets.cameras.camera_file import scaled_camera
from curiosight.datasets.sizes import fit_to
from curiosight.evaluation import TeacherCounts, score_frame
from curiosight.frame import Camera, Frame
from curiosight.rooms.views import RoomViews
from curiosight.worlds import open_source

RESULTS = Path(__file__).parent / "results" / "sizes.json"
SIZES = ("160x120", "320x240", "640x480", "1280x720", "1920x1440", "3840x2160")
# A Kinect's noise grows with the square of the distance: the teacher is judged up to here.
KINECT_RANGE = 3.5
# Objects that touch this frame count as cut, in pixels of an image with 640 columns.
BORDER_PX = 10


class Resized:
    """A `Dataset` whose images have another size; the shape of a room's may be another, too.

    size: width, height. views: evenly spaced frames with truth; None = all.
    """

    name = "resized"
    has_depth = True

    def __init__(self, source: Dataset, size: tuple[int, int], views: int | None) -> None:
        self.source, self.path = source, f"{getattr(source, 'path', source.name)} at {size}"
        with_truth = [row for row in range(len(source)) if source.has_ground_truth(row)]
        n_views = min(views or len(with_truth), len(with_truth))
        chosen = np.linspace(0, len(with_truth) - 1, n_views).astype(int)
        self._rows = [with_truth[place] for place in chosen]
        self.ids = tuple(source.ids[row] for row in self._rows)
        assert source.camera is not None
        self.camera = _camera_of(source.camera, size)

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: int) -> Frame:
        return self.look(index)[0]

    def has_ground_truth(self, index: int) -> bool:
        return True

    def ground_truth(self, index: int) -> npt.NDArray[np.uint8]:
        return self.look(index)[1]

    def look(self, index: int) -> tuple[Frame, npt.NDArray[np.uint8], npt.NDArray[np.bool_]]:
        """Return a frame, its (H, W) truth, and which of it counts."""
        row, size = self._rows[index], (self.camera.width, self.camera.height)
        if isinstance(self.source, RoomViews):
            views = self.source
            rng = views.looks_stream(row)
            look = views.look_from(views.poses[row], views.ids[row], rng, camera=self.camera)
            is_kinect = views.room.settings.sensor == "kinect"
            return look.frame, look.truth, look.true_depth <= (KINECT_RANGE if is_kinect else 99)
        frame, truth = self.source[row], self.source.ground_truth(row)
        assert frame.depth is not None
        assert truth is not None
        rgb, depth, truth = (fit_to(image, size) for image in (frame.rgb, frame.depth, truth))
        frame = replace(frame, rgb=rgb, depth=depth, camera=self.camera)
        return frame, truth, np.ones(truth.shape, np.bool_)


def _camera_of(camera: Camera, size: tuple[int, int]) -> Camera:
    """Return the camera with as wide a view; of another shape it sees less above and below."""
    width, height = size
    as_wide = scaled_camera(camera, (width, round(camera.height * width / camera.width)))
    if as_wide.height == height:
        return as_wide
    return replace(
        as_wide, height=height, cy=as_wide.cy - (as_wide.height - height) / 2, depth_window=None
    )


def score(dataset: Resized, sheets: Path | None) -> dict[str, Any]:
    """Return the figures of one size; the milliseconds are the median of the processor's time."""
    teacher = make_teacher(load_config(), dataset)
    border_px = round(BORDER_PX * dataset.camera.width / 640)
    total, times_ms, n_objects = TeacherCounts(), [], 0
    teacher.segment(dataset[0])
    for index, id in enumerate(dataset.ids):
        frame, truth, counted = dataset.look(index)
        start = time.process_time()
        segmentation = teacher.segment(frame)
        times_ms.append(1000 * (time.process_time() - start))
        scored = score_frame(frame, segmentation, truth, counted=counted, border_px=border_px)
        total += scored.counts
        n_objects += len(segmentation.objects)
        if sheets:
            name = f"{dataset.camera.width}-{id.replace('/', '_')}.png"
            write_sheet(sheets / name, frame, truth, segmentation)
    return {"counts": total, "n_objects": n_objects, "times_ms": times_ms, "frames": len(dataset)}


def _figures(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of several sources together."""
    total = sum((part["counts"] for part in parts), TeacherCounts())
    return {
        "frames": sum(part["frames"] for part in parts),
        "precision": round(total.precision, 4),
        "recall": round(total.recall, 4),
        "coverage": round(total.coverage, 4),
        "objects": sum(part["n_objects"] for part in parts),
        "ms": round(float(np.median(np.concatenate([part["times_ms"] for part in parts]))), 1),
    }


def rows(
    sources: list[Dataset], sizes: list[tuple[int, int]], views: int | None, sheets: Path | None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each size and the figures of all sources at it."""
    for size in sizes:
        parts = []
        for place, source in enumerate(sources):
            folder = None if sheets is None else sheets / str(place)
            resized: Dataset = source
            if not isinstance(source, RoomViews) and source.camera is not None:
                own = source.camera.width, source.camera.height
                # A recording keeps its shape.
                size_of = (size[0], round(own[1] * size[0] / own[0]))
                resized = Resized(source, size_of, views)
            else:
                resized = Resized(source, size, views)
            parts.append(score(resized, folder))
        yield "x".join(str(side) for side in size), _figures(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sources", nargs="+", help="recordings or rooms, scored together")
    parser.add_argument("--sizes", nargs="+", default=SIZES, help="WIDTHxHEIGHT")
    parser.add_argument("--views", type=int, help="so many evenly spaced frames of each; else all")
    parser.add_argument("--sheet", type=Path, help="write a picture a frame into this folder")
    parser.add_argument("--name", help="under which the table is kept; else it is only printed")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    sizes = [tuple(int(side) for side in size.split("x")) for size in arguments.sizes]
    sources = [open_source(source) for source in arguments.sources]
    table = {}
    for size, figures in rows(sources, sizes, arguments.views, arguments.sheet):
        table[size] = figures
        print(f"{size:10}", *(f"{name} {figure}" for name, figure in figures.items()), flush=True)
    if arguments.name:
        kept = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
        names = [source.rstrip("/").rsplit("/", 1)[-1] for source in arguments.sources]
        kept[arguments.name] = {"sources": names, "sizes": table}
        RESULTS.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
