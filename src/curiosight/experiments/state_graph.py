"""Objects as JSON and arrays, and back: no pickle, so reading them runs nobody's code.

What holds state is written attribute by attribute, each object once, however often it is referred
to. It may be of builtin containers, NumPy arrays and sources of chance, and of classes of a few
packages, which are made again without being called. What is outside, such as a recording, is
written by a name.
"""

from __future__ import annotations

import collections
import dataclasses
import functools
import importlib
import random
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.learner.archive import MAX_BYTES

# Whose classes hold state; none of theirs does anything while it is made again.
PACKAGES = tuple(
    f"curiosight.{part}"
    for part in (
        *("experiments", "explorer", "evaluation", "frame", "learner", "teacher", "worlds"),
        *("robot.gauges", "robot.region_record"),
    )
)
PLAIN = frozenset({type(None), bool, int, float, str})
SEQUENCES: Mapping[str, Callable[[list[Any]], Any]] = {
    "list": list,
    "tuple": tuple,
    "set": set,
    "frozenset": frozenset,
}
MAPPINGS = {"dict": dict, "Counter": collections.Counter, "OrderedDict": collections.OrderedDict}
FACTORIES = {one.__name__: one for one in (int, float, list, dict, set, collections.deque)}
CHANCES = {
    one.__name__: one
    for one in (
        np.random.PCG64,
        np.random.PCG64DXSM,
        np.random.MT19937,
        np.random.Philox,
        np.random.SFC64,
    )
}


class GraphWriter:
    """Write objects as JSON-able nodes; what they hold in arrays is gathered beside.

    outside: by name, what is not written but given again to the reader.
    own: packages beside `PACKAGES` whose classes may be met, once they are imported.
    """

    def __init__(self, outside: Mapping[str, object], own: Iterable[str] = ()) -> None:
        self.arrays: dict[str, npt.NDArray[Any]] = {}
        self._outside = {id(one): name for name, one in outside.items()}
        self._own = tuple(own)
        self._number_of: dict[int, int] = {}
        self._met: list[object] = []  # so that no number of theirs is given to another object

    def node(self, one: Any) -> Any:
        """Return an object as a node; raises ValueError for what cannot be written, naming it."""
        if type(one) in PLAIN:
            return one
        if (name := self._outside.get(id(one))) is not None:
            return ["outside", name]
        if (number := self._number_of.get(id(one))) is not None:
            return ["same", number]
        self._number_of[id(one)] = len(self._met)
        self._met.append(one)
        return self._new_node(one)

    def _new_node(self, one: Any) -> list[Any]:
        kind: type = type(one)
        # What there is most of, first: a watch writes a look's record each time.
        if kind is np.ndarray:
            return self._array_node(one)
        if (names := _slots_of(kind)) is not None:
            values = [getattr(one, name) for name in names]
            return ["object", self._name_of(kind), self.node(values)]
        if kind.__name__ in SEQUENCES and kind is SEQUENCES[kind.__name__]:
            return [kind.__name__, self._nodes(one)]
        if MAPPINGS.get(kind.__name__) is kind:
            return [kind.__name__, self._nodes(one), self._nodes(one.values())]
        if kind is collections.deque:
            return ["deque", one.maxlen, self._nodes(one)]
        if isinstance(one, np.generic) and one.dtype.kind in "biuf":
            return ["scalar", one.dtype.str, one.item()]
        if isinstance(one, Enum):
            return ["enum", self._name_of(kind), one.name]
        if isinstance(one, tuple):
            return ["named", self._name_of(kind), self._nodes(one)]
        return self._rare_node(one) or ["object", self._name_of(kind), self.node(_state_of(one))]

    def _rare_node(self, one: Any) -> list[Any] | None:
        kind = type(one)
        if kind is np.random.Generator:
            return ["generator", self.node(one.bit_generator)]
        if CHANCES.get(kind.__name__) is kind:
            return ["chance", kind.__name__, _seeds_of(one), self.node(one.state)]
        if kind is random.Random:
            return ["random", self.node(one.getstate())]
        if kind is functools.partial:
            return ["partial", self.node(one.func), self.node(one.args), self.node(one.keywords)]
        if kind is collections.defaultdict and one.default_factory in FACTORIES.values():
            name = one.default_factory.__name__
            return ["defaultdict", name, self._nodes(one), self._nodes(one.values())]
        return ["bytes", one.hex()] if kind is bytes else None

    def _nodes(self, many: Iterable[Any]) -> list[Any]:
        # Most are plain: a call each would take longer than all else.
        return [one if type(one) in PLAIN else self.node(one) for one in many]

    def _array_node(self, array: npt.NDArray[Any]) -> list[Any]:
        if array.dtype.hasobject:
            raise ValueError("an array of objects cannot be kept")
        number = len(self.arrays)
        self.arrays[f"{number:06d}"] = array
        if array.flags.forc:
            return ["array", number, None]
        # In another layout NumPy may sum in another order.
        return ["array", number, list(array.strides)]

    def _name_of(self, kind: type) -> str:
        """Return a class by name, if an object of it is nothing but its attributes."""
        return _checked_name(kind, self._own)


@functools.cache
def _checked_name(kind: type, own: tuple[str, ...]) -> str:
    name = f"{kind.__module__}:{kind.__qualname__}"
    bases = {base for base in kind.__mro__ if base.__module__ == "builtins"}
    is_plain = bases <= {object} or issubclass(kind, tuple | Enum)
    if not is_plain or _found(name, own) is not kind:
        raise ValueError(f"an object of {name.replace(':', '.')} cannot be kept")
    return name


@functools.cache
def _slots_of(kind: type) -> tuple[str, ...] | None:
    """Return the attributes that a frozen dataclass with slots tells as its state; else None."""
    told = getattr(kind, "__getstate__", None)
    is_usual = dataclasses.is_dataclass(kind) and getattr(told, "__module__", "") == "dataclasses"
    return tuple(field.name for field in dataclasses.fields(kind)) if is_usual else None


class GraphReader:
    """Make the objects of a `GraphWriter` again, from its nodes and arrays.

    outside, own: as of the writer.
    """

    def __init__(
        self,
        arrays: Mapping[str, npt.NDArray[Any]],
        outside: Mapping[str, object],
        own: Iterable[str] = (),
    ) -> None:
        self._arrays, self._outside, self._own = arrays, outside, tuple(own)
        self._met: list[Any] = []

    def made(self, node: Any) -> Any:
        """Return a node's object; ValueError, KeyError, TypeError and the like where it is none."""
        if type(node) in PLAIN:
            return node
        kind, *said = node
        if kind == "outside":
            return self._outside[said[0]]
        if kind == "same":
            return self._met[said[0]]
        number = len(self._met)
        self._met.append(None)
        return self._new(number, kind, said)

    def first_of(self, values: Sequence[Any]) -> Any:
        """Return the first of the values of a dict that is the whole graph."""
        self._met.append(None)  # the dict has the first number
        return self.made(values[0])

    def _new(self, number: int, kind: str, said: Sequence[Any]) -> Any:
        """Make an object; what may hold itself is numbered before what it holds is made."""
        if kind == "object":
            new = object.__new__(_found_class(said[0], self._own))
            self._met[number] = new
            _put_state(new, self.made(said[1]))
        elif kind in ("list", "set", "deque"):
            new = collections.deque(maxlen=said[0]) if kind == "deque" else FACTORIES[kind]()
            self._met[number] = new
            add = getattr(new, "add" if kind == "set" else "append")
            for node in said[-1]:
                add(self.made(node))
        elif kind in MAPPINGS or kind == "defaultdict":
            is_usual = kind in MAPPINGS
            new = MAPPINGS[kind]() if is_usual else collections.defaultdict(FACTORIES[said[0]])
            self._met[number] = new
            keys = self._all(said[-2])
            # As a dict: pairs would be counted by a Counter.
            new.update(dict(zip(keys, self._all(said[-1]), strict=True)))
        else:
            new = self._met[number] = self._leaf(kind, said)
        return new

    def _leaf(self, kind: str, said: Sequence[Any]) -> Any:
        if kind in SEQUENCES:
            return SEQUENCES[kind](self._all(said[0]))
        if kind == "array":
            array = self._arrays[f"{said[0]:06d}"]
            return array if said[1] is None else _with_strides(array, said[1])
        if kind == "scalar":
            return np.dtype(said[0]).type(said[1])
        if kind == "enum":
            return _subclass(Enum, said[0], self._own)[said[1]]
        if kind == "named":
            return tuple.__new__(_subclass(tuple, said[0], self._own), self._all(said[1]))
        if kind == "generator":
            return np.random.Generator(self.made(said[0]))
        if kind == "chance":
            return self._chance(*said)
        if kind == "random":
            new = random.Random()
            new.setstate(self.made(said[0]))
            return new
        if kind == "partial":
            function, arguments, options = self._all(said)
            return functools.partial(function, *arguments, **options)
        if kind == "bytes":
            return bytes.fromhex(said[0])
        raise ValueError(f"an object of kind {kind!r}")

    def _chance(self, name: str, seeds: Mapping[str, Any] | None, state: Any) -> Any:
        seed = None
        if seeds is not None:
            seed = np.random.SeedSequence(
                seeds["entropy"],
                spawn_key=tuple(seeds["spawn_key"]),
                pool_size=seeds["pool_size"],
                n_children_spawned=seeds["n_children_spawned"],
            )
        chance: Any = CHANCES[name](seed)
        chance.state = self.made(state)
        return chance

    def _all(self, nodes: Iterable[Any]) -> list[Any]:
        return [self.made(node) for node in nodes]


def _with_strides(array: npt.NDArray[Any], strides: Sequence[int]) -> npt.NDArray[Any]:
    """Return a copy of an array whose elements lie so many bytes apart."""
    reach = [(n - 1) * stride for n, stride in zip(array.shape, strides, strict=True)]
    first = -sum(step for step in reach if step < 0)
    n_bytes = first + sum(step for step in reach if step > 0) + array.itemsize
    if array.size == 0 or n_bytes > MAX_BYTES:
        raise ValueError(f"strides of {strides}")
    buffer = np.zeros(n_bytes, np.uint8)
    laid = np.ndarray(array.shape, array.dtype, buffer.data, first, tuple(strides))
    laid[...] = array
    return laid


def _seeds_of(chance: Any) -> dict[str, Any] | None:
    """Return where a source of chance began, which its children depend on."""
    seeds = chance.seed_seq
    return dict(seeds.state) if isinstance(seeds, np.random.SeedSequence) else None


def _state_of(one: Any) -> Any:
    return one.__getstate__()


def _put_state(new: Any, state: Any) -> None:
    """Give an object the attributes that `__getstate__` told."""
    if hasattr(new, "__setstate__"):
        new.__setstate__(state)
        return
    own, slots = state if isinstance(state, tuple) else (state, None)
    vars_of = {} if own is None else own
    if vars_of:
        vars(new).update(vars_of)
    for name, value in (slots or {}).items():
        object.__setattr__(new, name, value)


def _found(name: str, own: tuple[str, ...]) -> object:
    """Return the class of a name, if it is of a module that may be asked; else None."""
    module_name, _, path = name.partition(":")
    is_ours = _is_in(module_name, PACKAGES)
    if not is_ours and not _is_in(module_name, own):
        return None
    module = importlib.import_module(module_name) if is_ours else sys.modules.get(module_name)
    found: Any = module
    for part in path.split("."):
        found = getattr(found, part, None)
    return found if getattr(found, "__module__", None) == module_name else None


def _is_in(module: str, packages: Iterable[str]) -> bool:
    return any(module == one or module.startswith(f"{one}.") for one in packages)


def _found_class(name: str, own: tuple[str, ...]) -> type[Any]:
    found = _found(name, own)
    if not isinstance(found, type):
        raise ValueError(f"an object of {name!r}")
    return found


def _subclass(base: type[Any], name: str, own: tuple[str, ...]) -> Any:
    found = _found_class(name, own)
    if not issubclass(found, base):
        raise ValueError(f"an object of {name!r}")
    return found
