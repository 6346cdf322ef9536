"""Files of other programs that hold recordings but are not read here, and what to do."""

from __future__ import annotations

from pathlib import Path

from curiosight.errors import DataError

AS_FOLDER = "write its colour and depth (16-bit PNG) to rgb/ and depth/, with a camera.json"
RECORD3D = f"share the .r3d itself, which is read; or {AS_FOLDER}"
REMEDY = {
    ".sens": "is a scan of ScanNet|export its color, depth, pose, intrinsic with SensReader",
    ".oni": f"is a recording of OpenNI|{AS_FOLDER}",
    ".mkv": "is a recording of an Azure Kinect|unpack it with Open3D's azure_kinect_mkv_reader.py",
    ".exr": f"is an export of Record3D with depth as EXR|{RECORD3D}",
    ".klg": f"is a log of ElasticFusion's logger|{AS_FOLDER}",
}
# A video in Matroska is a Kinect's where it has its tags, or a raw track of depth.
KINECT_MARKS = (b"K4A_DEPTH_MODE", b"K4A_CALIBRATION_FILE", b"V_MS/VFW/FOURCC")
HEAD_BYTES = 1_000_000


def is_foreign(path: Path) -> bool:
    """Tell whether a path is a recording of another program's that is not read here."""
    if _is_record3d(path):
        return True
    ending = path.suffix.lower()
    if ending not in REMEDY or not path.is_file():
        return False
    return ending != ".mkv" or _is_kinects(path)


def refusal(path: Path) -> DataError:
    """Return the error that says what a foreign recording is and how to convert it."""
    ending = ".exr" if path.is_dir() else path.suffix.lower()
    found, _, remedy = REMEDY[ending].partition("|")
    return DataError(path, f"{found}, which is not read", remedy)


def _is_record3d(path: Path) -> bool:
    """Tell whether a folder is what Record3D exports with EXR."""
    return (path / "metadata.json").is_file() and any((path / "depth").glob("*.exr"))


def _is_kinects(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    return any(mark in head for mark in KINECT_MARKS)
