"""The page that tells what a run did, in one file that needs nothing else: `report.html`."""

from curiosight.viewing.report.content import (
    ExampleGroup,
    Footprint,
    Making,
    Report,
    ReportStep,
    ResultRow,
    Results,
    RoomMap,
)
from curiosight.viewing.report.page import report_html, write_report

__all__ = [
    "ExampleGroup",
    "Footprint",
    "Making",
    "Report",
    "ReportStep",
    "ResultRow",
    "Results",
    "RoomMap",
    "report_html",
    "write_report",
]
