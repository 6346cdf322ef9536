"""What a watch is to be told to besides its page: a log, a viewer; and what became of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from curiosight.cli.talk import Talk
from curiosight.experiments.live_log import live_log
from curiosight.robot.sinks.recorder import Recorder
from curiosight.robot.sinks.rerun_view import RerunView
from curiosight.robot.sinks.sink import Sink


def open_sinks(
    talk: Talk, source: Path, mcap: Path | None, viz: str | None, *, overwrite: bool
) -> tuple[Sink, ...]:
    """Return what is asked for; a log that cannot be is refused, a viewer is warned of."""
    sinks: list[Sink] = []
    if mcap is not None:
        sinks.append(live_log(mcap, source, overwrite=overwrite))
    if viz is not None:
        try:
            sinks.append(RerunView(viz))
        except ImportError as error:
            talk.warn(f"no viewer: {error}; pip install 'curiosight[viz]'")
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
