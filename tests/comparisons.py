"""A small comparison made by hand: three methods, one of which could hardly be scored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from curiosight.frame import Label
from curiosight.viewing.comparison import ComparisonReport, MethodResult, WallRow

RNG = np.random.default_rng(0)
RGB = RNG.integers(60, 200, (48, 64, 3), np.uint8)
ROC = np.array([[0, 0], [0.1, 0.8], [1, 1]], float)
PRECISION_RECALL = np.array([[0.2, 1], [0.9, 0.7], [1, 0.3]], float)

OURS = MethodResult(
    "ours (default)",
    is_ours=True,
    figures={"roc_auc": 0.9331, "f1": 0.71, "mae": 0.12, "weighted_f": 0.5},
    intervals={"roc_auc": (0.912, 0.9512), "mae": (0.1, 0.2)},
    roc=ROC,
    precision_recall=PRECISION_RECALL,
)
RIVAL = MethodResult(
    "bms",
    figures={"roc_auc": 0.81, "f1": 0.72, "mae": 0.1199, "weighted_f": 0.4},
    roc=ROC,
    precision_recall=PRECISION_RECALL,
    ms=12.34,
)
UNSCORED = MethodResult("blank", figures={"roc_auc": None, "f1": 0.1, "mae": 0.3})
METHODS = (RIVAL, UNSCORED, OURS)


def many_methods(n_others: int = 18) -> list[MethodResult]:
    """Return ours and others, each a little worse than the one before."""
    others = [
        replace(RIVAL, name=f"method-{i}", figures={"roc_auc": 0.95 - 0.01 * i})
        for i in range(n_others)
    ]
    return [OURS, *others]


def truth() -> np.ndarray:
    """Return labels of a picture like `RGB`: salient on the left, ignored on the right."""
    labels = np.full(RGB.shape[:2], Label.NOT_SALIENT, np.uint8)
    labels[:, :20], labels[:, 50:] = Label.SALIENT, Label.UNKNOWN
    return labels


def wall_row(names: tuple[str, ...] = ("ours (default)", "bms"), *, caption: str = "7") -> WallRow:
    maps = {name: np.linspace(0, 1, 12 * 16).reshape(12, 16) for name in names}
    return WallRow(caption, RGB, truth(), maps)


def comparison(name: str = "kitchen") -> ComparisonReport:
    """Return a comparison with everything in it, called `name` wherever a name can stand."""
    return ComparisonReport(
        title=name,
        sentence=f"Compared on {name}.",
        methods=[replace(RIVAL, name=name), UNSCORED, OURS],
        wall=[wall_row((name, "bms"), caption=name)],
        facts={name: name},
        command=name,
        problems=[name],
        limits=[name],
        files={name: name},
    )
