"""What a report tells; every text is plain text, escaped when the page is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from curiosight.explorer.decision import Decision
from curiosight.explorer.from_above import FromAbove
from curiosight.viewing.examples import Example
from curiosight.viewing.figures import StepRecord

Points = npt.NDArray[np.floating]


class ReportStep(StepRecord, Protocol):
    """A step as the report needs it; a line of steps.csv, for instance."""

    @property
    def learning_progress(self) -> float | None: ...


@dataclass(frozen=True, slots=True)
class ResultRow:
    """A line of a result table.

    values: one for each column, as they are to be read. note: what the line means, in words.
    """

    name: str
    values: tuple[str, ...]
    note: str = ""


@dataclass(frozen=True, slots=True)
class Results:
    """A short table of results, each column but the first named by `columns`."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[ResultRow, ...]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row.values) != len(self.columns):
                raise ValueError(
                    f"rows: expected {len(self.columns)} values in {row.name!r}, "
                    f"got {len(row.values)}"
                )


@dataclass(frozen=True, slots=True)
class ExampleGroup:
    """Examples of one kind, such as views that were never learned from."""

    title: str
    examples: Sequence[Example]


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """What a thing covers of the floor: a polygon of (n, 2) metres on the map's axes."""

    name: str
    polygon: Points
    is_object: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class RoomMap:
    """Where the views are, seen from above, and which of them were looked at.

    region_of_view: (n_views,) int; -1 = in no region.
    visited: the view of each step, in order.
    outlines: (n, 2) metres each, the polygons of the walls; none where they are not known.
    """

    views: FromAbove
    region_of_view: npt.NDArray[np.int64]
    visited: Sequence[int]
    outlines: Sequence[Points] = ()
    footprints: Sequence[Footprint] = ()

    def __post_init__(self) -> None:
        n_views = len(self.views.positions)
        if len(self.region_of_view) != n_views:
            raise ValueError(
                f"region_of_view: expected one for each of {n_views} views, "
                f"got {len(self.region_of_view)}"
            )


@dataclass(frozen=True, slots=True)
class Making:
    """How a run was made, so that it can be made again.

    facts: such as seed and versions. settings: all of them, as a text to fold out.
    times_ms: milliseconds per stage of a step; measured, so that no two runs have the same.
    files: what else the run's folder holds, and what it is.
    """

    command: str
    facts: Mapping[str, str] = field(default_factory=dict)
    settings: str = ""
    times_ms: Mapping[str, float] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """A run, told for a person; what is empty or None is left out of the page.

    sentence: what happened. took: how long, apart from it as no two runs take the same time.
    region_names: of the regions that `steps` and `room_map` number. region_note: a sentence that
        tells how to read these names.
    decisions: why it went where it went, each with the step that it led to.
    events: what changed while it ran. problems: what went wrong. limits: what the report cannot
        tell.
    """

    title: str
    sentence: str
    took: str = ""
    results: Sequence[Results] = ()
    examples: Sequence[ExampleGroup] = ()
    steps: Sequence[ReportStep] = ()
    region_names: Sequence[str] = ()
    region_note: str = ""
    decisions: Sequence[tuple[int, Decision]] = ()
    events: Sequence[str] = ()
    room_map: RoomMap | None = None
    making: Making | None = None
    problems: Sequence[str] = ()
    limits: Sequence[str] = ()
