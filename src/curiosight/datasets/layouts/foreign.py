"""Files of other programs that hold recordings but are not read here, and what to do."""

from __future__ import annotations

from pathlib import Path

from curiosight.errors import DataError

AS_FOLDER = "write its colour and depth (16-bit PNG) to rgb/ and depth/, with a camera.json"
RECORD3D = (
    f"is a recording of Record3D with depth as EXR|share it as .r3d, which is read, or {AS_FOLDER}"
)
REMEDY = {
    ".sens": "is a scan of ScanNet|export its color, depth, pose, intrinsic with SensReader",
    ".oni": f"is a recording of OpenNI|{AS_FOLDER}",
    ".klg": f"is a log of ElasticFusion's logger|{AS_FOLDER}",
}


def is_foreign(path: Path) -> bool:
    """Tell whether a path is a recording of another program's that is not read here."""
    if _is_record3d(path):
        return True
    return path.suffix.lower() in REMEDY and path.is_file()


def refusal(path: Path) -> DataError:
    """Return the error that says what a foreign recording is and how to convert it."""
    told = RECORD3D if path.is_dir() else REMEDY[path.suffix.lower()]
    found, _, remedy = told.partition("|")
    return DataError(path, f"{found}, which is not read", remedy)


def _is_record3d(path: Path) -> bool:
    """Tell whether a folder is what Record3D exports with EXR."""
    return (path / "metadata.json").is_file() and any((path / "depth").glob("*.exr"))
