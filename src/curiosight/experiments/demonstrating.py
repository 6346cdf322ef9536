"""Explore a drawn room, move its things, and see whether the program still knows them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from curiosight.baselines import fine_grained
from curiosight.config import Config
from curiosight.evaluation import MapScores
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.output import OutputFolder
from curiosight.frame import Frame
from curiosight.learner import Saliency
from curiosight.worlds.rooms.room import draw_room
from curiosight.worlds.rooms.settings import RoomSettings
from curiosight.worlds.rooms.views import Look, RoomViews

N_VIEWS = 160
N_TEST_VIEWS = 30
BASELINE = "fine-grained (OpenCV)"
# What is scored apart: see `MapScores`.
WHERE = {"near": "near", "beyond_range": "beyond 4 m", "missing": "where depth is missing"}


@dataclass(frozen=True, slots=True, eq=False)
class Tested:
    """A view of the rearranged room, and what the model made of its colours."""

    look: Look
    saliency: Saliency


class Demonstration:
    """Learn in a room with curiosity, then be tested in the same room after a move.

    room: what to draw; its arrangement is the one to learn from.
    """

    def __init__(self, config: Config, room: RoomSettings, out: OutputFolder) -> None:
        self._started = time.perf_counter()
        self.out = out
        views = RoomViews(draw_room(replace(room, views=N_VIEWS)))
        self.exploration = Exploration(
            config, views, out, test_source=views.test_views(N_TEST_VIEWS)
        )
        self.views = views
        moved = views.room.rearranged((room.rearrange or 0) + 1)
        self.rearranged = RoomViews(moved).test_views(N_TEST_VIEWS)
        max_range = config.segmentation.max_range
        self.scores = MapScores(max_range=max_range, threshold=self.exploration.learner.threshold)
        self.baseline_scores = MapScores(max_range=max_range)

    def test_rearranged(self) -> Iterator[Tested]:
        """Find objects in the rearranged room by colour alone; yield view by view."""
        for index in range(len(self.rearranged)):
            look = self.rearranged.look(index)
            saliency = self.exploration.learner.saliency(look.frame.rgb)
            self._add(self.scores, look, saliency)
            self._add(self.baseline_scores, look, fine_grained(look.frame.rgb))
            yield Tested(look, saliency)

    def finish(self) -> dict[str, Any]:
        """Write everything that was measured; return it."""
        explored = self.exploration.finish()
        summary = {
            "room": self.views.path,
            "rearranged": self.rearranged.path,
            "explored": explored,
            "overall_error_before_move": explored["overall_error"],
            "overall_error_after_move": self.scores.table()["overall_error"],
            "roc_auc_after_move": _aucs(self.scores),
            "baseline": BASELINE,
            "baseline_roc_auc_after_move": _aucs(self.baseline_scores),
            "seconds": round(time.perf_counter() - self._started, 2),
        }
        self.out.write_json("demo.json", summary)
        return summary

    def _add(self, scores: MapScores, look: Look, saliency: Saliency) -> None:
        frame: Frame = look.frame
        scores.add(frame.id, saliency, look.truth, depth=frame.depth, true_depth=look.true_depth)


def _aucs(scores: MapScores) -> dict[str, float | None]:
    return {part: scores.ranking(part).roc_auc for part in ("all", *WHERE)}
