"""What a comparison of methods tells; every text is plain text, escaped where it is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from curiosight.frame import Rgb

Curve = npt.NDArray[np.float64]
Labels = npt.NDArray[np.uint8]
Saliency = npt.NDArray[np.floating]

MAIN_KEY = "roc_auc"  # the figure that methods are ordered by
NO_CURVE: Curve = np.empty((0, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """A figure of each method.

    explanation: a sentence without its full stop. latex_title: empty = like `title`.
    """

    key: str
    title: str
    is_lower_better: bool
    explanation: str
    latex_title: str = ""


COLUMNS: tuple[Column, ...] = (
    Column(
        "roc_auc",
        "AUC",
        False,
        "Area under the ROC curve over the pixels of all frames: the chance that a salient "
        "pixel ranks above one that is not",
    ),
    Column(
        "average_precision",
        "AP",
        False,
        "Average precision over the pixels of all frames: the area under the precision–recall "
        "curve",
    ),
    Column("best_f1", "best F1", False, "F1 over the pixels of all frames, at its best threshold"),
    Column("f1", "F1", False, "F1 over the pixels of all frames, at a threshold of 0.5"),
    Column(
        "overall_error",
        "error",
        True,
        "The overall error: 1 − F1, mean over the frames; ours is cut at the threshold it learns "
        "with, the others at 0.5",
    ),
    Column(
        "f_max",
        "Fβ max",
        False,
        "F-measure with β² = 0.3, mean over the frames, at the threshold where that is highest",
        r"$F_\beta^{\max}$",
    ),
    Column(
        "f_mean",
        "Fβ mean",
        False,
        "F-measure with β² = 0.3, mean over the frames and over 256 thresholds",
        r"$F_\beta^{\mathrm{mean}}$",
    ),
    Column(
        "f_adaptive",
        "Fβ adapt.",
        False,
        "F-measure with β² = 0.3 at twice the map's mean, mean over the frames",
        r"$F_\beta^{\mathrm{adp}}$",
    ),
    Column(
        "s_measure",
        "S",
        False,
        "Structure measure: how alike map and truth are in their objects and regions",
        r"$S_\alpha$",
    ),
    Column(
        "e_max",
        "E max",
        False,
        "Enhanced-alignment measure, mean over the frames, at the threshold where that is highest",
        r"$E_\xi^{\max}$",
    ),
    Column(
        "weighted_f",
        "wFβ",
        False,
        "Weighted F-measure: errors near an object weigh less than errors far away",
        r"$F_\beta^{w}$",
    ),
    Column("mae", "MAE", True, "Mean absolute difference of map and truth, mean over the frames"),
    Column("roc_auc_near", "AUC near", False, "AUC of the pixels within the range of depth"),
    Column(
        "roc_auc_beyond_range",
        "AUC far",
        False,
        "AUC of the pixels beyond the range of depth",
    ),
    Column(
        "roc_auc_missing",
        "AUC blind",
        False,
        "AUC of the pixels within the range where the depth sensor saw nothing",
    ),
    Column("ms", "ms", True, "Milliseconds per image, median, on one thread"),
)
COLUMN_OF: dict[str, Column] = {column.key: column for column in COLUMNS}


@dataclass(frozen=True, slots=True, eq=False)
class MethodResult:
    """What one method reached.

    name: as given to the command.
    figures: by the key of their column; None, or left out, where they have no meaning.
    intervals: (low, high) of 95 %, by the key of their column; left out where not known.
    roc, precision_recall: (n, 2) curves pooled over the frames, of false and true positive
        rates, and of recall and precision; may be empty.
    ms: per image on one thread, median; None = not timed.
    """

    name: str
    is_ours: bool = False
    figures: Mapping[str, float | None] = field(default_factory=dict)
    intervals: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    roc: Curve = field(default_factory=NO_CURVE.copy)
    precision_recall: Curve = field(default_factory=NO_CURVE.copy)
    ms: float | None = None

    def __post_init__(self) -> None:
        for key in (*self.figures, *self.intervals):
            if key not in COLUMN_OF:
                raise ValueError(f"figures: expected keys of COLUMNS, got {key!r}")
        for key, figure in self.figures.items():
            if figure is not None and not np.isfinite(figure):
                raise ValueError(f"figures: expected a finite number or None, got {key} {figure}")
        for name in ("roc", "precision_recall"):
            shape = np.shape(getattr(self, name))
            if len(shape) != 2 or shape[1] != 2:
                raise ValueError(f"{name}: expected (n, 2), got {shape}")

    def figure(self, column: Column) -> float | None:
        """Return what stands in a column."""
        return self.ms if column.key == "ms" else self.figures.get(column.key)


@dataclass(frozen=True, slots=True, eq=False)
class WallRow:
    """A frame, and every method's map of it.

    truth: (H, W) labels as large as the image: 255 salient, 0 not, else ignored.
    maps: (h, w) in [0, 1] by the method's name, ours first; of any size.
    threshold: above which a pixel of the first map is predicted salient.
    """

    caption: str
    rgb: Rgb
    truth: Labels
    maps: Mapping[str, Saliency]
    threshold: float = 0.5

    def __post_init__(self) -> None:
        if self.truth.shape != self.rgb.shape[:2]:
            raise ValueError(
                f"truth: expected {self.rgb.shape[:2]} like the image, got {self.truth.shape}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class ComparisonReport:
    """A comparison, told for a person; what is empty is left out of the page.

    sentence: what was found. facts: such as source, truth, frames, folds, seed and versions.
    problems: what went wrong. limits: what the comparison cannot tell.
    files: what else the folder holds, and what it is.
    reliability: (n, 2) curves by name: the probability told, and the share that is salient.
    """

    title: str
    sentence: str
    methods: Sequence[MethodResult]
    wall: Sequence[WallRow] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
    command: str = ""
    problems: Sequence[str] = ()
    limits: Sequence[str] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    reliability: Mapping[str, Curve] = field(default_factory=dict)
