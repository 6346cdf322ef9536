"""Sources that environments look around in, prepared once."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

from curiosight.config import Config, to_toml
from curiosight.experiments.contest.contest import place_of
from curiosight.experiments.contest.prepared import Prepared
from curiosight.experiments.contest.preparing import prepare
from curiosight.experiments.contest.settings import folder_name


def prepared_source(source: str, config: Config, folder: str | Path | None = None) -> Prepared:
    """Return a source described and labelled, see `prepare`.

    folder: where it is kept, beside others; None = until this process ends.

    Raises as `prepare`.
    """
    place = place_of(source)
    # Who explores, and how, changes nothing of what there is to see.
    settings = to_toml(replace(config, explorer=Config().explorer))
    digest = hashlib.sha256(settings.encode()).hexdigest()[:8]
    kept = _until_the_end() if folder is None else Path(folder).absolute()
    return prepare(place, config, kept / f"{folder_name(place)}-{digest}")


@cache
def _until_the_end() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="curiosight-gym-"))
    atexit.register(_remove, folder, os.getpid())
    return folder


def _remove(folder: Path, owner: int) -> None:
    # A process that was forked from the owner reads there too.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
