"""A watch as a page shows it: state, pictures, switches."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import cv2

from curiosight.robot.pictures import draw_labels, draw_map, to_jpeg
from curiosight.robot.plan import Plan
from curiosight.robot.state import ENDED, FROZEN, KEYS, PAUSED, PREPARING, RUNNING
from curiosight.robot.told import Verdict
from curiosight.robot.watch import Mapped, Watch

# How unsure a map is takes longer than the map: no oftener than this.
UNSURE_EVERY_S = 1.0
PICTURES = ("colour", "teacher", "saliency", "uncertainty")


class Shown:
    """What there is to see of a watch.

    title: what is watched. save: writes the model, and says where; None = there is nothing to
    write, as nothing is learned.
    """

    def __init__(
        self,
        watch: Watch,
        plan: Plan,
        *,
        title: str = "",
        save: Callable[[], str] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._watch, self._plan, self._title = watch, plan, title
        self._save, self._clock = save, clock
        self._drawing = threading.Lock()
        self._mapped: Mapped | None = None
        self._given: set[str] = set()
        self._drawn: dict[str, tuple[object, float, bytes]] = {}

    def state(self) -> dict[str, Any]:
        watch, advice = self._watch, self._watch.advice
        values: dict[str, Any] = dict.fromkeys(KEYS)
        values["state"] = self._word()
        if watch.first_at is not None:
            values |= {
                "map_hz": _rounded(watch.maps.per_second()),
                "learn_hz": _rounded(watch.lessons.per_second()),
                "map_age_s": _rounded(watch.map_age_s),
                "dropped": watch.n_dropped,
            }
        values["alarms"] = [event.summary() for event in watch.events]
        values["model_age_s"] = _rounded(watch.model_age_s)
        if advice is not None:
            why = advice.why()
            goal = None if why is None else why["chosen"]
            values |= {"regions": advice.regions(), "goal": goal, "why": why}
        return values

    def _word(self) -> str:
        watch = self._watch
        if watch.is_over:
            return ENDED
        if watch.first_at is None:
            return PREPARING
        if watch.is_paused:
            return PAUSED
        return FROZEN if watch.is_frozen else RUNNING

    def live(self) -> dict[str, Any]:
        watch, advice = self._watch, self._watch.advice
        mapped = watch.mapped
        shot = None if mapped is None else mapped.shot
        target = None if advice is None else advice.target()
        return {
            "note": self._title,
            "is_paused": watch.is_paused,
            "is_frozen": watch.is_frozen,
            "is_learning": watch.is_learning,
            "can_save": self._save is not None,
            "pinned": None if advice is None else advice.pinned,
            "frame": None if shot is None else shot.frame.id,
            "n_maps": watch.maps.n,
            "n_looks": watch.looks.n,
            "n_learned": watch.lessons.n,
            "map_age_p99_s": _seconds(watch.ages.percentile_ms(99)),
            "robot": None if shot is None else self._plan.robot(shot.index),
            "target": None if target is None else self._plan.robot(target.index),
            "curves": None if advice is None else advice.curves(),
        }

    def plan(self) -> dict[str, Any]:
        return self._plan.content()

    def picture(self, name: str) -> bytes | None:
        """Return colour, teacher, saliency or uncertainty of the newest frame, as JPEG.

        Those that are asked for in turn are of one frame, what the teacher says of the last that
        it has seen; who asks for the same again gets the newest. How unsure a map is is drawn once
        a second.
        """
        if name not in PICTURES:
            return None
        with self._drawing:  # one at a time, however many look
            if name in self._given or self._mapped is None:
                self._mapped, self._given = self._watch.mapped, set()
            self._given.add(name)
            source = self._watch.verdict if name == "teacher" else self._mapped
            if source is None:
                return None
            key, drawn_at, jpeg = self._drawn.get(name, (None, 0.0, b""))
            is_fresh = name == "uncertainty" and self._clock() - drawn_at < UNSURE_EVERY_S
            if key is not source and not (jpeg and is_fresh):
                jpeg = self._draw(name, source)
                self._drawn[name] = source, self._clock(), jpeg
            return jpeg

    def _draw(self, name: str, source: Mapped | Verdict) -> bytes:
        watch, frame = self._watch, source.shot.frame
        if isinstance(source, Verdict):
            return to_jpeg(draw_labels(frame.rgb, source.segmentation.labels))
        if name == "colour":
            return to_jpeg(frame.rgb)
        if name == "saliency":
            return to_jpeg(draw_map(source.saliency))
        description = watch.learner.describe(frame.rgb)
        unsure = watch.learner.unsure(description, frame.T_world_camera)
        return to_jpeg(draw_map(unsure[description.row_of_pixel], colours=cv2.COLORMAP_MAGMA))

    def command(self, name: str, value: Any) -> str:
        if name == "pause":
            self._watch.is_paused = _switch(name, value)
            return "paused" if value else "goes on"
        if name == "freeze":
            self._watch.is_frozen = _switch(name, value)
            return "the model stays as it is" if value else "learns again"
        if name == "pin":
            return self._pin(value)
        if name == "save":
            if self._save is None:
                raise ValueError("save: expected a watch that learns; this one changes no model")
            return f"saved to {self._save()}"
        raise ValueError(f"command: expected pause, freeze, pin or save, got {name!r}")

    def _pin(self, value: Any) -> str:
        if self._watch.advice is None:
            raise ValueError("pin: expected a source with regions, this one has none")
        if value is not None and (isinstance(value, bool) or not isinstance(value, int)):
            raise ValueError(f"pin: expected the id of a region or null, got {value!r}")
        self._watch.advice.pin(value)
        return "unpinned" if value is None else f"pinned region {value}"


def _switch(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{name}: expected true or false, got {value!r}")
    return value


def _rounded(number: float | None) -> float | None:
    return None if number is None else round(number, 3)


def _seconds(ms: int | None) -> float | None:
    return None if ms is None else ms / 1000
