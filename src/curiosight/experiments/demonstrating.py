"""Explore a drawn room, move its things, and see whether the program still knows them."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from curiosight.config import Config
from curiosight.evaluation import MapScores
from curiosight.evaluation.baselines import fine_grained
from curiosight.experiments.exploring import Exploration
from curiosight.experiments.output import OutputFolder
from curiosight.learner.description import Saliency
from curiosight.rooms import Look, RoomSettings, RoomViews, draw_room

DEMO = "demo.json"
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

    views: of the room, see `draw_demo_room`; its arrangement is the one to learn from.
    leftovers: see `Exploration`.
    """

    def __init__(
        self,
        config: Config,
        views: RoomViews,
        out: OutputFolder,
        *,
        leftovers: Sequence[str] = (),
    ) -> None:
        self._started = time.perf_counter()
        self._out = out
        self._views = views
        moved = views.room.rearranged((views.room.settings.rearrange or 0) + 1)
        self.rearranged = RoomViews(moved).test_views(N_TEST_VIEWS)
        # Last, as it begins to write: what ends before it leaves no folder behind.
        self.exploration = Exploration(
            config,
            views,
            out,
            test_source=views.test_views(N_TEST_VIEWS),
            leftovers=(DEMO, *leftovers),
        )
        max_range = config.max_range
        self._scores = MapScores(max_range=max_range, threshold=self.exploration.learner.threshold)
        self._baseline_scores = MapScores(max_range=max_range)
        self._n_tested = 0

    def test_rearranged(self) -> Iterator[Tested]:
        """Find objects in the rearranged room by colour alone; yield view by view."""
        for index in range(len(self.rearranged)):
            look = self.rearranged.look(index)
            saliency = self.exploration.learner.saliency(look.frame.rgb, look.frame.T_world_camera)
            _add(self._scores, look, saliency)
            _add(self._baseline_scores, look, fine_grained(look.frame.rgb))
            self._n_tested += 1
            yield Tested(look, saliency)

    def finish(self) -> dict[str, Any]:
        """Write everything that was measured so far; return it."""
        explored = self.exploration.finish()
        scores = self._scores.table()
        summary = {
            "room": self._views.path,
            "rearranged": self.rearranged.path,
            "explored": explored,
            "overall_error_before_move": explored["overall_error"],
            "views_after_move": self._n_tested,
            "overall_error_after_move": scores["overall_error"],
            "frames_scored_after_move": scores["frames_scored"],
            "pooled_error_after_move": scores["pooled_error"],
            "roc_auc_after_move": _aucs(self._scores),
            "baseline": BASELINE,
            "baseline_roc_auc_after_move": _aucs(self._baseline_scores),
            "seconds": round(time.perf_counter() - self._started, 2),
        }
        self._out.write_json(DEMO, summary)
        return summary


def draw_demo_room(seed: int) -> RoomViews:
    """Draw the room to learn in."""
    return RoomViews(draw_room(RoomSettings(seed=seed, views=N_VIEWS)))


def _add(scores: MapScores, look: Look, saliency: Saliency) -> None:
    frame = look.frame
    scores.add(frame.id, saliency, look.truth, depth=frame.depth, true_depth=look.true_depth)


def _aucs(scores: MapScores) -> dict[str, float | None]:
    return {part: scores.ranking(part).roc_auc for part in ("all", *WHERE)}
