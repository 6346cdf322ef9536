"""Read files of MATLAB (extra `curiosight[matlab]`)."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from curiosight.errors import DataError
from curiosight.errors.inputs import read_bytes


def read_matlab(path: Path) -> dict[str, Any]:
    """Return the variables of a file by name; raises `DataError` where SciPy is missing.

    Of a damaged file SciPy raises whatever it happens to.
    """
    try:
        from scipy.io import loadmat
    except ImportError:
        found = "is a file of MATLAB, which needs SciPy, which is missing"
        raise DataError(path, found, "pip install 'curiosight[matlab]'") from None
    content: dict[str, Any] = loadmat(io.BytesIO(read_bytes(path)))
    return content
