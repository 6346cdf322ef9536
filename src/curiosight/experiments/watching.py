"""Watch a source live: from a recording or a drive to the parts that run, and what is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config, to_toml
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.camera_start import FirstFrames
from curiosight.experiments.components import note_frames, place
from curiosight.experiments.deciding import DecisionsFile
from curiosight.experiments.keeping import Keeping
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.problems import Lessons, Problems
from curiosight.experiments.watch_parts import Asked, make_parts
from curiosight.learner.archive import MODEL, find_model
from curiosight.robot.advice import Advice
from curiosight.robot.feed import EndedError, Feed, Replay
from curiosight.robot.plan import Plan
from curiosight.robot.routes import Drive, rounds
from curiosight.robot.shown import Shown
from curiosight.robot.sinks.recorder import Recorder
from curiosight.robot.watch import Look, Watch
from curiosight.rooms.drawn_views import DrawnViews

LOOKS, DECISIONS = "looks.csv", "decisions.csv"
RESULTS = (MODEL, "summary.json", LOOKS, DECISIONS)
COLUMNS = ("look", "seconds", "id", "region", "error", "samples")


class Watching:
    """One watch of a recording, a drive or a camera, and the folder it writes.

    dataset: of a camera its `FirstFrames`, which more will follow.
    drawn: the views that were drawn, where the source is a drive: the explorer drives then, along
        its frames; else somebody has driven already, and it gives advice.
    has_learned: the looks changed what the model says. ended: why the source has no more frames.
    """

    def __init__(
        self,
        config: Config,
        dataset: Dataset,
        out: OutputFolder,
        asked: Asked,
        *,
        drawn: DrawnViews | None = None,
        keeping: Keeping | None = None,
    ) -> None:
        self.dataset, self.out, self.asked = dataset, out, asked
        self._keeping = keeping or Keeping()
        self.problems, self.lessons = Problems(), Lessons()
        self.has_learned = False
        self.ended: str | None = None
        self._ids: set[str] = set()
        self.seconds = 0.0
        parts = make_parts(config, dataset, asked, drawn)
        if isinstance(dataset, FirstFrames):
            dataset.let_go()
        self.config, self.learner, self.regions = parts.config, parts.learner, parts.regions
        drive = None if drawn is None else Drive(len(dataset))
        self.advice = Advice(parts.make_strategy, parts.views, parts.regions.names, drive=drive)
        self.watch = Watch(
            self.learner,
            _feed_of(dataset, drive),
            parts.teacher,
            is_learning=asked.is_learning,
            advice=self.advice,
            on_look=self._note,
        )
        outlines: Sequence[npt.NDArray[np.floating]] = () if drawn is None else drawn.outlines
        plan = Plan(parts.views, parts.regions.names, up=parts.up, outlines=outlines)
        title = f"{place(dataset)}: {'driven by' if drawn else 'advised by'} {self.strategy}"
        self.shown = Shown(self.watch, plan, title=title, save=self._save_now())
        self._views, self._title = parts.views, title
        self.recorders = [Recorder(self.watch, self.shown, sink) for sink in asked.sinks]
        outdated = self._outdated()
        if MODEL not in outdated:
            out.keep(MODEL)  # else it would go with all that the earlier command wrote
        out.remove(outdated)
        out.write_text("config.toml", to_toml(self.config))
        self._looks_file = TableFile(out.file(LOOKS), COLUMNS)
        self._decisions = DecisionsFile(out.file(DECISIONS), self.advice.strategy)

    def _outdated(self) -> list[str]:
        """Return what an earlier run may have left that would pass for this one's.

        The model that this one begins with stays, and so does one that it writes none instead of.
        """
        begun = self.asked.model and find_model(self.asked.model).resolve()
        if self.asked.is_learning and begun != (self.out.path / MODEL).resolve():
            return list(RESULTS)
        return [name for name in RESULTS if name != MODEL]

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
                if seconds is not None and passed_s >= seconds:
                    break
                yield passed_s
        finally:
            self.seconds = watch.seconds() or 0.0
            watch.stop()
            for recorder in self.recorders:
                recorder.stop()
        if isinstance(watch.failure, EndedError):
            self.ended = str(watch.failure)
        elif watch.failure is not None:
            raise watch.failure

    def _note(self, look: Look) -> None:
        """Write a look to the tables, and the model now and then; in the learning thread."""
        frame, segmentation = look.verdict.shot.frame, look.verdict.segmentation
        # Frames of a recording come again; those of a camera would be ever more.
        comes_again = not isinstance(self.dataset, FirstFrames)
        if comes_again:
            self.problems.add_told(frame, segmentation)
        if self.asked.is_learning:
            self.lessons.add(frame, segmentation)
            self.has_learned |= look.n_regrown > 0
            if comes_again:
                self._ids.add(frame.id)
        index = look.verdict.shot.index
        region = -1 if index is None else int(self.regions.of_view[index])
        row = {
            "look": look.number,
            "seconds": look.seconds,
            "id": frame.id,
            "region": region,
            "error": look.error,
            "samples": self.learner.n_samples,
        }
        self._looks_file.add(row)
        for recorder in self.recorders:
            recorder.note(row)
        self._decisions.add(look.number)
        if self.asked.is_learning and self._keeping.is_due():
            with self._keeping.writing(), suppress(DataError):
                self.save(is_packed=False)

    def _save_now(self) -> Callable[[], str] | None:
        """Return what the page's button does: nothing where the model does not change."""
        if not self.asked.is_learning:
            return None
        return lambda: str(self.watch.model_do(lambda _: self.save()))

    def save(self, *, is_packed: bool = True) -> Path:
        """Write the model; while it runs only where nothing changes it."""
        if self._ids:
            note_frames(self.learner, self.dataset, self._ids)
        path = self.out.file(MODEL)
        self.learner.save(path, is_packed=is_packed)
        return path

    def finish(self) -> dict[str, Any]:
        """Write the model, where it learned, and the summary; return the summary."""
        self._looks_file.close()
        self._decisions.close()
        if self.asked.is_learning:
            self.save()
        summary = self._summary()
        self.out.write_json("summary.json", summary)
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


def _feed_of(dataset: Dataset, drive: Drive | None) -> Feed:
    if isinstance(dataset, FirstFrames):
        return dataset.rest
    return Replay(dataset, rounds(len(dataset)) if drive is None else drive)
