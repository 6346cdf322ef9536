"""Read JSON, YAML, XML, MATLAB, NumPy or plain text as numbers with their places."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from curiosight.datasets.arrays import read_array
from curiosight.datasets.matlab import read_matlab
from curiosight.errors import DataError
from curiosight.errors.inputs import check_file, read_text

# A place such as "camera/color/k" in small letters, and the numbers that stand there. Numbers
# of a text without any name stand at "".
Leaves = list[tuple[str, list[float]]]

MAX_BYTES = 1_000_000
MAX_LEAVES = 5_000
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
BETWEEN = r"[\s\[\](){},;]"
ONLY_NUMBERS = re.compile(rf"^{BETWEEN}*{NUMBER}(?:{BETWEEN}+{NUMBER})*{BETWEEN}*$")
MAX_IN_ARRAY = 16
XML_MATRIX = re.compile(r'<(\w+) type_id="opencv-matrix">.*?<data>([^<]*)</data>', re.DOTALL)
XML_NUMBER = re.compile(r"<(\w+)>([^<]*)</")
# A line of COLMAP's cameras.txt: models of one focal length, then those of two.
COLMAP_LINE = re.compile(
    r"^\d+\s+(?:(SIMPLE_PINHOLE|SIMPLE_RADIAL|RADIAL)|PINHOLE|OPENCV|FULL_OPENCV)\s+([-+.\deE\s]+)$"
)
NAMED_NUMBERS = re.compile(rf"^\s*([A-Za-z_][\w .\-/()]*?)\s*(?:[:=]|\s(?={NUMBER}))\s*(.*)$")


def read_leaves(path: Path) -> Leaves | None:
    """Return the numbers of a file; None where it is no text, or too large, or not readable."""
    try:
        check_file(path, MAX_BYTES)
        if path.suffix.lower() == ".mat":
            return _matlab(path)
        if path.suffix.lower() == ".npy":
            return _array(path)
        text = read_text(path, "utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return None
    if path.suffix.lower() == ".xml":
        return _opencv_xml(text)
    content = _structured(path, text)
    leaves: Leaves = []
    if content is None:
        return _plain(text)
    _walk(content, "", leaves)
    return leaves


def _structured(path: Path, text: str) -> Any:
    """Return the content of JSON or YAML; None where it is neither."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        pass
    if path.suffix.lower() not in (".yaml", ".yml"):
        return None
    return _yaml(text)


def _matlab(path: Path) -> Leaves | None:
    """Collect the arrays of a MATLAB file; None where SciPy cannot read it."""
    leaves: Leaves = []
    try:
        content = read_matlab(path)
    except DataError:
        raise
    # What a damaged file makes of the reader is not foreseeable.
    except Exception:
        return None
    for name, value in content.items():
        if getattr(value, "dtype", None) is not None and value.dtype.kind in "iuf":
            _walk(value.tolist(), name.lower(), leaves)
    return leaves


def _array(path: Path) -> Leaves | None:
    """Return the numbers of a small array, whose name is all that says what they are."""
    try:
        content = read_array(path)
    except ValueError:
        return None
    is_small = content.dtype.kind in "iuf"
    numbers = _flat(content.tolist()) if is_small and content.size <= MAX_IN_ARRAY else None
    return None if numbers is None else [("", numbers)]


def _opencv_xml(text: str) -> Leaves:
    """Collect the numbers and matrices of OpenCV's XML; other XML has none of these."""
    found = [*XML_MATRIX.findall(text), *XML_NUMBER.findall(text)]
    return [(_name(name), _numbers(words)) for name, words in found if ONLY_NUMBERS.match(words)]


def _yaml(text: str) -> Any:
    """Return the content of YAML, OpenCV's own dialect too; None where it is no good."""
    import yaml

    lines = [line for line in text.splitlines() if not line.startswith(("%YAML", "---"))]
    plain = re.sub(r"!!opencv-[\w-]+", "", "\n".join(lines))
    try:
        return yaml.safe_load(plain)
    except (yaml.YAMLError, RecursionError, ValueError):
        return None


def _walk(content: Any, place: str, leaves: Leaves) -> None:
    """Collect what is made of numbers, nested lists as one."""
    if len(leaves) >= MAX_LEAVES:
        return
    numbers = _flat(content)
    if numbers:
        leaves.append((place, numbers))
    elif isinstance(content, dict):
        for key, value in content.items():
            name = str(key).strip().lower().replace(".", "/").lstrip("_")
            _walk(value, f"{place}/{name}" if place else name, leaves)
    elif isinstance(content, list):
        for number, value in enumerate(content[:50]):
            _walk(value, f"{place}/{number}", leaves)


def _flat(content: Any) -> list[float] | None:
    """Return the numbers of a number, or of lists of nothing else; None for anything else."""
    if isinstance(content, bool):
        return None
    if isinstance(content, int | float):
        try:
            return [float(content)] if math.isfinite(content) else None
        except OverflowError:
            return None
    if not isinstance(content, list) or not content or len(content) > 64:
        return None
    numbers: list[float] = []
    for value in content:
        inner = _flat(value)
        if inner is None:
            return None
        numbers += inner
    return numbers


def _plain(text: str) -> Leaves:
    """Collect the numbers of a text by the name that stands before them, or in the line above."""
    leaves: Leaves = []
    name, rows = "", list[float]()

    def close() -> None:
        columns = re.split(r"[,;\s]+", name)
        if len(leaves) >= MAX_LEAVES:
            return
        if len(columns) == len(rows) > 1:  # a header of a table, and its first row
            leaves.extend((column, [value]) for column, value in zip(columns, rows, strict=True))
        elif rows:
            leaves.append((name, list(rows)))
        rows.clear()

    for line in text.splitlines():
        words = line.strip()
        if not words:
            continue
        if ONLY_NUMBERS.match(words):
            rows += _numbers(words)
            continue
        close()
        if colmap := COLMAP_LINE.match(words):
            width, height, *pixels = _numbers(colmap[2])
            pixels = pixels[:1] * 2 + pixels[1:3] if colmap[1] else pixels[:4]
            leaves.append(("", [width, height, *pixels]))
            continue
        match = NAMED_NUMBERS.match(words.lstrip("#/% "))
        name = _name(match[1] if match else words)
        if match and ONLY_NUMBERS.match(match[2]):
            rows += _numbers(match[2])
            if len(rows) == 1:
                close()
                name = ""
    close()
    return leaves


def _name(words: str) -> str:
    return re.sub(r"\s+", " ", words.strip("#/%:= ")).lower().rpartition(".")[2].lstrip("_")


def _numbers(words: str) -> list[float]:
    return [value for value in map(float, re.findall(NUMBER, words)) if math.isfinite(value)]
