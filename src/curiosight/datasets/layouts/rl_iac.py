"""Read RL-IAC folders, the form of the paper's authors' own program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.datasets.cameras.calibration import find_calibration
from curiosight.datasets.cameras.camera_file import LabelValues
from curiosight.datasets.depth_files import ASSUMED
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.rl_iac_tables import (
    GRAPH_FILE,
    REGION_FILE,
    GraphNode,
    check_listed,
    read_graph,
    read_regions,
)
from curiosight.datasets.listing import list_images
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError

IMAGE_FOLDER = "image_data"
# The program takes 255 and 1 as salient and nothing but 0 as not.
MASK_VALUES = LabelValues(support=frozenset({0}), objects_from=1, ignore=frozenset(range(2, 255)))


class RlIac(Recording):
    """An RL-IAC folder, or its folder of images: x.png, x_depth.png, x_GT.png.

    regions: the region of each frame, all 0 where there is no table of them.
    region_table: that table; None = there is none.
    graph: a node a region, empty where there is no navigation graph.
    """

    name = "RL-IAC"
    evidence = "image_data/ with x.png and x_depth.png, or x_GT.png"
    masks_may_be_labelled = False

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether there are x.png with x_GT.png, or x_depth.png in `image_data`."""
        return _image_folder(path) is not None

    def __init__(self, path: Path) -> None:
        images = _image_folder(path)
        assert images is not None
        has_depth = any(images.glob("*_depth.png"))
        listed = {id: rgb for id, rgb in list_images(images).items() if not id.endswith("_GT")}
        entries = [
            Entry(
                id=id,
                rgb=rgb,
                depth=images / f"{rgb.stem}_depth.png" if has_depth else None,
                ground_truth=_existing(images / f"{rgb.stem}_GT.png"),
            )
            for id, rgb in listed.items()
        ]
        remarks: list[str] = []
        self.region_table = _table(path, REGION_FILE)
        entries, self.regions = _keep_listed(entries, self.region_table, remarks)
        self.graph = _read_graph(_table(path, GRAPH_FILE), self.regions)
        if any(entry.ground_truth for entry in entries):
            remarks.append(
                "x_GT.png is read as ground truth; the authors' program may have written it itself"
            )
        camera, depth_form = None, ASSUMED
        if has_depth:
            size = image_size(path, [entry.rgb for entry in entries])
            calibration = find_calibration(path, size, remarks)
            camera, depth_form = calibration.camera, calibration.depth_form(ASSUMED)
        super().__init__(
            path,
            entries,
            camera,
            depth_form=depth_form,
            label_values=MASK_VALUES,
            remarks=remarks,
        )


def _existing(path: Path) -> Path | None:
    return path if path.is_file() else None


def _image_folder(path: Path) -> Path | None:
    """Return the folder of x.png with partners that only this layout has, or in its own place."""
    for folder in (path / IMAGE_FOLDER, path):
        is_own = folder.resolve().name == IMAGE_FOLDER or (path / REGION_FILE).is_file()
        for ending in ("_depth", "_GT") if is_own else ("_GT",):
            partners = folder.glob(f"*{ending}.png")
            if any(file.with_stem(file.stem.removesuffix(ending)).is_file() for file in partners):
                return folder
    return None


def _table(path: Path, name: str) -> Path | None:
    """Find a table in the folder that was opened, or beside it where that is `image_data`."""
    folder = path.resolve()
    beside = folder.parent / name if folder.name == IMAGE_FOLDER else None
    return _existing(path / name) or (beside and _existing(beside))


def _keep_listed(
    entries: list[Entry], table: Path | None, remarks: list[str]
) -> tuple[list[Entry], tuple[int, ...]]:
    """Return the frames that are in the table of regions, as the authors do, and their regions."""
    if table is None:
        return entries, (0,) * len(entries)
    region_of_file = read_regions(table)
    kept = [entry for entry in entries if entry.rgb.name in region_of_file]
    if not kept:
        remedy = f"list files such as {entries[0].rgb.name}, or delete the table"
        raise DataError(table, "lists none of the images", remedy)
    if len(kept) < len(entries):
        remarks.append(f"{len(entries) - len(kept)} images are not in {REGION_FILE}: left out")
    return kept, tuple(region_of_file[entry.rgb.name] for entry in kept)


def _read_graph(table: Path | None, regions: Sequence[int]) -> tuple[GraphNode, ...]:
    if table is None:
        return ()
    graph = read_graph(table)
    check_listed(table, graph, max(regions, default=0))
    return graph
