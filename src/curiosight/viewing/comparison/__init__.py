"""How a comparison of methods is shown: tables, curves, a wall of maps, and a page of them all."""

from curiosight.viewing.comparison.confusion import confusion
from curiosight.viewing.comparison.content import (
    COLUMNS,
    Column,
    ComparisonReport,
    MethodResult,
    WallRow,
)
from curiosight.viewing.comparison.figures import draw_precision_recall, draw_roc, draw_wall
from curiosight.viewing.comparison.page import comparison_html, write_comparison
from curiosight.viewing.comparison.tables import latex_table, markdown_table

__all__ = [
    "COLUMNS",
    "Column",
    "ComparisonReport",
    "MethodResult",
    "WallRow",
    "comparison_html",
    "confusion",
    "draw_precision_recall",
    "draw_roc",
    "draw_wall",
    "latex_table",
    "markdown_table",
    "write_comparison",
]
