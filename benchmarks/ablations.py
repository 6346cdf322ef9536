"""The teacher's rules, numbered as in docs/teacher.md, and how to leave each out."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from curiosight.teacher.supports.tops import Kind, TopView


@dataclass(frozen=True)
class Rule:
    """A rule and what stands in its place when it is left out.

    key: its number. where: the name in the module that uses it, "package.module:name" below
    `curiosight.teacher`, of a function, a method ("Class.method") or a constant; or "settings".
    instead: what is put there, or the settings by name.
    """

    key: str
    where: str
    instead: Any

    @contextmanager
    def left_out(self) -> Iterator[dict[str, Any]]:
        """Replace the rule while the block runs; yields the settings that do so, if any."""
        module, is_code, name = self.where.partition(":")
        if not is_code:
            yield self.instead
            return
        owner: Any = importlib.import_module(f"curiosight.teacher.{module}")
        *parents, last = name.split(".")
        for parent in parents:
            owner = getattr(owner, parent)
        whole = vars(owner)[last]
        setattr(owner, last, self.instead)
        try:
            yield {}
        finally:
            setattr(owner, last, whole)


def _no(*_: Any, **__: Any) -> bool:
    return False


def _nothing(*_: Any, **__: Any) -> list[Any]:
    return []


def _nowhere(_: Any, points: Any) -> Any:
    return np.zeros(points.depth.shape, np.bool_)


def _frameless(camera: Any, stride: int, *_: Any) -> Any:
    return np.zeros((-(-camera.height // stride), -(-camera.width // stride)), np.bool_)


def _each_alone(boxes: Any, *_: Any, **__: Any) -> Any:
    return np.arange(len(boxes))


def _never_doubtful(view: TopView, *args: Any) -> Kind:
    kind = _KIND(view, *args)
    return Kind.TABLE if kind in (Kind.DOUBTFUL, Kind.BARE) else kind


_KIND = TopView.kind
ONLY_TABLES = {"segmentation.min_table_area": 0.25, "segmentation.min_table_diagonal": 0.7}
TOPS = "supports.tops:TopView"
RULES = (
    # V: where a view ends, and how exact its sensor is.
    Rule("V1", "cloud.view:cut_by", _nowhere),
    Rule("V2", "cloud.view:border_mask", _frameless),
    Rule("V3", "settings", {"segmentation.follow_sensor": False}),
    Rule("V4", "supports.footing:votes_on_up", lambda points, max_range: points.area),
    Rule("V5", "supports.footing:find_veils", lambda points: _nowhere(None, points)),
    # S: what is a support.
    Rule("S1", "supports.footing:MAX_SHARE_BELOW", 2.0),
    Rule("S2", "memory.survey:map_tables", lambda *_, **__: ()),
    Rule("S3", "supports.supports:tops_in_frame", _nothing),
    Rule("S4", "settings", ONLY_TABLES),
    Rule("S5", "settings", {"segmentation.max_small_height": 1.3}),
    Rule("S6", f"{TOPS}.standing", _nothing),
    Rule("S7", f"{TOPS}._is_rested_on", _no),
    Rule("S8", f"{TOPS}._is_container", _no),
    Rule("S9", f"{TOPS}._share_seen_around", lambda *_: 1.0),
    Rule("S10", f"{TOPS}.kind", _never_doubtful),
    Rule("S11", "supports.table_map:_bulky_pieces", _nothing),
    # W: what is a wall.
    Rule("W1", "walls.surroundings:_before_camera", _nothing),
    Rule("W2", "walls.faces:find_openings", lambda *args, **__: np.zeros(args[4], np.bool_)),
    Rule("W3", "walls.faces:Face.below_top", lambda face, *_: face),
    Rule("W4", "settings", {"segmentation.min_cut_wall_diagonal": 1.5}),
    # T: what is one thing.
    Rule("T1", "things.things:join_stacked", _each_alone),
    Rule("T2", "things.things:_are_below_camera", lambda boxes, *_: np.zeros(len(boxes), bool)),
    Rule("T3", "things.objects:beside_table", lambda bodies, _: np.zeros(bodies.n, np.bool_)),
    Rule("T4", "things.objects:set_apart", _nothing),
    Rule("T5", "things.objects:part_touching", lambda things, _: things),
    Rule("T6", "things.objects:join_feet", lambda *_, **__: None),
    Rule("T7", "things.objects:find_hollows", lambda number, *_: np.zeros_like(number)),
    # O: what is an object.
    Rule("O2", "things.verdicts:_is_part_of_table", _no),
    Rule("O4", "things.verdicts:_is_part_of_wall", _no),
    Rule("O5", "things.verdicts:_turns_corner", _no),
    Rule("O6", "things.verdicts:_is_from_above", _no),
    Rule("O7", "things.verdicts:_least_across", lambda *_, **__: np.inf),
)
