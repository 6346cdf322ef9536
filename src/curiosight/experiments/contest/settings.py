"""What is compared, as it is kept beside the results: `compare.toml`."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

from curiosight.config import Config, config_of, read_toml, to_toml, toml_value
from curiosight.errors import DataError
from curiosight.errors.arguments import check_whole
from curiosight.explorer.ground import LOOK_SECONDS

SECTION = "compare"
# More would never end.
MAX_SEEDS, MAX_STEPS = 10_000, 10_000_000


@dataclass(frozen=True, slots=True)
class ContestSettings:
    """Sources by strategies by seeds; everything that decides what the table says.

    sources: as they were written. strategies: names of `make_strategy`, each with @REGIONS
    where it has regions of its own. seeds: how many; the first is 0, the same for all. steps:
    looks of a run; None = so many seconds of the robot. config: all else.
    """

    sources: tuple[str, ...]
    strategies: tuple[str, ...]
    seeds: int
    steps: int | None
    seconds: float | None
    config: Config

    def __post_init__(self) -> None:
        for name in ("sources", "strategies"):
            _check_names(name, getattr(self, name))
        check_whole("seeds", self.seeds, 1, MAX_SEEDS)
        if (self.steps is None) == (self.seconds is None):
            raise ValueError("steps, seconds: expected one of them")
        if self.steps is not None:
            check_whole("steps", self.steps, 1, MAX_STEPS)
        if self.seconds is not None and not 0 < self.seconds <= MAX_STEPS:
            expected = f"a positive number up to {MAX_STEPS}"
            raise ValueError(f"seconds: expected {expected}, got {self.seconds}")

    @property
    def n_looks(self) -> int:
        """How many looks a run has at most."""
        if self.steps is not None:
            return self.steps
        assert self.seconds is not None
        return math.ceil(self.seconds / LOOK_SECONDS)

    def config_of(self, name: str) -> Config:
        """Return the settings of a run of a strategy, which has one thread to itself."""
        strategy, at, regions = name.partition("@")
        explorer = replace(self.config.explorer, strategy=strategy)
        if at:
            explorer = replace(explorer, regions=absolute_regions(regions))
        run = replace(self.config.run, n_threads=1)
        return replace(self.config, explorer=explorer, run=run)

    def to_toml(self) -> str:
        """Write all of it as TOML that `read_settings` reads back to the same."""
        lines = [f"[{SECTION}]"]
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "config" and value is not None:
                lines.append(f"{field.name} = {toml_value(value)}")
        return to_toml(self.config) + "\n" + "\n".join(lines) + "\n"


def read_settings(path: Path) -> ContestSettings:
    """Read what `ContestSettings.to_toml` wrote; raises `DataError` for anything else."""
    table = read_toml(path)
    own = table.pop(SECTION, None)
    config = config_of(table, path)
    try:
        if not isinstance(own, dict):
            raise ValueError(f"section [{SECTION}] is missing")
        for name in ("seeds", "steps"):
            if type(own.get(name, 0)) is not int:
                raise ValueError(f"{name}: expected a whole number, got {own[name]!r}")
        return ContestSettings(
            tuple(map(str, own.pop("sources"))),
            tuple(map(str, own.pop("strategies"))),
            own.pop("seeds"),
            own.pop("steps", None),
            own.pop("seconds", None),
            config,
        )
    except (KeyError, TypeError, ValueError) as error:
        remedy = "leave this file as the command wrote it"
        raise DataError(path, f"is not readable ({error})", remedy) from error


def absolute_regions(spec: str) -> str:
    """Return regions whose file is found from anywhere."""
    return str(Path(spec).absolute()) if spec and Path(spec).is_file() else spec


def folder_name(text: str) -> str:
    """Return a name for a folder that no other text has."""
    clean = re.sub(r"[^A-Za-z0-9=-]+", "_", text).strip("_")
    if clean == text and len(text) <= 60:
        return text
    return f"{clean[-60:]}-{hashlib.sha256(text.encode('utf-8', 'replace')).hexdigest()[:8]}"


def _check_names(what: str, names: Sequence[str]) -> None:
    if not names or not all(names):
        raise ValueError(f"{what}: expected at least one, and none empty, got {list(names)}")
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"{what}: expected each once, got {twice[0]!r} twice")
