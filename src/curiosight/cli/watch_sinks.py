"""What a watch is to be told to besides its page: a log, a viewer; and what became of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.cli.talk import Talk
from curiosight.experiments.live_log import live_log
from curiosight.robot.sinks.recorder import Recorder
from curiosight.robot.sinks.rerun_view import RerunView
from curiosight.robot.sinks.sink import Sink


class SinksAsked:
    """A log and a viewer that are asked for; None = neither."""

    def __init__(self, talk: Talk, mcap: Path | None, viz: str | None, *, overwrite: bool) -> None:
        self._talk, self._mcap, self._viz, self._overwrite = talk, mcap, viz, overwrite

    def open(self, source: Path) -> tuple[Sink, ...]:
        """Return them; a log that cannot be is refused, a viewer is warned of."""
        sinks: list[Sink] = []
        if self._mcap is not None:
            sinks.append(live_log(self._mcap, source, overwrite=self._overwrite))
        if self._viz is not None:
            try:
                sinks.append(RerunView(self._viz))
            except ImportError as error:
                self._talk.warn(f"no viewer: {error}; pip install 'curiosight[viz]'")
        return tuple(sinks)


class SinkTrouble:
    """Warn once of each sink that takes no more."""

    def __init__(self, talk: Talk, recorders: Sequence[Recorder]) -> None:
        self._talk, self._recorders = talk, recorders
        self._told: set[str] = set()

    def tell(self) -> None:
        for recorder in self._recorders:
            name = recorder.sink.name
            if recorder.problem is not None and name not in self._told:
                self._told.add(name)
                self._talk.warn(f"{name} is told no more, the watch goes on: {recorder.problem}")


def recorded(recorders: Sequence[Recorder]) -> dict[str, str]:
    """Return rows of what was written, and what was left out."""
    return {recorder.sink.name: _written(**recorder.counts()) for recorder in recorders}


def _written(maps: int, maps_left_out: int, looks: int, looks_lost: int) -> str:
    lost = f", {looks_lost} lost" if looks_lost else ""
    return f"{maps} maps, {maps_left_out} left out; {looks} looks{lost}"
