"""What a run hands on to one that continues it: regions, looks, and what its teacher remembers.

It is taken up where the rooms are the same: where the frames are, or the home that is drawn. What
is told of a view is then told of the view nearest to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.camera_start import FirstFrames
from curiosight.experiments.components import place
from curiosight.experiments.driving import parse_drawn
from curiosight.experiments.snapshot import STATE, fingerprint, read_first
from curiosight.explorer import Regions, Strategy
from curiosight.explorer.ground import Ways
from curiosight.explorer.outcome import Outcome
from curiosight.frame import Pose, Viewpoint
from curiosight.learner.archive import MODEL
from curiosight.rooms import HomeSettings
from curiosight.teacher import TemporalTeacher
from curiosight.teacher.things.nearest_points import nearest_points
from curiosight.worlds import is_drawn

# Looks that are told to a strategy of a run that continues this one.
N_LOOKS = 3000
# A view is beside another whose place, metres, and optical axis differ by less.
MAX_APART = 1.5
Array = npt.NDArray[Any]


class RecentLooks:
    """The last looks, in their order, in memory that does not grow."""

    def __init__(self, most: int = N_LOOKS) -> None:
        self.n = 0
        self._views, self._errors = np.zeros(most, np.int32), np.full(most, np.nan)
        self._has_changed = np.zeros(most, np.bool_)

    def add(self, view: int, error: float | None, *, has_changed: bool = False) -> None:
        """Take note of a look at a view, by its index; error: None = undefined."""
        at = self.n % len(self._views)
        self._views[at], self._errors[at] = view, np.nan if error is None else error
        self._has_changed[at] = has_changed
        self.n += 1

    def __iter__(self) -> Iterator[tuple[int, float | None, bool]]:
        """Yield view, error, and whether the place had changed, of each, the oldest first."""
        most = len(self._views)
        for number in range(max(0, self.n - most), self.n):
            at = number % most
            error = float(self._errors[at])
            is_known = not np.isnan(error)
            yield int(self._views[at]), error if is_known else None, bool(self._has_changed[at])


@dataclass(frozen=True, slots=True, eq=False)
class Rooms:
    """What a run was in, for another to tell whether it is there, too.

    source: see `place`. frames: stands for its frames, with their poses. stands: (n, 6) of each
    view, where its camera is and its optical axis, NaN without a pose. spec: the setting that made
    the regions. teacher: the settings of the teacher.
    """

    source: str
    frames: str
    stands: npt.NDArray[np.float32]
    regions: Regions
    spec: str
    teacher: str

    @classmethod
    def of(cls, config: Config, dataset: Dataset, regions: Regions) -> Self:
        frames, stands = _frames_of(dataset), _stands_of(dataset.poses)
        spec, teacher = config.explorer.regions, repr(config.teacher)
        return cls(place(dataset), frames, stands, regions, spec, teacher)


@dataclass(frozen=True, slots=True, eq=False)
class HandedOn:
    """What a run hands on. memory: see `TemporalTeacher.memory`; None = its teacher has none."""

    rooms: Rooms
    looks: RecentLooks
    memory: tuple[Any, ...] | None


class Continued:
    """What an earlier run hands on to one over a dataset, as far as the rooms are the same.

    model: the file that is gone on with; its run's state lies beside it.
    notes: what is gone on with, and what begins anew and why, a sentence each.
    Raises `DataError` for a state that is damaged.
    """

    def __init__(self, model: Path, config: Config, dataset: Dataset, version: str) -> None:
        self.notes: list[str] = []
        self._config, self._dataset = config, dataset
        self._before = self._read(model, version)
        # Of each view of now the one of then that it is beside, and the other way; -1 = none.
        self._then, self._now = (
            (np.empty(0, int),) * 2
            if self._before is None
            else _beside(self._before.rooms, dataset)
        )

    def _read(self, model: Path, version: str) -> HandedOn | None:
        """Return what is handed on to the same rooms; None, and a note, where nothing is."""
        state, anew = model.parent / STATE, "regions, their progress and the teacher's memory begin"
        if model.name != MODEL or not state.is_file():
            self.notes.append(f"{anew} anew: {model} has no {STATE} beside it")
            return None
        written_by, found = read_first(state)
        if written_by != version:
            self.notes.append(f"{anew} anew: they are of curiosight {written_by}")
            return None
        if not isinstance(found, HandedOn):
            raise DataError(state, "holds no usable state", "give the model file by itself")
        if _is_same(found.rooms, self._dataset):
            return found
        self.notes.append(f"{anew} anew: {found.rooms.source} shows other rooms")
        return None

    def regions(self) -> Regions | None:
        """Return the regions of then for the views of now; None = they are to be divided anew."""
        before, asked = self._before, self._config.explorer.regions
        if before is None:
            return None
        if asked and asked != before.rooms.spec:
            self.notes.append(f"regions begin anew: {asked} is asked for")
            return None
        if (self._then < 0).any():
            self.notes.append("regions begin anew: some views are of where there was none")
            return None
        regions = _with_views(before.rooms.regions, self._then)
        self.notes.append(f"{regions.n_regions} regions are those of that run")
        return regions

    def tell(self, strategy: Strategy, views: Sequence[Viewpoint], ways: Ways | None) -> None:
        """Tell a strategy of the looks of then, as of looks that others chose."""
        if self._before is None:
            return
        of_index, here, n_told = {view.index: view for view in views}, None, 0
        looks = list(self._before.looks)
        for then, error, has_changed in looks:
            now = int(self._now[then]) if then < len(self._now) else -1
            view = of_index.get(now)
            if view is None or view.region < 0:
                continue
            is_known = ways is not None and here is not None
            seconds = float(ways(here, [view])[0]) if is_known else 0.0  # type: ignore[misc,arg-type]
            strategy.update(view, Outcome(error, seconds, has_changed=has_changed))
            here, n_told = view, n_told + 1
        if n_told:
            self.notes.append(f"progress of regions goes on, by the last {n_told} looks")
        else:
            self.notes.append("progress of regions begins anew: no look was at these views")

    def remember(self, teacher: TemporalTeacher | None) -> None:
        """Let a teacher remember what that of then does."""
        before = self._before
        if before is None or teacher is None:
            return
        anew = "what the teacher remembers begins anew"
        if before.memory is None:
            self.notes.append(f"{anew}: that one remembered nothing")
        elif before.rooms.teacher != repr(self._config.teacher):
            self.notes.append(f"{anew}: it is taught otherwise now")
        else:
            teacher.recall(before.memory)  # type: ignore[arg-type]
            self.notes.append("the teacher remembers what it did")


def own_regions(state: Path, dataset: Dataset) -> Regions | None:
    """Return the regions of a run that is gone on with; None where they are of other views."""
    _, found = read_first(state)
    is_fit = isinstance(found, HandedOn) and len(found.rooms.regions.of_view) == len(dataset)
    return found.rooms.regions if is_fit else None


def _frames_of(dataset: Dataset) -> str:
    poses = [b"" if pose is None else np.asarray(pose, float).tobytes() for pose in dataset.poses]
    return fingerprint([*dataset.ids, *(pose.hex() for pose in poses)])


def _stands_of(poses: Sequence[Pose | None]) -> npt.NDArray[np.float32]:
    nowhere = np.full(6, np.nan)
    stands = [nowhere if pose is None else np.append(pose[:3, 3], pose[:3, 2]) for pose in poses]
    return np.array(stands, np.float32).reshape(-1, 6)


def _is_same(before: Rooms, dataset: Dataset) -> bool:
    """Tell whether the rooms of a run are those of a dataset.

    Frames without any pose may have the same names anywhere: they must be in the same place. What
    a camera sees first is never the same.
    """
    if isinstance(dataset, FirstFrames):
        return False
    if before.frames == _frames_of(dataset):
        return bool(np.isfinite(before.stands).any()) or before.source == place(dataset)
    home = _home_of(place(dataset))
    return home is not None and home == _home_of(before.source)


def _home_of(source: str) -> tuple[Any, ...] | None:
    """Return what tells a drawn home or room from others, however it is lit and looked at."""
    if not is_drawn(source):
        return None
    drawn = parse_drawn(source)
    if isinstance(drawn, HomeSettings):
        return "home", drawn.seed, drawn.rooms, drawn.empty, drawn.furniture
    return "room", drawn.seed, drawn.plan, drawn.over, drawn.furniture


def _beside(before: Rooms, dataset: Dataset) -> tuple[Array, Array]:
    """Return of each view of now the one of then that it is beside, and the other way."""
    now = _stands_of(dataset.poses)
    if before.frames == _frames_of(dataset):
        return (np.arange(len(now)),) * 2
    return _nearest(now, before.stands), _nearest(before.stands, now)


def _nearest(views: Array, among: Array) -> Array:
    """Return (n,) which of some (m, 6) views is nearest to each; -1 = none is near."""
    posed = np.flatnonzero(np.isfinite(among).all(axis=1))
    found = np.full(len(views), -1)
    asked = np.flatnonzero(np.isfinite(views).all(axis=1))
    if len(posed) and len(asked):
        apart, place_of = nearest_points(among[posed], views[asked])
        is_near = apart <= MAX_APART
        found[asked[is_near]] = posed[place_of[is_near]]
    return found


def _with_views(regions: Regions, then: Array) -> Regions:
    """Return regions of views that are beside others; those without any are left out."""
    of_view = regions.of_view[then]
    left = np.unique(of_view[of_view >= 0])
    number = np.full(regions.n_regions + 1, -1)
    number[left] = np.arange(len(left))
    names = tuple(regions.names[region] for region in left)
    seconds = None if regions.seconds is None else regions.seconds[np.ix_(left, left)]
    return Regions(number[of_view], names, regions.kind, seconds)
