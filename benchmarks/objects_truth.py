"""The true things of a drawn home, and which of them its views show: for scoring catalogues.

A visit is written once as a recording, with truth.json beside it: rendering takes longest.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.experiments.output import OutputFolder
from curiosight.experiments.rendering import render_room, usual_layout
from curiosight.rooms.home.renderer import MAX_PARTS
from curiosight.rooms.home.views import HomeViews
from curiosight.rooms.scene import Part
from curiosight.worlds import open_drawn

TRUTH = "truth.json"
# A truth object is one that so many views show with so many pixels.
MIN_VIEWS, MIN_PX = 2, 400
# What stands within this of where it stood is the same, metres.
SAME = 0.05


@dataclass(frozen=True, slots=True)
class TrueThing:
    """A thing that a visit's views show.

    key: what tells it again in another visit. centre: (3,) of the box around it, world, metres.
    """

    key: str
    kind: str
    centre: tuple[float, float, float]


def recorded_visit(source: str, folder: Path) -> Path:
    """Return the folder of a home's views as a recording with its truth, written if it is not."""
    if (folder / TRUTH).exists():
        return folder
    views = open_drawn(source)
    assert isinstance(views, HomeViews)
    out, n_views = OutputFolder(folder, "render", None, overwrite=True), Counter[int]()
    for index, _ in enumerate(render_room(views, usual_layout(views), out)):
        shown = np.bincount(np.maximum(views.instance_truth(index), 0).ravel())
        n_views.update(np.flatnonzero(shown >= MIN_PX).tolist())
    keys = _keys(views)
    parts = {str(id): keys[id] | {"views": n} for id, n in n_views.items() if id in keys}
    out.write_json(TRUTH, parts)
    return folder


def read_truth(folder: Path) -> list[TrueThing]:
    """Return the things that enough views of a recorded visit show."""
    content = json.loads((folder / TRUTH).read_text("utf-8"))
    return [
        TrueThing(one["key"], one["kind"], tuple(one["centre"]))
        for one in content.values()
        if one["views"] >= MIN_VIEWS
    ]


def true_changes(
    before: list[TrueThing], after: list[TrueThing]
) -> tuple[list[tuple[TrueThing, str]], list[TrueThing]]:
    """Return what is there after with what became of it, and what has gone, as views show it.

    What only the later views show is new to them, wherever it was; what only the earlier do is
    gone.
    """
    was = {one.key: one for one in before}
    now = []
    for one in after:
        change = "new"
        if one.key in was:
            shift = float(np.linalg.norm(np.subtract(one.centre, was[one.key].centre)))
            change = "moved" if shift > SAME else "same"
        now.append((one, change))
    there = {one.key for one in after}
    return now, [one for one in before if one.key not in there]


def _keys(views: HomeViews) -> dict[int, dict[str, Any]]:
    """Return key, kind and centre of each part of a home, by its number in pictures."""
    found: dict[int, dict[str, Any]] = {}
    for number, lot in enumerate(views.home.plan.lots):
        room = views.home.room(number)
        parts = room.scene.moved(lot.T_world_room).parts
        first = len(parts) - len(room.things)
        for place, part in enumerate(parts):
            mesh = room.things[place - first].mesh if place >= first else part.mesh
            key = f"{number}-{part.name}-{_hash(mesh.vertices)}"
            low, high = part.mesh.bounds
            centre = ((low + high) / 2).round(4).tolist()
            found[number * MAX_PARTS + place + 1] = _described(key, part, centre)
    return found


def _described(key: str, part: Part, centre: list[float]) -> dict[str, Any]:
    return {"key": key, "kind": part.name, "centre": centre}


def _hash(vertices: npt.NDArray[np.float32]) -> str:
    return hashlib.sha256(np.ascontiguousarray(vertices).tobytes()).hexdigest()[:16]
