"""Teach a camera to see the objects of its own rooms: no labels, no GPU.

Depth shows what an object is; from that a forest learns, live, how such things look; then it
finds them in plain RGB. And it decides by itself where to look next: where it learns fastest.
Implements and goes beyond Craye, Filliat and Goudou, "Environment Exploration for Object-Based
Visual Saliency Learning", ICRA 2016, which docstrings cite as eq. and sec.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

# Not on first use as the others: `explore` is a module, too, and whoever imports that first
# would find the module under this name.
from curiosight.explore import explore

if TYPE_CHECKING:
    from curiosight.config import load_config
    from curiosight.datasets import check_dataset
    from curiosight.errors import DataError
    from curiosight.experiments.components import make_learner, make_teacher
    from curiosight.explorer import check_strategy, make_regions, make_strategy
    from curiosight.frame import Camera, Frame, Label, Viewpoint
    from curiosight.learner.learner import SaliencyLearner
    from curiosight.teacher import Teacher
    from curiosight.worlds import ReplayWorld, check_world
    from curiosight.worlds import open_source as open_dataset

__version__ = "0.1.0"

__all__ = [
    "Camera",
    "DataError",
    "Frame",
    "Label",
    "ReplayWorld",
    "SaliencyLearner",
    "Teacher",
    "Viewpoint",
    "check_dataset",
    "check_strategy",
    "check_world",
    "explore",
    "load_config",
    "make_learner",
    "make_regions",
    "make_strategy",
    "make_teacher",
    "open_dataset",
]

# Where the names are, so that `curiosight --version` waits for none of them.
_MODULES = {
    "config": ("load_config",),
    "datasets": ("check_dataset",),
    "errors": ("DataError",),
    "experiments.components": ("make_learner", "make_teacher"),
    "explorer": ("check_strategy", "make_regions", "make_strategy"),
    "frame": ("Camera", "Frame", "Label", "Viewpoint"),
    "learner.learner": ("SaliencyLearner",),
    "teacher": ("Teacher",),
    "worlds": ("ReplayWorld", "check_world", "open_source"),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}
_RENAMED = {"open_dataset": "open_source"}

if not TYPE_CHECKING:  # else any name would pass a type checker

    def __getattr__(name: str) -> Any:
        """Import a public name, or a part of the package, when it is asked for (PEP 562)."""
        original = _RENAMED.get(name, name)
        if name in __all__:
            found = getattr(import_module(f"{__name__}.{_MODULE_OF[original]}"), original)
        elif name.isidentifier() and name[0] != "_" and find_spec(f"{__name__}.{name}"):
            found = import_module(f"{__name__}.{name}")
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
