"""The state of a run under way as a file: whole or not at all, checked, and synced to the disk."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from curiosight.errors import DataError
from curiosight.experiments.state_graph import GraphReader, GraphWriter
from curiosight.learner.archive import DAMAGE, read_archive, write_archive

STATE = "state.npz"  # of a run's folder
KIND = "state of a run"


class Snapshot:
    """Write the state of a run, and read it again.

    version: of curiosight; another one may think of the same state otherwise.
    ids: of the frames that the run is about. outside, own: see `GraphWriter`.
    """

    def __init__(
        self,
        version: str,
        ids: Iterable[str],
        outside: Mapping[str, object],
        own: Iterable[str] = (),
    ) -> None:
        self._version, self._frames = version, fingerprint(ids)
        self._outside, self._own = dict(outside), tuple(own)

    def write(self, path: Path, state: object, *, is_packed: bool = False) -> None:
        """Replace the file; raises ValueError for a state that cannot be kept, naming why.

        is_packed: as of `write_archive`.
        """
        writer = GraphWriter(self._outside, self._own)
        node = writer.node(state)
        header = {"curiosight": self._version, "frames": self._frames, "state": node}
        write_archive(path, KIND, header, writer.arrays, is_packed=is_packed)

    def read(self, path: Path) -> Any:
        """Return the state; raises DataError for a damaged file, of others, of another version."""
        header, arrays = read_archive(path, KIND)
        if (written_by := header.get("curiosight")) != self._version:
            found = f"was written by curiosight {written_by}, this is {self._version}"
            raise DataError(path, found, "go on with that version, or begin anew with --from RUN")
        if header.get("frames") != self._frames:
            found = "is of a run over other frames than the source has now"
            raise DataError(path, found, "put back what it was made from, or begin anew")
        try:
            return GraphReader(arrays, self._outside, self._own).made(header["state"])
        except (*DAMAGE, IndexError, ImportError, RecursionError) as error:
            raise DataError(path, f"holds no usable state ({error})", "begin anew") from error


def read_first(path: Path) -> tuple[str, Any]:
    """Return the version that wrote a state, and the first value of it, which stands by itself.

    state: a dict. Raises DataError for a damaged file; of which run and version it is does not
    matter, so all that the value needs is in it.
    """
    header, arrays = read_archive(path, KIND)
    try:
        kind, _, values = header["state"]
        if kind != "dict":
            raise ValueError(f"expected a dict, got {kind!r}")
        return str(header["curiosight"]), GraphReader(arrays, {}).first_of(values)
    except (*DAMAGE, IndexError, ImportError, RecursionError) as error:
        raise DataError(path, f"holds no usable state ({error})", "begin anew") from error


def fingerprint(ids: Iterable[str]) -> str:
    """Return what stands for frames, by their names in order."""
    digest = hashlib.sha256()
    for one in ids:
        digest.update(one.encode("utf-8", "surrogatepass") + b"\0")
    return digest.hexdigest()
