"""Read recordings in the form of TUM RGB-D of which only one of the two lists is there."""

from __future__ import annotations

from pathlib import Path

from curiosight.datasets.association import associate
from curiosight.datasets.depth_files import DEPTH_ENDINGS
from curiosight.datasets.entries import Entry
from curiosight.datasets.layouts.calibrated import Calibrated
from curiosight.datasets.layouts.tum_rgbd import CAMERA, UNIT, WHOSE
from curiosight.datasets.listing import IMAGE_ENDINGS, find_ground_truth, frame_id
from curiosight.datasets.pose_match import stamp_or_none
from curiosight.datasets.poses_of_entries import with_found_poses
from curiosight.datasets.trajectory import table_rows
from curiosight.errors import DataError

ENDINGS = {"rgb": tuple(IMAGE_ENDINGS), "depth": DEPTH_ENDINGS}
Stamped = list[tuple[int, Path]]


class TumOneList(Calibrated):
    """A recording of TUM's form where the images of one kind are known by their names alone."""

    name = "TUM RGB-D, one list"
    evidence = "rgb.txt or depth.txt, the other images named by stamps in depth/ or rgb/"
    usual_camera = CAMERA
    usual_form = UNIT
    whose = WHOSE

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether one list is there, and a folder of images named by stamps for the other."""
        has_list = {kind: (path / f"{kind}.txt").is_file() for kind in ENDINGS}
        if sum(has_list.values()) != 1:
            return False
        other = next(kind for kind, is_there in has_list.items() if not is_there)
        return bool(_named(path / other, ENDINGS[other])) and bool(_listed(path))

    def __init__(self, path: Path) -> None:
        images = {kind: _named(path / kind, ends) for kind, ends in ENDINGS.items()}
        kind, listed = next(iter(_listed(path).items()))
        images[kind] = listed
        pairs = associate(sorted(set(images["rgb"])), images["depth"])
        if not pairs:
            remedy = "check the stamps in the list and in the names"
            raise DataError(path, "no colour image has a depth image within 20 ms", remedy)
        remarks = []
        n_alone = len(set(images["rgb"])) - len(pairs)
        if n_alone:
            remarks.append(f"{n_alone} colour images have no depth within 20 ms: left out")
        ground_truth = find_ground_truth(path)
        entries = with_found_poses(
            path,
            [
                Entry(
                    id=frame_id(rgb),
                    rgb=rgb,
                    depth=depth,
                    stamp_ns=stamp,
                    ground_truth=ground_truth.get(frame_id(rgb)),
                )
                for stamp, rgb, depth in pairs
            ],
            remarks,
        )
        super().__init__(path, entries, remarks, avoid=(f"{kind}.txt",))


def _listed(path: Path) -> dict[str, Stamped]:
    """Return the images of the one list there is; none where it is something else."""
    for kind, endings in ENDINGS.items():
        images: Stamped = []
        for _, words in (
            table_rows(path / f"{kind}.txt") if (path / f"{kind}.txt").is_file() else ()
        ):
            stamp = stamp_or_none(words[0])
            if len(words) < 2 or stamp is None or not words[-1].lower().endswith(endings):
                return {}
            images.append((stamp, path / " ".join(words[1:])))
        if images:
            return {kind: sorted(images)}
    return {}


def _named(folder: Path, endings: tuple[str, ...]) -> Stamped:
    """Return the images of a folder whose names are stamps."""
    if not folder.is_dir():
        return []
    files = [path for path in folder.iterdir() if path.suffix.lower() in endings]
    stamped = [(stamp_or_none(path.stem), path) for path in files]
    return sorted((stamp, path) for stamp, path in stamped if stamp is not None)
