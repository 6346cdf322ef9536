"""What a command was given beside its settings, kept beside config.toml: command.json."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from math import inf
from pathlib import Path
from typing import Self

from curiosight.errors import DataError
from curiosight.experiments.output import OutputFolder

COMMAND = "command.json"


@dataclass(frozen=True, slots=True)
class GivenCommand:
    """A command with what it reads; paths are absolute, drawn rooms as they were named.

    version: of curiosight. test, ground_truth, from_ (a model's file): None = not given.
    """

    command: str
    version: str
    source: str
    test: str | None = None
    ground_truth: str | None = None
    from_: str | None = None

    def write(self, folder: OutputFolder) -> None:
        """Write it into a run's folder."""
        folder.write_json(COMMAND, asdict(self))

    def check(self) -> None:
        """Raise TypeError for what no command was given."""
        if not all(isinstance(getattr(self, name), str | None) for name in _TEXTS):
            raise TypeError("expected text")

    @classmethod
    def read(cls, run: Path, command: str) -> Self:
        """Return what a run's folder was made with; DataError if not by this command."""
        path, remedy = run / COMMAND, f"give the folder that --out of {command} wrote"
        if not run.exists():
            raise DataError(run, "does not exist", remedy)
        try:
            found = json.loads(path.read_text("utf-8"))
            # Before all else: another command's may lack what this one tells of.
            by = GivenCommand(**{field.name: found[field.name] for field in fields(GivenCommand)})
            by.check()
            if by.command != command:
                raise DataError(run, f"was written by {by.command}, not by {command}", remedy)
            known = cls(**{field.name: found[field.name] for field in fields(cls)})
            known.check()
        except FileNotFoundError as error:
            found_none = f"holds no {COMMAND}, by which a run is gone on with"
            raise DataError(run, found_none, remedy) from error
        except OSError as error:
            raise DataError(path, f"cannot be read ({error.strerror})", remedy) from error
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise DataError(path, "is damaged, or no file of ours", remedy) from error
        return known


_TEXTS = [field.name for field in fields(GivenCommand)]


@dataclass(frozen=True, slots=True)
class GivenWatch(GivenCommand):
    """A watch with what it reads, whether it learns, and after how many seconds it ends, if ever.

    from_: the model that it began with.
    """

    learn: bool = False
    seconds: float | None = None

    def check(self) -> None:
        GivenCommand.check(self)
        is_known = isinstance(self.seconds, float) and 0 < self.seconds < inf
        if not isinstance(self.learn, bool) or not (self.seconds is None or is_known):
            raise TypeError("expected whether it learns, and seconds")
