"""What a node tells about itself, once a second, in a thread of its own."""

from __future__ import annotations

import threading
import time
from typing import Any

from curiosight.experiments.ros.learning import Learning
from curiosight.experiments.ros.outputs import ERROR, OK, WARN
from curiosight.experiments.ros.owner import Owner
from curiosight.robot.watch import Watch

PERIOD_S = 1.0
# After the activation others have so long to be found.
GRACE_S = 2.0
Row = tuple[str, int, str, dict[str, Any]]


class Reporting:
    """Tell what is missing, how it goes, and publish what changes slowly."""

    def __init__(self, owner: Owner) -> None:
        self._owner = owner
        self._thread: threading.Thread | None = None
        self._is_over = threading.Event()
        self._since = time.monotonic()
        self._told: list[str] = []
        self._version = -1
        self._unsure_of: object = None

    def start(self) -> None:
        self._is_over.clear()
        self._thread = threading.Thread(target=self._run, name="reports", daemon=True)
        self._thread.start()

    def begin(self) -> None:
        """Count from now on how long others have had to be found."""
        self._since, self._told = time.monotonic(), []

    def stop(self) -> None:
        self._is_over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _run(self) -> None:
        while not self._is_over.wait(PERIOD_S):
            try:
                self._report()
            except Exception as error:  # the node goes on without a report
                if not self._is_over.is_set():
                    words = f"no report: {type(error).__name__}: {error}"
                    self._owner.log.error(words, throttle_duration_sec=10.0)

    def _report(self) -> None:
        owner = self._owner
        stamp = owner.node.get_clock().now().nanoseconds
        failure = self._failure()
        if not owner.is_active:
            owner.outputs.diagnostics([("input", WARN, "not active", {})], stamp)
            return
        missing = self._missing()
        rows = [self._input_row(missing), *self._rows(failure)]
        owner.outputs.diagnostics(rows, stamp)
        self._publish(stamp)

    def _failure(self) -> str | None:
        """Return what ended the watch, if something did; it is told once."""
        watch = None if self._owner.learning is None else self._owner.learning.watch
        if watch is None or watch.failure is None:
            return None
        words = f"{type(watch.failure).__name__}: {watch.failure}"
        self._owner.log.error(f"mapping and learning have ended: {words}", once=True)
        return words

    def _missing(self) -> list[str]:
        owner = self._owner
        assert owner.inputs is not None
        seen = owner.inputs.seen(owner.outputs.refused())
        if time.monotonic() - self._since < GRACE_S:
            return []
        missing = seen.missing()
        if owner.n_unreadable:
            missing.append(f"{owner.n_unreadable} images could not be read")
        # Numbers of a sentence change all the time; it is told once.
        heads = [_without_numbers(one) for one in missing]
        for one, head in zip(missing, heads, strict=True):
            if head not in self._told:
                owner.log.warning(one)
        if self._told and not heads:
            owner.log.info("nothing is missing any more")
        self._told = heads
        return missing

    def _input_row(self, missing: list[str]) -> Row:
        if not missing:
            return ("input", OK, "nothing is missing", {})
        watch = self._owner.learning and self._owner.learning.watch
        is_mapping = bool(watch and watch.maps.per_second())
        level = WARN if is_mapping else ERROR
        values = {f"missing {number}": one for number, one in enumerate(missing, start=1)}
        return ("input", level, "; ".join(missing), values)

    def _rows(self, failure: str | None) -> list[Row]:
        learning = self._owner.learning
        watch = None if learning is None else learning.watch
        if learning is None or watch is None:
            return []
        if failure is not None:
            return [("maps", ERROR, failure, {})]
        return [self._maps_row(watch), self._learning_row(learning, watch), self._exploring_row()]

    def _maps_row(self, watch: Watch) -> Row:
        age = watch.map_age_s
        values: dict[str, Any] = {
            "maps a second": _rounded(watch.maps.per_second()),
            "age of the map (ms)": None if age is None else round(1000 * age),
            "age p50 (ms)": watch.ages.percentile_ms(50),
            "age p99 (ms)": watch.ages.percentile_ms(99),
            "images overtaken": self._owner.n_missed,
        }
        return (
            ("maps", OK, "maps", values) if watch.maps.n else ("maps", WARN, "no map yet", values)
        )

    def _learning_row(self, learning: Learning, watch: Watch) -> Row:
        values = {
            "learned a second": _rounded(watch.lessons.per_second()),
            "looks": watch.looks.n,
            "model version": learning.version,
            "lessons not saved": learning.n_unsaved,
            "mean error": _rounded(self._owner.squares.error()),
        }
        if not watch.is_learning:
            state = "does not learn"
        elif not learning.teacher.is_ready:
            state = "looking round"
        else:
            state = "paused" if watch.is_paused else "frozen" if watch.is_frozen else "learning"
        return ("learning", OK, state, values)

    def _exploring_row(self) -> Row:
        navigation = self._owner.navigation
        if navigation is None:
            missing = "nav2_msgs or curiosight_msgs is not there: no exploring"
            return ("exploring", OK, missing, {})
        exploring = navigation.exploring
        if exploring is None:
            return ("exploring", OK, "not exploring", {})
        values = {
            "goals reached": exploring.n_reached,
            "goals not reached": exploring.n_failed,
            "views left alone": len(exploring.left_alone),
            "last drive (s)": _rounded(exploring.travels[-1]) if exploring.travels else None,
        }
        return ("exploring", OK, f"{exploring.phase.value}: {exploring.why()}", values)

    def _publish(self, stamp: int) -> None:
        owner = self._owner
        outputs, world = owner.outputs, owner.values["world_frame"]
        assert owner.learning is not None
        assert owner.inputs is not None
        frame = owner.inputs.frames.colour_frame
        if owner.learning.version != self._version:
            self._version = owner.learning.version
            outputs.vision_info(self._version, str(owner.model or owner.folder.path), stamp, frame)
        outputs.progress(owner.squares, stamp, world)
        navigation = owner.navigation
        exploring = None if navigation is None else navigation.exploring
        place = None if navigation is None else navigation.place
        why = "" if exploring is None else exploring.why()
        outputs.regions(owner.squares, place, why, stamp, world)
        self._publish_uncertainty()

    def _publish_uncertainty(self) -> None:
        """Publish how unsure the newest map is; it takes longer than the map."""
        owner = self._owner
        watch = owner.learning and owner.learning.watch
        mapped = watch and watch.mapped
        if not watch or not mapped or mapped is self._unsure_of or owner.inputs is None:
            return
        if not owner.outputs.is_wanted("uncertainty"):
            return
        self._unsure_of = mapped
        frame, learner = mapped.shot.frame, watch.learner
        description = learner.describe(frame.rgb)
        unsure = learner.unsure(description, frame.T_world_camera)[description.row_of_pixel]
        name = owner.inputs.frames.colour_frame
        owner.outputs.image("uncertainty", unsure, "32FC1", frame.stamp_ns or 0, name)


def _without_numbers(text: str) -> str:
    return "".join(letter for letter in text if not letter.isdigit())


def _rounded(number: float | None) -> float | None:
    return None if number is None else round(number, 3)
