"""The versions that a result depends on."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from platform import python_version

from curiosight import __version__

_PACKAGES = ("numpy", "numba", "opencv-contrib-python-headless", "onnxruntime")


def versions() -> Iterator[str]:
    """Yield ours, Python's, and those of the installed packages that figures come from."""
    yield f"curiosight {__version__}"
    yield f"Python {python_version()}"
    for package in _PACKAGES:
        try:
            yield f"{package} {version(package)}"
        except PackageNotFoundError:  # another distribution of OpenCV serves as well
            continue
