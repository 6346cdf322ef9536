"""What a contest of strategies found: figures, tables and a page."""

from curiosight.viewing.contest.content import ContestReport, SourceReport
from curiosight.viewing.contest.figures import (
    BandOfErrors,
    draw_errors,
    draw_time_per_region,
    draw_times,
)
from curiosight.viewing.contest.page import write_contest
from curiosight.viewing.contest.tables import leaderboard, markdown_tables

__all__ = [
    "BandOfErrors",
    "ContestReport",
    "SourceReport",
    "draw_errors",
    "draw_time_per_region",
    "draw_times",
    "leaderboard",
    "markdown_tables",
    "write_contest",
]
