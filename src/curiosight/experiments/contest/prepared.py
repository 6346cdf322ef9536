"""What of a source no strategy changes, on disk once and shared by memory map."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.datasets.layouts.rl_iac_tables import GRAPH_FILE, REGION_FILE
from curiosight.errors import DataError
from curiosight.errors.files import replace_file, writing
from curiosight.evaluation import TestView
from curiosight.explorer.outcome import Seen
from curiosight.frame import Pose, Viewpoint
from curiosight.learner.lesson import Lesson, Visit
from curiosight.learner.sight import Sight

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

META = "source.json"


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """One visit to a view: what it is to the learner, and what to the strategy."""

    visit: Visit
    seen: Seen | None


def save_array(path: Path, array: Array) -> None:
    """Write an array; raises `DataError` where it cannot be written."""
    with writing(path):
        try:
            np.save(path, array, allow_pickle=False)
        except OSError as error:
            if error.errno is None:  # so NumPy tells that not all of it was taken
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error
            raise


def new_table(path: Path, n: int) -> Floats:
    """Return an (n, n) array on disk, to be written row by row; raises `DataError`."""
    with writing(path):
        table: Floats = np.lib.format.open_memmap(  # type: ignore[no-untyped-call]
            path, "w+", np.float64, (n, n)
        )
        if hasattr(os, "posix_fallocate"):
            # Else a full disk would be told by a signal that ends the process.
            with path.open("r+b") as file:
                os.posix_fallocate(file.fileno(), 0, path.stat().st_size)
    return table


@contextmanager
def reading_prepared(folder: Path) -> Iterator[None]:
    """Turn what is wrong with the files of a prepared source into a `DataError`."""
    try:
        yield
    except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
        remedy = "remove this folder, and it is made again"
        raise DataError(folder, f"is not whole ({error})", remedy) from error


class Ragged:
    """Write and read arrays of many lengths as one, with where each begins."""

    def __init__(self, folder: Path, name: str) -> None:
        self._values, self._starts = folder / f"{name}.npy", folder / f"{name}-starts.npy"

    def write(self, arrays: Sequence[Array]) -> None:
        save_array(self._values, np.concatenate(list(arrays)))
        save_array(self._starts, np.cumsum([0, *(len(array) for array in arrays)]))

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        with reading_prepared(self._values.parent.parent):
            values, starts = np.load(self._values, mmap_mode="r"), np.load(self._starts)
            if starts[-1] != len(values):
                raise ValueError(f"{self._values.name} is not of {self._starts.name}")
            return values, starts

    def __len__(self) -> int:
        return len(self._arrays[1]) - 1

    def __getitem__(self, index: int) -> Array:
        values, starts = self._arrays
        return np.asarray(values[starts[index] : starts[index + 1]])


SHOWN_ARRAYS = (
    "rows",
    "salient",
    "other",
    "lesson-rows",
    "lesson-is-salient",
    "look",
    "pose",
    "rays",
    "up",
    "share",
    "points",
    "labels",
)
TEST_ARRAYS = ("rows", "salient", "other", "look", "pose")


class ShownViews:
    """The visits of all views, `n_visits` of each, read when they are asked for."""

    def __init__(self, folder: Path) -> None:
        self._arrays = {name: Ragged(folder, f"shown-{name}") for name in SHOWN_ARRAYS}

    def write(self, shown: Sequence[Shown]) -> None:
        """Write all visits."""
        columns = zip(*(_shown_arrays(one) for one in shown), strict=True)
        for name, arrays in zip(SHOWN_ARRAYS, columns, strict=True):
            self._arrays[name].write(arrays)

    def __len__(self) -> int:
        return len(self._arrays["rows"])

    def __getitem__(self, index: int) -> Shown:
        one = {name: ragged[index] for name, ragged in self._arrays.items()}
        sight = _sight(one["look"], one["pose"], one["rays"], one["up"])
        lesson = Lesson(one["lesson-rows"], one["lesson-is-salient"], sight, float(one["share"][0]))
        visit = Visit(one["rows"], (one["salient"], one["other"]), lesson)
        seen = Seen(one["points"], one["labels"]) if len(one["pose"]) else None
        return Shown(visit, seen)


def write_tests(folder: Path, tests: Sequence[TestView]) -> None:
    """Write what is tested on."""
    columns = zip(*(_test_arrays(view) for view in tests), strict=True)
    for name, arrays in zip(TEST_ARRAYS, columns, strict=True):
        Ragged(folder, f"test-{name}").write(arrays)


def read_tests(folder: Path) -> list[TestView]:
    """Read what is tested on."""
    arrays = {name: Ragged(folder, f"test-{name}") for name in TEST_ARRAYS}
    tests = []
    for index in range(len(arrays["rows"])):
        one = {name: ragged[index] for name, ragged in arrays.items()}
        sight = _sight(one["look"], one["pose"], None, one["pose"][:0])
        tests.append(TestView(one["rows"], one["salient"], one["other"], sight))
    return tests


def _shown_arrays(shown: Shown) -> list[Array]:
    visit, lesson = shown.visit, shown.visit.lesson
    sight, nothing = lesson.sight, np.empty((0, 3), np.float32)
    rays = nothing if sight is None or sight.rays is None else sight.rays
    up = np.empty(0) if sight is None or sight.up is None else sight.up
    points = nothing if shown.seen is None else shown.seen.points
    labels = np.empty(0, np.uint8) if shown.seen is None else shown.seen.labels
    of_lesson = [lesson.rows, lesson.is_salient, *_place_arrays(sight), rays, up]
    return [visit.rows, *visit.counts, *of_lesson, np.array([lesson.share]), points, labels]


def _test_arrays(view: TestView) -> list[Array]:
    return [view.rows, view.salient, view.other, *_place_arrays(view.sight)]


def _place_arrays(sight: Sight | None) -> tuple[Array, Array]:
    """Return the look and the pose of a view, empty where there is none."""
    look = np.empty(0, np.uint8) if sight is None else sight.look
    pose = None if sight is None else sight.T_world_camera
    return look, np.empty((0, 4)) if pose is None else pose


def _sight(look: Array, pose: Array, rays: Array | None, up: Array) -> Sight | None:
    if not len(look):
        return None
    if not len(pose):
        return Sight(look)
    return Sight(look, pose, rays, up if len(up) else None)


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """A source as it is from some look on.

    first_look: number of that look. shown: its visits. tests: what is tested on.
    test_places: (n,) number of the room of each test, -1 = not said; truth, for scoring only.
    offline: error and F1 of the off-line model, which learns one visit of every view at once.
    """

    first_look: int
    shown: ShownViews
    tests: list[TestView]
    test_places: list[int]
    offline: dict[str, float]

    def scored_places(self) -> Ints:
        """Return the room of each test frame that has an F1."""
        pairs = zip(self.tests, self.test_places, strict=True)
        return np.array([place for view, place in pairs if view.salient.any()], np.int64)


class Prepared:
    """A source whose views are described and labelled.

    folder: where `Preparation` wrote it. Raises `DataError` where files are damaged or lost.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with reading_prepared(folder):
            self._read(folder)

    def _read(self, folder: Path) -> None:
        self.meta: dict[str, Any] = json.loads((folder / META).read_text(encoding="utf-8"))
        self.n_visits: int = self.meta["visits"]
        self.ids: list[str] = self.meta["ids"]
        # Truth, for scoring only.
        self.places: list[int] = self.meta["places"]
        self.knows_places: bool = self.meta.get("knows_places", False)
        self.metres: Floats = np.load(folder / "metres.npy", mmap_mode="r")
        self.degrees: Floats = np.load(folder / "degrees.npy", mmap_mode="r")
        poses = np.load(folder / "poses.npy")
        self.poses: list[Pose | None] = [None if np.isnan(p).any() else p for p in poses]
        self.up: Floats | None = None if self.meta["up"] is None else np.array(self.meta["up"])
        table = folder / REGION_FILE
        # The source's own, of images that are called as in the source.
        self.region_table: Path | None = table if table.is_file() else None
        self.phases = [
            Phase(
                phase["first_look"],
                ShownViews(folder / f"phase{number}"),
                read_tests(folder / f"phase{number}"),
                phase["test_places"],
                phase["offline"],
            )
            for number, phase in enumerate(self.meta["phases"])
        ]

    def sights(self) -> Iterator[Sight | None]:
        """Yield what tells the place of each view, by its first visit before any change."""
        shown = self.phases[0].shown
        for index in range(len(self.ids)):
            yield shown[index * self.n_visits].visit.lesson.sight

    def ways(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> tuple[Floats, Floats]:
        """Return the (n,) metres and degrees of the ways to viewpoints."""
        to = [goal.index for goal in goals]
        return self.metres[start.index, to], self.degrees[start.index, to]


def keep_tables(table: Path, folder: Path) -> None:
    """Copy a source's table of regions, and the navigation graph beside it."""
    for name in (REGION_FILE, GRAPH_FILE):
        path = table.with_name(name)
        if path.is_file():
            replace_file(folder / name, path.read_bytes())


def write_meta(folder: Path, meta: dict[str, Any]) -> None:
    """Write the file that makes a prepared source whole."""
    replace_file(folder / META, json.dumps(meta, indent=1).encode())
