"""How soon a home is known to have changed, and how often it is said that has not.

    python benchmarks/drift.py --home 11 --home 12 --streams 2 --json drift.json

A robot looks at the rooms of a home in stays of ten, at views by chance; after `--before` looks the
home is lit otherwise, its things are moved, or nothing happens. Told are, of each room, the looks
at it from the change to the alarm, and the alarms where nothing had changed. Frames are drawn and
described once; in each stream a learner learns from them anew, with chance of its own.

With `--unrefreshed` alarms are told and nothing is done about them: `error_after` is the mean error
(1 - F1 at once, before a look is learned from) of all looks after the change, with and without.
With `--light` no more is told than how much other the light is.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import cv2
import numpy as np

from curiosight.config import Config, load_config
from curiosight.experiments.components import heard, make_learner, make_teacher, survey_dataset
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.lesson import Visit
from curiosight.learner.observation import Teaches
from curiosight.learner.staleness import Staleness
from curiosight.rooms import HomeViews
from curiosight.worlds import open_source

STAY, MOST = 10, 40
EXPECTED = {"lights": {"light", "tint"}, "rearrange": {"gone", "new"}}


@dataclass(frozen=True)
class Shown:
    """A view as it was described: of which room."""

    room: int
    visit: Visit


def describe(
    learner: SaliencyLearner, teacher: Teaches, source: str, n_visits: int, config: Config
) -> list[list[Shown]]:
    """Return the views of each room, looked at so often, each time with other noise."""
    views = open_source(source)
    assert isinstance(views, HomeViews)
    rooms: list[list[Shown]] = [[] for _ in range(views.home.n_rooms)]
    for index in np.random.default_rng(0).permutation(len(views)).tolist():
        rngs = [np.random.default_rng([index, visit]) for visit in range(n_visits)]
        for look in views.visits(index, rngs, n_looks=index):
            segmentation = teacher.segment(look.frame)
            room = views.place(index)
            rooms[room].append(Shown(room, learner.visit(look.frame, segmentation)))
    return rooms


def stays(rooms: Sequence[Sequence[Shown]], n: int, rng: np.random.Generator) -> list[Shown]:
    """Return looks at rooms in turn, by chance which, at views of them by chance."""
    looks: list[Shown] = []
    while len(looks) < n:
        order = rng.permutation(len(rooms)).tolist()
        looks += [
            rooms[room][rng.integers(len(rooms[room]))] for room in order for _ in range(STAY)
        ]
    return looks[:n]


def run(
    before: Sequence[Shown], after: Sequence[Shown], config: Config, seed: int
) -> tuple[list[tuple[int, str]], dict[int, tuple[int, str]], int, float]:
    """Learn from looks; return alarms before the change, and of each room the first one after it.

    Of the first the look and the reason; of the others the looks at the room, and the cause. And
    looks until any alarm, all where none came; and the mean error after the change.
    """
    learner = make_learner(config, None, np.random.default_rng(seed))
    false_alarms: list[tuple[int, str]] = []
    for look, shown in enumerate(before):
        _, _, change = learner.observe_again(shown.visit)
        if change.alarm is not None:
            false_alarms.append((look, change.alarm.reason))
    found: dict[int, tuple[int, str]] = {}
    n_at: Counter[int] = Counter()
    first, errors = len(after), []
    for look, shown in enumerate(after):
        _, error, change = learner.observe_again(shown.visit)
        errors.append(np.nan if error is None else error)
        n_at[shown.room] += 1
        if change.alarm is not None:
            found.setdefault(shown.room, (n_at[shown.room], change.alarm.cause))
            first = min(first, look + 1)
    return false_alarms, found, first, float(np.nanmean(errors))


def measure(home: int, config: Config, options: argparse.Namespace) -> list[dict[str, Any]]:
    """Return what each stream of a home came to."""
    source = f"home:{home},rooms={options.rooms},views={options.views}"
    views = open_source(source)
    teacher = heard(config, make_teacher(config, views, survey_dataset(config, views)))
    learner = make_learner(config, None)
    base = describe(learner, teacher, source, options.visits, config)
    changed = {
        change: describe(learner, teacher, f"{source},{change}={options.change}", 1, config)
        for change in EXPECTED
    }
    streams: list[dict[str, Any]] = []
    for stream in range(options.streams):
        seed = 1000 * home + stream
        for change, rooms in [*changed.items(), ("none", base)]:
            rng = np.random.default_rng(seed)
            before = stays(base, options.before, rng)
            n_after = options.after * len(rooms) if change != "none" else options.unchanged
            started = process_time()
            false_alarms, found, first, error = run(
                before, stays(rooms, n_after, rng), config, seed
            )
            ms = 1000 * (process_time() - started) / (len(before) + n_after)
            one = {"home": home, "stream": stream, "change": change, "rooms": len(rooms)}
            one |= {"before": len(before), "after": n_after, "false_alarms": false_alarms}
            one |= {"found": found, "first": first, "error_after": round(error, 4)}
            streams.append(one | {"ms": round(ms, 1)})
            print(json.dumps(streams[-1]), flush=True)
    return streams


def light(home: int, options: argparse.Namespace) -> list[dict[str, Any]]:
    """Return of each room by how much, in logarithms, its views are lit otherwise, by median.

    light: of parts beside the whole, which exposure hides. tint: of red and blue to green.
    """
    source = f"home:{home},rooms={options.rooms},views={options.views}"
    one, other = open_source(source), open_source(f"{source},lights={options.change}")
    assert isinstance(one, HomeViews)
    told: list[list[tuple[float, float]]] = [[] for _ in range(one.home.n_rooms)]
    for index in range(len(one)):
        parts = [
            cv2.resize(views[index].rgb, (16, 12), interpolation=cv2.INTER_AREA)
            for views in (one, other)
        ]
        before, after = (np.log(part.astype(float) + 1) for part in parts)
        red, green, blue = np.moveaxis(after - before, -1, 0)
        tint = abs(np.median(red - green)) + abs(np.median(blue - green))
        told[one.place(index)].append((np.mean(abs(green - np.median(green))), tint))
    medians = [np.median(room, axis=0).round(3).tolist() for room in told]
    return [
        {"home": home, "room": room, "light": by, "tint": tint}
        for room, (by, tint) in enumerate(medians)
    ]


def summarise(streams: Sequence[dict[str, Any]]) -> dict[str, object]:
    """Return looks until the alarm and false alarms of all streams together."""
    unchanged = [one for one in streams if one["change"] == "none"]
    n_false = sum(len(one["false_alarms"]) for one in streams)
    n_false += sum(len(one["found"]) for one in unchanged)
    n_looks = sum(one["before"] for one in streams) + sum(one["after"] for one in unchanged)
    summary: dict[str, object] = {"false_alarms": n_false, "unchanged_looks": n_looks}
    for change, causes in EXPECTED.items():
        of_change = [one for one in streams if one["change"] == change]
        looks, rightly = [], 0
        for one in of_change:
            # Keys are text where it was read from a file.
            found = {int(room): alarm for room, alarm in one["found"].items()}
            soon = {room: alarm for room, alarm in found.items() if alarm[0] <= MOST}
            looks += [soon.get(room, (np.inf, ""))[0] for room in range(one["rooms"])]
            rightly += sum(cause in causes for _, cause in soon.values())
        first = [one["first"] for one in of_change]
        summary[change] = {
            "rooms": len(looks),
            "median": float(np.median(looks)),
            "quartiles": np.quantile(looks, [0.25, 0.75], method="nearest").tolist(),
            "max_found": max((n for n in looks if np.isfinite(n)), default=None),
            "within_30": float(np.mean(np.array(looks) <= 30)),
            f"not_within_{MOST}": int(np.isinf(looks).sum()),
            "right_reason": rightly,
            "first_in_home_median": float(np.median(first)),
            "first_in_home_max": float(np.max(first)),
            "error_after": float(np.mean([one.get("error_after", np.nan) for one in of_change])),
        }
    return summary


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--home", type=int, action="append", default=[])
    parser.add_argument("--rooms", type=int, default=2)
    parser.add_argument("--views", type=int, default=40, help="of each room")
    parser.add_argument("--visits", type=int, default=3, help="of each view before the change")
    parser.add_argument("--change", type=int, default=3, help="number of lights and arrangement")
    parser.add_argument("--before", type=int, default=300, help="looks before the change")
    parser.add_argument("--after", type=int, default=MOST, help="looks at each room after it")
    parser.add_argument("--unrefreshed", action="store_true", help="do nothing about alarms")
    parser.add_argument("--light", action="store_true", help="how much other light is")
    parser.add_argument("--unchanged", type=int, default=400, help="looks where nothing happens")
    parser.add_argument("--streams", type=int, default=2, help="of each home")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--together", type=Path, nargs="+", help="sum up such files instead")
    options = parser.parse_args()
    config = load_config("default", None, {"run.n_threads": 1})
    if options.light:
        for home in options.home:
            print(*map(json.dumps, light(home, options)), sep="\n", flush=True)
        return
    if options.unrefreshed:
        Staleness.begin = lambda *_: None  # type: ignore[method-assign]
    streams = [one for home in options.home for one in measure(home, config, options)]
    for path in options.together or ():
        streams += json.loads(path.read_text(encoding="utf-8"))["streams"]
    result = {"summary": summarise(streams), "streams": streams}
    print(json.dumps(result["summary"], indent=1))
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
