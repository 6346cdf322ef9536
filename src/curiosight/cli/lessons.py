"""Say how many looks taught nothing, why, and what to try; nothing learned is no success."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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


def lesson_problems(lessons: Lessons, *, has_learned: bool) -> Iterator[str]:
    """Yield what a report and a warning say where most looks taught nothing, or all of them."""
    if lessons.is_suspect or not has_learned:
        if (sentence := lessons.sentence()) is not None:
            yield sentence
        yield from lessons.remedies()
    if not has_learned:
        yield NOTHING_LEARNED
