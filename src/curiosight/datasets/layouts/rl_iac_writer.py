"""Write RL-IAC folders, for the program of the paper's authors."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.datasets.cameras.camera_file import FILE_NAME
from curiosight.datasets.dataset import Dataset
from curiosight.datasets.depth_files import MILLIMETRES
from curiosight.datasets.layouts.rl_iac import IMAGE_FOLDER
from curiosight.datasets.layouts.rl_iac_tables import (
    GRAPH_FILE,
    REGION_FILE,
    GraphNode,
    file_name,
    format_graph,
    format_regions,
)
from curiosight.datasets.prefetch import Prefetch
from curiosight.errors import DataError
from curiosight.errors.files import replace_file, writing
from curiosight.frame import Camera, Depth, Frame

# 65535 is no reading to those who read such depth.
MAX_MILLIMETRES = 65534


class RlIacWriter:
    """Write frames of a recording, one by one; `write_rl_iac` writes all of them.

    indices: the frames to write, None = all. regions: of every frame of the recording, -1 = in
    none, so not written; None = all in region 0. graph: a node a region, or none at all.
    Raises ValueError for a recording without depth, ids that would be the same file, and
    regions that the graph lacks.
    """

    def __init__(
        self,
        dataset: Dataset,
        folder: Path,
        *,
        indices: Sequence[int] | None = None,
        regions: Sequence[int] | None = None,
        graph: Sequence[GraphNode] = (),
    ) -> None:
        if dataset.camera is None:
            raise ValueError(f"dataset: expected one with depth, got {dataset.name}")
        self.folder = folder
        self._dataset = dataset
        self._camera = dataset.camera
        self._graph = tuple(graph)
        self._regions = [0] * len(dataset) if regions is None else list(map(int, regions))
        self._check_regions()
        wanted = range(len(dataset)) if indices is None else indices
        self.indices = tuple(index for index in wanted if self._regions[index] >= 0)
        self._names = _file_names([dataset.ids[index] for index in self.indices])
        self._region_of_file: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self.indices)

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame once it is written; one that has a problem is not written."""
        with writing(self.folder):
            (self.folder / IMAGE_FOLDER).mkdir(parents=True, exist_ok=True)
        with Prefetch(self._dataset) as frames:
            decoded = frames.in_order(self.indices)
            for index, name, frame in zip(self.indices, self._names, decoded, strict=True):
                yield self._write(index, name, frame)

    def finish(self) -> int:
        """Write the tables for the frames written so far; return how many these are."""
        text = format_regions(self._region_of_file)
        replace_file(self.folder / REGION_FILE, text.encode())
        if self._graph:
            replace_file(self.folder / GRAPH_FILE, format_graph(self._graph).encode())
        replace_file(self.folder / FILE_NAME, _camera_json(self._camera).encode())
        return len(self._region_of_file)

    def _check_regions(self) -> None:
        n_frames, n_given = len(self._dataset), len(self._regions)
        if n_given != n_frames:
            raise ValueError(f"regions: expected {n_frames}, one a frame, got {n_given}")
        last = max(self._regions, default=0)
        if self._graph and last >= len(self._graph):
            raise ValueError(f"graph: expected a node for region {last}, got {len(self._graph)}")

    def _write(self, index: int, name: str, frame: Frame) -> Frame:
        """Write the images of a frame and return it, with what was wrong with it."""
        if frame.problem is not None:
            return frame
        try:
            truth = self._dataset.ground_truth(index)
        except DataError as error:
            return replace(frame, problem=f"ground truth: {error.found}")
        images = self.folder / IMAGE_FOLDER
        _write_png(images / f"{name}.png", cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR))
        assert frame.depth is not None
        _write_png(images / f"{name}_depth.png", _millimetres(frame.depth))
        if truth is not None:
            _write_png(images / f"{name}_GT.png", truth)
        self._region_of_file[f"{IMAGE_FOLDER}/{name}.png"] = self._regions[index]
        return frame


def write_rl_iac(
    dataset: Dataset,
    folder: Path,
    *,
    indices: Sequence[int] | None = None,
    regions: Sequence[int] | None = None,
    graph: Sequence[GraphNode] = (),
) -> int:
    """Write a recording as an RL-IAC folder; return how many frames were fit to be written.

    Its `image_data` holds x.png, x_depth.png in millimetres and, where there is ground truth,
    x_GT.png (255 salient, 0 not, 125 ignored). Poses have no place in it; intrinsics stand in
    camera.json, which the authors' program does not read. In that program's parameters
    [inputPath] is the folder itself. The arguments are those of `RlIacWriter`.
    """
    writer = RlIacWriter(dataset, folder, indices=indices, regions=regions, graph=graph)
    for _ in writer:
        pass
    return writer.finish()


def _file_names(ids: Sequence[str]) -> list[str]:
    """Make names of ids that the authors' program keeps apart from its endings and tables."""
    names = [file_name(id) for id in ids]
    if len(set(names)) < len(names):
        raise ValueError("dataset: expected ids that differ in letters, digits, '_', '.' and '-'")
    return names


def _millimetres(depth: Depth) -> npt.NDArray[np.uint16]:
    """Return whole millimetres, 0 = no reading or beyond what 16 bits hold."""
    units = np.nan_to_num(np.round(depth / MILLIMETRES.scale))
    return np.where(units <= MAX_MILLIMETRES, units, 0).astype(np.uint16)


def _write_png(path: Path, image: npt.NDArray[Any]) -> None:
    is_encoded, encoded = cv2.imencode(".png", image)
    assert is_encoded
    replace_file(path, encoded.tobytes())


def _camera_json(camera: Camera) -> str:
    content = {key: value for key, value in asdict(camera).items() if value is not None}
    return json.dumps({**content, "depth_scale": MILLIMETRES.scale}, indent=2) + "\n"
