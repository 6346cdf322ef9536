"""Rooms that are drawn and lit once in a run of the tests: each takes seconds a room."""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from uuid import uuid4

from curiosight.rooms.brief import Brief
from curiosight.rooms.lighting import LitMesh, lit
from curiosight.rooms.mesh import Mesh
from curiosight.rooms.room import Room, draw_room
from curiosight.rooms.scene import Light
from curiosight.rooms.settings import RoomSettings
from curiosight.rooms.tracing import RayCaster

# So many rooms are kept by each worker.
N_ROOMS = 12
_ROOMS: dict[bytes, Room] = {}


def draw_room_once(settings: RoomSettings, brief: Brief | None = None) -> Room:
    """Return the room that `draw_room` draws; what draws one is the same for the same settings."""
    told = pickle.dumps((settings, brief))
    room = _ROOMS.pop(told, None) or draw_room(settings, brief)
    _ROOMS[told] = room
    while len(_ROOMS) > N_ROOMS:
        _ROOMS.pop(next(iter(_ROOMS)))
    return room


def lit_once_in(folder: Path) -> Callable[[Mesh, Sequence[Light], RayCaster, int], LitMesh]:
    """Return what works out the light of a mesh, and keeps it in a folder for whoever asks next."""

    def lit_once(mesh: Mesh, lights: Sequence[Light], caster: RayCaster, seed: int) -> LitMesh:
        told = pickle.dumps((mesh, tuple(lights), seed))
        path = folder / f"{hashlib.sha256(told).hexdigest()}.pickle"
        if path.exists():
            known: LitMesh = pickle.loads(path.read_bytes())
            return known
        found = lit(mesh, lights, caster, seed)
        # Another worker may write the same.
        part = folder / f"{uuid4().hex}.part"
        part.write_bytes(pickle.dumps(found))
        os.replace(part, path)
        return found

    return lit_once
