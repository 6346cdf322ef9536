"""Measure what the teacher's verdicts add to what was learned, in drawn rooms.

    python benchmarks/fusing.py [--seeds 21 22 … 29] [--views 24] [--test-views 8]

In each room a model is learned off-line; then things are moved, and new views are mapped. Of all
pixels with the same of the teacher's reasons (`curiosight.teacher.REASONS`) it prints how many
are salient, and the number that, added to the log-odds of the model's probabilities, makes their
sum right: `LOG_ODDS` in `curiosight.learner.fusing`. A penalty keeps it small where pixels are few.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight import load_config, make_teacher
from curiosight.experiments.learning import OffLine
from curiosight.frame import Label
from curiosight.learner.fusing import odds_of_pieces
from curiosight.rooms.room import draw_room
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.views import RoomViews
from curiosight.teacher import REASONS

Array = npt.NDArray[Any]
RESULTS = Path(__file__).parent / "results"
SEEDS = list(range(21, 30))
N_BINS, SPAN = 128, 7.0  # of log-odds, from -SPAN to SPAN
# An offset of 1 costs as much as so many pixels of a view of 640x480 are worth.
PENALTY = 2000.0
MOST = 5.0


def count(seeds: list[int], n_views: int, n_test_views: int) -> Iterator[Array]:
    """Yield after each room (n_reasons, 2, n_bins): other and salient pixels by their log-odds."""
    counts = np.zeros((len(REASONS), 2, N_BINS), np.int64)
    for seed in seeds:
        room = draw_room(RoomSettings(seed, sensor="kinect", views=n_views))
        learning = OffLine(load_config(), RoomViews(room))
        for _ in learning:
            pass
        learner = learning.fit()
        moved = RoomViews(room.rearranged(1)).test_views(n_test_views)
        teacher = make_teacher(load_config(), moved)
        for index in range(len(moved)):
            look = moved.look(index)
            maps = learner.maps(look.frame.rgb, look.frame.T_world_camera)
            said = teacher.segment(look.frame)
            odds = odds_of_pieces(maps.probability, said.cluster_of_pixel)
            bins = np.clip((odds + SPAN) / (2 * SPAN) * N_BINS, 0, N_BINS - 1).astype(np.int64)
            code = said.reasons() * np.int64(N_BINS) + bins
            for kind, label in enumerate((Label.NOT_SALIENT, Label.SALIENT)):
                here = np.bincount(code[look.truth == label], minlength=len(REASONS) * N_BINS)
                counts[:, kind] += here.reshape(-1, N_BINS)
        yield counts


def offset(counts: Array) -> float:
    """Return what to add to the log-odds of (2, n_bins) pixels so that they add up (Newton)."""
    middles = (np.arange(N_BINS) + 0.5) / N_BINS * 2 * SPAN - SPAN
    n_pixels, n_salient = counts.sum(axis=0), counts[1].sum()
    found = 0.0
    for _ in range(50):
        likely = 1 / (1 + np.exp(-middles - found))
        slope = n_salient - n_pixels @ likely - PENALTY * found
        step = slope / (n_pixels @ (likely * (1 - likely)) + PENALTY)
        found = float(np.clip(found + np.clip(step, -1, 1), -MOST, MOST))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS)
    parser.add_argument("--views", type=int, default=24)
    parser.add_argument("--test-views", type=int, default=8)
    asked = parser.parse_args()
    for n_rooms, counts in enumerate(count(asked.seeds, asked.views, asked.test_views), 1):
        rows = {}
        print(f"after room:{asked.seeds[n_rooms - 1]}")
        for code, reason in REASONS.items():
            other, salient = counts[code].sum(axis=1).tolist()
            added = round(offset(counts[code]), 2)
            rows[reason] = {"other": other, "salient": salient, "log_odds": added}
            print(f"  {reason:58} {other:9} {salient:9}  {added:6.2f}", flush=True)
        kept = {"seeds": asked.seeds[:n_rooms], "views": asked.views, "pixels": rows}
        path = RESULTS / "fusing.json"
        path.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
