"""Regions that a file lists: lines `id,region`, or the authors' region map and its graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np

from curiosight.datasets.layouts.rl_iac_tables import (
    GRAPH_FILE,
    check_listed,
    file_name,
    is_region_table,
    read_graph,
    read_region_lines,
)
from curiosight.datasets.listing import IMAGE_ENDINGS, frame_id
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text
from curiosight.explorer.division import Regions, numbered
from curiosight.explorer.navigation import shortest_seconds

KIND = "file"


def file_regions(path: Path | str, ids: Sequence[str]) -> Regions:
    """Read regions from lines `id,region`, or from a region map of the authors' program.

    Frames that are not listed are in no region. A region is any word: regions are numbered in
    the natural order of their names. Blank lines and what follows a # are skipped. Raises
    DataError with the line's number for a malformed line, an unknown id, or an id that is given
    two regions. For the authors' see `map_regions`.
    """
    try:
        lines = read_text(path, "utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        remedy = "write lines `id,region` in UTF-8"
        raise DataError(path, f"cannot be read as text ({error})", remedy) from error
    if is_region_table(Path(path)):
        return map_regions(Path(path), ids)
    view_of_id = {id_: view for view, id_ in enumerate(ids)}
    labels = [""] * len(ids)
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        id_, comma, region = (part.strip() for part in text.rpartition(","))
        if not (id_ and comma and region):
            raise DataError(path, f"line {number} is {line!r}", "write `id,region`")
        if id_ not in view_of_id:
            remedy = f"use the recording's ids, such as {ids[0]}" if ids else "it has no frames"
            raise DataError(path, f"line {number} names the unknown frame {id_!r}", remedy)
        _give(labels, view_of_id[id_], region, f"line {number} gives {id_!r}", path)
    if not any(labels):
        raise DataError(path, "no frame is in any region", "write lines `id,region`")
    return numbered(labels, KIND)


def map_regions(path: Path, ids: Sequence[str]) -> Regions:
    """Read regions from lines `[image_data/x.png] = region`, as the authors' program has them.

    A path means the frame whose id it ends in, as it is or as `RlIacWriter` writes it. Frames
    that are not listed are in no region, and lines of other images mean nothing, both as there.
    A navigation graph beside it, `region_map.dat`, gives the seconds between regions. Raises
    DataError for a malformed line, for a frame that is given two regions, where no line is of a
    frame, and for a graph that lacks a region or a way to one.
    """
    view_of_name = {file_name(id_): view for view, id_ in enumerate(ids)}
    view_of_name |= {"".join(id_.split()): view for view, id_ in enumerate(ids)}
    labels = [""] * len(ids)
    for number, name, region in read_region_lines(path):
        view = _view_of(name, view_of_name)
        if view is not None:
            _give(labels, view, str(region), f"line {number} gives {ids[view]!r}", path)
    if not any(labels):
        example = f"list them as [image_data/{file_name(ids[0])}.png] = 0" if ids else "add frames"
        raise DataError(path, "lists none of the frames", example)
    regions = numbered(labels, KIND)
    graph = path.parent / GRAPH_FILE
    return _with_graph(regions, graph) if graph.is_file() else regions


def _give(labels: list[str], view: int, region: str, found: str, path: Path | str) -> None:
    if labels[view] not in ("", region):
        raise DataError(path, f"{found} two regions", "keep one of them")
    labels[view] = region


def _view_of(name: str, view_of_name: Mapping[str, int]) -> int | None:
    """Return the view that a path names; of two that it ends in, the longer name."""
    return next((view_of_name[end] for end in _ends(name) if end in view_of_name), None)


def _ends(name: str) -> Iterator[str]:
    """Yield what may be an id of a path: without its ending, and without its first folders."""
    path = PurePosixPath(name.replace("\\", "/"))
    stem = frame_id(Path(path)) if path.suffix.lower() in IMAGE_ENDINGS else path.name
    parts = (*path.parts[:-1], stem)
    for first in range(len(parts)):
        yield "/".join(parts[first:])


def _with_graph(regions: Regions, path: Path) -> Regions:
    """Add the seconds between regions that a navigation graph tells."""
    numbers = np.array([int(name) for name in regions.names])
    nodes = read_graph(path)
    check_listed(path, nodes, int(numbers.max()))
    seconds = shortest_seconds(nodes)[np.ix_(numbers, numbers)]
    lost = np.argwhere(np.isinf(seconds))
    if len(lost):
        start, goal = numbers[lost[0]]
        raise DataError(path, f"no way leads from region {start} to {goal}", "add one")
    return replace(regions, seconds=seconds)
