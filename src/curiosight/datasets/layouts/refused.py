"""Know forms of recordings that are not read, and say in one line how to convert them."""

from __future__ import annotations

from pathlib import Path

from curiosight.datasets.listing import find_sequences
from curiosight.datasets.recording import Recording
from curiosight.errors import DataError

PLAIN = "a plain folder (rgb/, depth/ as 16-bit PNG in millimetres, camera.json)"


class NyuRaw(Recording):
    """Raw recordings of NYU Depth v1 and v2: depth as the Kinect's own numbers."""

    name = "NYU Depth, raw"
    evidence = "r-*.ppm with d-*.pgm"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder, or one in it, holds raw files."""
        return path.is_dir() and bool(find_sequences(path, _holds_raw, levels=1))

    def __init__(self, path: Path) -> None:
        raise DataError(
            path,
            "holds raw NYU Depth: bytes swapped, not metres, not registered to colour",
            "run the data set's toolbox (get_synched_frames, swapbytes, project_depth_map) and "
            f"save {PLAIN}",
        )


class MatlabFile(Recording):
    """A MATLAB file, such as the labelled part of NYU Depth."""

    name = "MATLAB file"
    evidence = "a .mat file"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the path is such a file."""
        return path.is_file() and path.suffix.lower() == ".mat"

    def __init__(self, path: Path) -> None:
        raise DataError(
            path,
            "is a MATLAB file, such as NYU Depth's labelled frames",
            f"save its images and depths with h5py or scipy as {PLAIN}",
        )


class IclNuimPovRay(Recording):
    """ICL-NUIM as POV-Ray wrote it: text files of distances along the ray."""

    name = "ICL-NUIM, POV-Ray"
    evidence = "scene_*.png with scene_*.depth"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the folder holds colour images with `.depth` files of their names."""
        files = path.glob("scene_*.depth") if path.is_dir() else ()
        return any(file.with_suffix(".png").is_file() for file in files)

    def __init__(self, path: Path) -> None:
        raise DataError(
            path,
            "holds ICL-NUIM in POV-Ray's form: .depth is distance along the ray",
            "take the data set's TUM form (rgb/, depth/, *.gt.freiburg), or divide by "
            f"sqrt(1 + x*x + y*y), x = (u - cx) / fx, and save {PLAIN}",
        )


def _holds_raw(folder: Path) -> bool:
    return any(folder.glob("r-*.ppm")) and any(folder.glob("d-*.pgm"))


# Looked for before the layouts that are read.
REFUSED = (NyuRaw, MatlabFile, IclNuimPovRay)
