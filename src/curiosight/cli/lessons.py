"""Say how many looks taught nothing, why, and what to try; nothing learned is no success."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from curiosight.cli.talk import NOTHING_LEARNED, Talk
from curiosight.experiments.problems import Lessons

# 2 is for a user's mistakes; here nothing was wrong with the command.
LEARNED_NOTHING_STATUS = 1


def tell_lessons(talk: Talk, lessons: Lessons, *, has_learned: bool) -> None:
    """Warn where most looks taught nothing or nothing was learned; else say it as a note."""
    if lessons.is_suspect or not has_learned:
        for problem in lesson_problems(lessons, has_learned=has_learned):
            talk.warn(problem)
    elif (sentence := lessons.sentence()) is not None:
        talk.note(sentence)


def tell_places(views: Sequence[int]) -> dict[str, str]:
    """Return the row of a result that says how many places were told apart, by whose views."""
    if not views:
        return {}
    return {"places": f"{len(views)}, of {', '.join(map(str, views))} views"}


def tell_forgetting(left: dict[str, Any] | None) -> dict[str, float]:
    """Return the rows of a result that say what is left of places, see `Forgetting.summary`."""
    if left is None:
        return {}
    return {
        "average of places (F1)": left["average_quality"],
        "backward transfer (F1)": left["backward_transfer"],
        "forgetting (F1)": left["forgetting"],
    }


def tell_alarms(alarms: Sequence[dict[str, Any]], n_alarms: int | None = None) -> str:
    """Say how often a place was no longer what had been learned of it, and the last reason.

    n_alarms: in all, where only the first are given.
    """
    last = alarms[-1]
    return f"{n_alarms or len(alarms)}; at look {last['look']}: {last['reason']}"


def tell_samples(n_kept: int, views: Sequence[int], n_drawn: int | None = None) -> str:
    """Say how many samples a model keeps, and of how many that were drawn.

    views: of each place; where there are several, the common forest keeps some of theirs, too.
    """
    if len(views) > 1:
        kept = f"{n_kept} in {len(views) + 1} forests, some in two of them"
        return kept if n_drawn is None else f"{n_drawn} drawn; {kept}"
    return str(n_kept) if n_drawn in (None, n_kept) else f"{n_kept} of {n_drawn}, chosen at random"


def lesson_problems(lessons: Lessons, *, has_learned: bool) -> Iterator[str]:
    """Yield what a report and a warning say where most looks taught nothing, or all of them."""
    if lessons.is_suspect or not has_learned:
        if (sentence := lessons.sentence()) is not None:
            yield sentence
        yield from lessons.remedies()
    if not has_learned:
        yield NOTHING_LEARNED
