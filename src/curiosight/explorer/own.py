"""A strategy of one's own, named as package.module:Class."""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from curiosight.explorer.check import check_strategy
from curiosight.explorer.ground import Ways
from curiosight.explorer.strategy import Strategy
from curiosight.frame import Viewpoint

MakesStrategy = Callable[..., Strategy]


def is_own(name: str) -> bool:
    """Tell whether a strategy's name is one of a class: package.module:Class."""
    module, colon, made = name.partition(":")
    return bool(colon) and made.isidentifier() and all(map(str.isidentifier, module.split(".")))


def load_own(name: str) -> MakesStrategy:
    """Return a class that makes strategies from (views, rng, *, ways=None), its contract checked.

    name: package.module:Class, of what is installed or lies in the folder one is in. Raises
    ValueError in one line where there is no such thing, or it breaks the contract.
    """
    module_name, _, made_name = name.partition(":")
    with _folder_importable():
        module = _import(module_name)
    made = getattr(module, made_name, None)
    if not callable(made):
        found = "nothing of that name" if made is None else f"{type(made).__name__} {made_name}"
        where = getattr(module, "__file__", None) or module_name
        raise ValueError(f"strategy: expected a class {made_name} in {where}, got {found}")
    for ways in (None, _made_up_ways):
        _check(name, made, ways)
    kept: MakesStrategy = made
    return kept


def _check(name: str, made: Callable[..., Any], ways: Ways | None) -> None:
    """Run the contract check; tell where the class's own code failed."""

    def factory(views: Sequence[Viewpoint], rng: np.random.Generator) -> Strategy:
        strategy: Strategy = made(views, rng, ways=ways)
        return strategy

    try:
        check_strategy(factory)
    except Exception as error:
        raise ValueError(f"strategy: {name} breaks the contract: {_told(error)}") from error


def _import(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise ValueError(f"strategy: {name} cannot be imported: {_told(error)}") from error
        remedy = "install it, or run in the folder it lies in"
        raise ValueError(f"strategy: no module {error.name!r}; {remedy}") from error
    except (Exception, SystemExit) as error:
        raise ValueError(f"strategy: {name} cannot be imported: {_told(error)}") from error


def _told(error: BaseException) -> str:
    """Return an error in one line, with where it was raised unless it is a ValueError."""
    message = " ".join(str(error).split())
    if isinstance(error, ValueError):
        return message
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({os.path.basename(frames[-1].filename)}, line {frames[-1].lineno})"
    return f"{type(error).__name__}: {message}{'' if isinstance(error, SyntaxError) else where}"


@contextmanager
def _folder_importable() -> Iterator[None]:
    """Let the folder one is in be imported from, as `python -m` does."""
    here = os.getcwd()
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)


def _made_up_ways(start: Viewpoint, goals: Sequence[Viewpoint]) -> np.ndarray[Any, Any]:
    """Return seconds as if the views stood in a line."""
    return np.array([abs(goal.index - start.index) / 10 for goal in goals])
