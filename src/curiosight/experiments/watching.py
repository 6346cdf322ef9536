"""Watch a source live: from a recording or a drive to the parts that run, and what is kept."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.camera_start import FirstFrames
from curiosight.experiments.command_file import GivenWatch
from curiosight.experiments.components import note_frames, place
from curiosight.experiments.handing_on import Continued, own_regions
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.snapshot import STATE
from curiosight.experiments.watch_keeping import CONFIG, RESULTS, SUMMARY, WatchKeeper
from curiosight.experiments.watch_parts import Asked, Parts, make_parts
from curiosight.experiments.watched import LookRecord, Watched
from curiosight.explorer import Regions
from curiosight.learner.archive import MODEL, find_model
from curiosight.robot.advice import Advice
from curiosight.robot.feed import EndedError, Feed, Replay
from curiosight.robot.plan import Plan
from curiosight.robot.routes import Drive, rounds
from curiosight.robot.shown import Shown
from curiosight.robot.sinks.recorder import Recorder
from curiosight.robot.watch import Look, Watch
from curiosight.rooms.drawn_views import DrawnViews

# Of the time of all cores that it uses the state may take so much, and so may the model.
SHARE = 0.0025


class Watching:
    """One watch of a recording, a drive or a camera, and the folder it writes.

    dataset: of a camera its `FirstFrames`, which more will follow.
    drawn: the views that were drawn, where the source is a drive: the explorer drives then, along
        its frames; else somebody has driven already, and it gives advice.
    given: the command that it can be gone on with by; None = no state is kept for that.
    is_resumed: it goes on where a kill or Ctrl-C ended the watch of this folder, made with the
        same arguments.
    ended: why the source has no more frames. is_in_time: the seconds that it was to last are over.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        asked: Asked,
        *,
        drawn: DrawnViews | None = None,
        given: GivenWatch | None = None,
        is_resumed: bool = False,
    ) -> None:
        self.dataset, self.out, self.asked = dataset, out, asked
        self._keeping = Keeping(max_share=SHARE, clock=time.process_time)
        self._saving = Keeping(max_share=SHARE, clock=time.process_time)
        self.ended: str | None = None
        self.is_in_time = False
        is_kept = is_resumed and (out.path / STATE).is_file()
        self.continued: Continued | None = None
        if asked.model is not None and not is_kept:
            version = "" if given is None else given.version
            self.continued = Continued(find_model(asked.model), config, dataset, version)
        regions = self._known_regions(is_kept=is_kept)
        if is_kept and asked.is_learning:
            asked = replace(asked, model=None)  # the state holds what has come of it
        parts = make_parts(config, dataset, asked, drawn, regions)
        self.config, self.learner, self.regions = parts.config, parts.learner, parts.regions
        drive = None if drawn is None else Drive(len(dataset))
        self.advice = Advice(parts.make_strategy, parts.views, parts.regions.names, drive=drive)
        self.keeper = WatchKeeper(
            out, parts, self.advice, dataset, given, is_learning=asked.is_learning
        )
        if self.continued is not None:
            self.continued.tell(self.advice.strategy, self.advice.views, parts.ways)
            self.continued.remember(self.keeper.remembering)
        self._make_room(is_kept=is_kept)
        self.keeper.begin(is_kept=is_kept)
        self.watch = Watch(
            self.learner,
            _feed_of(dataset, drive, self.so_far.index),
            parts.teacher,
            is_learning=asked.is_learning,
            advice=self.advice,
            on_look=self._note,
        )
        self.watch.go_on(self.so_far.counts, self.so_far.ages, self.so_far.events)
        self.seconds = self.so_far.counts.seconds
        self.keeper.keep(self.watch)
        if not is_kept:
            self.keeper.write_beginning()
        if isinstance(dataset, FirstFrames):
            dataset.let_go()
        self._show(parts, drawn)

    def _known_regions(self, *, is_kept: bool) -> Regions | None:
        """Return the regions that were handed on; None where the source is to be divided."""
        if self.continued is not None:
            return self.continued.regions()
        if self.asked.model is not None and is_kept:
            return own_regions(self.out.path / STATE, self.dataset)
        return None

    def _show(self, parts: Parts, drawn: DrawnViews | None) -> None:
        """Make what a page, a log and a viewer show."""
        outlines: Sequence[npt.NDArray[np.floating]] = () if drawn is None else drawn.outlines
        plan = Plan(parts.views, parts.regions.names, up=parts.up, outlines=outlines)
        title = f"{place(self.dataset)}: {'driven by' if drawn else 'advised by'} {self.strategy}"
        self.shown = Shown(self.watch, plan, title=title, save=self._save_now())
        self._views, self._title = parts.views, title
        self.recorders = [Recorder(self.watch, self.shown, sink) for sink in self.asked.sinks]

    def _make_room(self, *, is_kept: bool) -> None:
        """Remove what an earlier run left that would pass for this one's.

        The model that this one begins with stays, and so does one that it writes none instead of.
        """
        names = list(RESULTS)
        begun = self.asked.model and find_model(self.asked.model).resolve()
        if not self.asked.is_learning or begun == (self.out.path / MODEL).resolve():
            names.remove(MODEL)
            self.out.keep(MODEL)  # else it would go with all that the earlier command wrote
        self.out.hold()
        self.out.remove_half_written()
        self.out.remove([SUMMARY] if is_kept else names)
        if not is_kept:
            self.out.write_text(CONFIG, to_toml(self.config))

    @property
    def so_far(self) -> Watched:
        """What the watch has come to."""
        return self.keeper.so_far

    @property
    def problems(self) -> Problems:
        return self.so_far.problems

    @property
    def lessons(self) -> Lessons:
        return self.so_far.lessons

    @property
    def has_learned(self) -> bool:
        """Tell whether the looks so far changed what the model says."""
        return self.so_far.has_learned

    @property
    def strategy(self) -> str:
        return self.config.explorer.strategy

    def run(self, seconds: float | None, is_wanted: Callable[[], bool]) -> Iterator[float]:
        """Run until so many seconds after the first map, None = without end, or it is not wanted.

        Yield the seconds since the first map now and then; 0 before it. Raises what went wrong.
        """
        watch = self.watch
        watch.start()
        for recorder in self.recorders:
            recorder.start(self._title, self._views)
        try:
            while is_wanted() and not watch.wait(0.1):
                passed_s = watch.seconds() or 0.0
                self.keeper.sync_if_due()
                if seconds is not None and passed_s >= seconds:
                    self.is_in_time = True
                    break
                yield passed_s
        finally:
            watch.stop()
            self.seconds = watch.counts().seconds
            for recorder in self.recorders:
                recorder.stop()
        if isinstance(watch.failure, EndedError):
            self.ended = str(watch.failure)
        elif watch.failure is not None:
            raise watch.failure

    def _note(self, look: Look) -> None:
        """Keep a look, and all of it now and then; in the learning thread."""
        record = LookRecord.of(look, self.advice.pinned_then, self.watch.counts())
        row = self.keeper.note(record)
        for recorder in self.recorders:
            recorder.note(row)
        if self._keeping.is_due() or self.keeper.is_full:
            with self._keeping.writing(), suppress(DataError), self.watch.learning:
                self.keeper.keep(self.watch)
        if self.asked.is_learning and self._saving.is_due():
            with self._saving.writing(), suppress(DataError), self.watch.learning:
                self.save(is_packed=False)

    def _save_now(self) -> Callable[[], str] | None:
        """Return what the page's button does: nothing where the model does not change."""
        if not self.asked.is_learning:
            return None
        return lambda: str(self.watch.model_do(lambda _: self.save()))

    def save(self, *, is_packed: bool = True) -> Path:
        """Write the model; while it runs only where nothing changes it."""
        if self.so_far.ids:
            note_frames(self.learner, self.dataset, self.so_far.ids)
        path = self.out.file(MODEL)
        self.learner.save(path, is_packed=is_packed)
        return path

    def finish(self) -> dict[str, Any]:
        """Write the model, where it learned, the summary, and what it takes to go on.

        Return the summary.
        """
        self.keeper.close()
        if self.asked.is_learning:
            self.save()
        summary = self._summary()
        self.out.write_json(SUMMARY, summary)
        self.keeper.finish(self.watch)
        return summary

    def _summary(self) -> dict[str, Any]:
        watch, seconds = self.watch, self.seconds
        rate = {"maps": watch.maps.n, "learned": watch.lessons.n}
        return {
            "source": place(self.dataset),
            "model": None if self.asked.model is None else str(self.asked.model),
            "strategy": self.strategy,
            "seed": self.config.run.seed,
            "seconds": round(seconds, 2),
            "ended": self._why_ended(),
            **rate,
            "looks": watch.looks.n,
            "map_hz": round(watch.maps.n / seconds, 2) if seconds else None,
            "learn_hz": round(watch.lessons.n / seconds, 2) if seconds else None,
            "map_age_p50_ms": watch.ages.percentile_ms(50),
            "map_age_p99_ms": watch.ages.percentile_ms(99),
            "dropped": watch.n_dropped,
            "regions": self.advice.regions(),
            "goal": self.advice.goal,
            "why": self.advice.why(),
            "alarms": [event.summary() for event in watch.events],
            "recorded": {one.sink.name: one.counts() for one in self.recorders},
            "problems": self.problems.counts(),
            "taught_nothing": self.lessons.summary() if self.asked.is_learning else None,
        }

    def _why_ended(self) -> str | None:
        """Say why it was over by itself; None where it was not, and can be gone on with."""
        in_time = "the seconds that it was to last are over" if self.is_in_time else None
        return self.ended or in_time


def _feed_of(dataset: Dataset, drive: Drive | None, before: int | None) -> Feed:
    """Return what gives the frames; before: the number of the one that was looked at last."""
    if isinstance(dataset, FirstFrames):
        return dataset.rest
    if drive is None:
        return Replay(dataset, rounds(len(dataset), 0 if before is None else before + 1))
    if before is not None:
        drive.stand_at(before)
    return Replay(dataset, drive)
