"""Read the boxes of a detector from a COCO JSON file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from curiosight.errors import DataError
from curiosight.errors.inputs import read_bytes

Box = tuple[float, float, float, float]

# Pixels. Images have fewer, and what is smaller is no box: such numbers are of something else.
MAX_PX, MIN_SIDE_PX = 1e6, 1e-3


def read_coco(path: Path, min_score: float) -> dict[str, list[Box]]:
    """Return the boxes (x, y, width, height) in pixels of each image, by the name it has.

    Images without a box have an empty list. The name is the file's, or, in a list of results,
    `image_id`. min_score: of a box that counts, where boxes have a score. Raises `DataError`.
    """
    try:
        content = json.loads(read_bytes(path))
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "name a COCO file") from error
    except (ValueError, RecursionError) as error:
        raise DataError(path, f"is not JSON ({error})", "name a COCO file") from error
    try:
        return _boxes_by_name(content, min_score)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        found = f"is not COCO: {type(error).__name__} {str(error)[:200]}"
        raise DataError(path, found, "give images and annotations, or a list of results") from error


def _boxes_by_name(content: Any, min_score: float) -> dict[str, list[Box]]:
    annotations: Iterable[Any]
    if isinstance(content, list):
        annotations, name_of = content, {a["image_id"]: str(a["image_id"]) for a in content}
    else:
        annotations = content["annotations"]
        name_of = {image["id"]: _checked_name(image["file_name"]) for image in content["images"]}
    boxes: dict[str, list[Box]] = {name: [] for name in name_of.values()}
    for annotation in annotations:
        if annotation.get("score", 1.0) >= min_score:
            boxes[name_of[annotation["image_id"]]].append(_checked_box(annotation["bbox"]))
    return boxes


def _checked_name(name: Any) -> str:
    if not isinstance(name, str) or not name:
        raise ValueError(f"file_name: expected a text, got {name!r:.60}")
    return name


def _checked_box(numbers: Any) -> Box:
    x, y, width, height = (float(number) for number in numbers)
    # Written so that NaN is refused as well.
    is_near = abs(x) <= MAX_PX and abs(y) <= MAX_PX
    if not (is_near and all(MIN_SIDE_PX <= side <= MAX_PX for side in (width, height))):
        raise ValueError(f"bbox: expected [x, y, width, height] in pixels, got {str(numbers)[:80]}")
    return x, y, width, height
