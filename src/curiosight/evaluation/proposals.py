"""Box proposals: where objects may be, ranked by how salient they look (the authors' later work).

Depth gives the boxes, so they fit; colour gives the order, so that what does not look like the
objects of these rooms comes last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.frame.boxes import boxes_of
from curiosight.learner.description import Saliency

Array = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A place where an object may be.

    box: (x, y, width, height) in pixels. mask: (height, width) bool, inside the box.
    score: in [0, 1], see `consistency`; NaN without a saliency map.
    """

    box: tuple[int, int, int, int]
    mask: Mask
    score: float


def propose(
    instances: npt.NDArray[np.uint16], saliency: Saliency | None = None, *, top: int | None = None
) -> list[Proposal]:
    """Return a box for each instance, the best first; without a map the largest first.

    instances: (H, W), 0 = none. saliency: (H, W) in [0, 1]. top: how many; None = all.
    """
    proposals = []
    for number, place in enumerate(boxes_of(instances), start=1):
        if place is None:
            continue
        rows, columns = place
        box = (columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start)
        score = np.nan if saliency is None else consistency(instances == number, saliency)
        proposals.append(Proposal(box, instances[place] == number, score))
    proposals.sort(key=lambda proposal: np.count_nonzero(proposal.mask), reverse=True)
    if saliency is not None:
        proposals.sort(key=lambda proposal: proposal.score, reverse=True)
    return proposals[:top]


def consistency(mask: Mask, saliency: Saliency) -> float:
    """Return how well a map agrees with an object's outline, in [0, 1].

    The mean saliency inside, times one minus half of that in a ring around it, as wide as a tenth
    of the object's extent. An object cut by a bad outline is salient on both sides.
    """
    side = 2 * max(1, round(0.1 * np.sqrt(np.count_nonzero(mask)))) + 1
    grown = cv2.dilate(mask.astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    ring = grown & ~mask
    around = float(saliency[ring].mean()) if ring.any() else 0.0
    return float(saliency[mask].mean()) * (1.0 - 0.5 * around)


def run_lengths(mask: Mask) -> list[int]:
    """Return a mask's run lengths, COCO's uncompressed RLE: down the columns, background first."""
    flat = mask.ravel(order="F")
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    runs = np.diff(np.concatenate([[0], changes, [len(flat)]])).tolist()
    return [0, *runs] if len(flat) and flat[0] else runs


def to_coco(
    proposals: dict[str, list[Proposal]], sizes: dict[str, tuple[int, int]]
) -> dict[str, Any]:
    """Return the proposals of some frames as a COCO file's content, JSON-able.

    sizes: (height, width) of each frame; frames without proposals are images too.
    """
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for image_id, (name, (height, width)) in enumerate(sizes.items(), start=1):
        images.append({"id": image_id, "file_name": name, "width": width, "height": height})
        for proposal in proposals.get(name, []):
            x, y, *_ = proposal.box
            full = np.zeros((height, width), np.bool_)
            rows, columns = proposal.mask.shape
            full[y : y + rows, x : x + columns] = proposal.mask
            annotation = {
                "id": len(annotations) + 1,
                "image_id": image_id,
                "category_id": 1,
                "bbox": list(proposal.box),
                "area": int(np.count_nonzero(proposal.mask)),
                "iscrowd": 0,
                "segmentation": {"size": [height, width], "counts": run_lengths(full)},
            }
            if np.isfinite(proposal.score):
                annotation["score"] = round(proposal.score, 4)
            annotations.append(annotation)
    categories = [{"id": 1, "name": "object"}]
    return {"images": images, "annotations": annotations, "categories": categories}
