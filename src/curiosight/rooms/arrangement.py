"""Where things stand: on tables and on the floor, without touching each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from curiosight.frame import Pose
from curiosight.rooms.free_space import ROBOT_RADIUS, FreeSpace, Polygon
from curiosight.rooms.mesh import Mesh, standing
from curiosight.rooms.plan import FloorPlan
from curiosight.rooms.scene import Part, Role
from curiosight.rooms.things.kind import Kind

Box = npt.NDArray[np.float64]  # x_min, y_min, x_max, y_max

_N_TRIES = 60
# What stands closer to its neighbour is one cluster with it for any teacher.
_GAP_ON_TABLE, _GAP_ON_FLOOR = 0.05, 0.18
PER_SQUARE_METRE = 14.0
_LEFT_OUT, _ADDED = 0.2, 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A rectangle that things can stand on.

    T_room_surface: z is the height. box: x_min, y_min, x_max, y_max in the surface's own frame.
    """

    T_room_surface: Pose
    box: tuple[float, float, float, float]

    @property
    def area(self) -> float:
        x_min, y_min, x_max, y_max = self.box
        return (x_max - x_min) * (y_max - y_min)


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """An object and where it stands; mesh: in its own frame. is_on_floor: else on a surface."""

    kind: Kind
    mesh: Mesh
    is_on_floor: bool
    T_room_thing: Pose

    def part(self, role: Role = Role.OBJECT) -> Part:
        """Return it as a part of a scene."""
        return Part(self.kind.name, role, self.mesh.moved(self.T_room_thing))

    def footprint(self) -> Polygon:
        """Return the (4, 2) corners of the box around it, in the room."""
        return corners(_bounds(self.mesh, self.T_room_thing))


class Arrangement:
    """The places of a room, some of them taken.

    obstacles: footprints of furniture. kept_free: boxes (4 numbers) of
    the floor where nothing may stand, such as before doors. least_reach: share of what a robot
    reaches at first that things on the floor leave it.
    """

    def __init__(
        self,
        plan: FloorPlan,
        surfaces: Sequence[Surface],
        obstacles: Sequence[Polygon],
        kept_free: Sequence[Box] = (),
        least_reach: float = 0.0,
    ) -> None:
        self._plan = plan
        self._surfaces = tuple(surfaces)
        self._obstacles = [_box_around(obstacle) for obstacle in obstacles]
        self._kept_free = list(kept_free)
        self._on_surface: list[list[Box]] = [[] for _ in self._surfaces]
        self._on_floor: list[Box] = []
        self._n_square_metres = self._reach(None)
        self._least_square_metres = least_reach * self._n_square_metres
        self.things: list[Thing] = []

    def fill(
        self,
        kinds: Sequence[Kind],
        n_on_floor: int,
        rng: np.random.Generator,
        *,
        per_square_metre: float = PER_SQUARE_METRE,
    ) -> None:
        """Put things everywhere; what finds no place is left out.

        per_square_metre: how many things on tables.
        """
        table_kinds = [kind for kind in kinds if "table" in kind.places]
        floor_kinds = [kind for kind in kinds if "floor" in kind.places]
        for number, surface in enumerate(self._surfaces):
            n_things = int(rng.poisson(per_square_metre * surface.area))
            for kind in draw_kinds(table_kinds, n_things, rng):
                self._put_on_surface(Thing(kind, kind.draw(rng), False, np.eye(4)), number, rng)
        for kind in draw_kinds(floor_kinds, n_on_floor, rng):
            self._put_on_floor(Thing(kind, kind.draw(rng), True, np.eye(4)), rng)

    def put(self, thing: Thing, rng: np.random.Generator) -> None:
        """Put one thing anywhere of its sort of place; it is left out where it finds none."""
        if thing.is_on_floor:
            self._put_on_floor(thing, rng)
        elif self._surfaces:
            areas = np.array([surface.area for surface in self._surfaces])
            number = int(rng.choice(len(areas), p=areas / areas.sum()))
            self._put_on_surface(thing, number, rng)

    def _put_on_surface(self, thing: Thing, number: int, rng: np.random.Generator) -> None:
        surface = self._surfaces[number]
        x_min, y_min, x_max, y_max = surface.box
        taken = self._on_surface[number]
        for _ in range(_N_TRIES):
            x, y = rng.uniform((x_min, y_min), (x_max, y_max))
            pose = standing(x, y, 0.0, rng.uniform(-np.pi, np.pi))
            box = _bounds(thing.mesh, pose)
            is_inside = (box[:2] > (x_min, y_min)).all() and (box[2:] < (x_max, y_max)).all()
            if is_inside and not _meets_any(_grown(box, _GAP_ON_TABLE), taken):
                taken.append(box)
                self.things.append(replace(thing, T_room_thing=surface.T_room_surface @ pose))
                return

    def _put_on_floor(self, thing: Thing, rng: np.random.Generator) -> None:
        low, high = np.reshape(self._plan.bounds, (2, 2))
        for _ in range(_N_TRIES):
            x, y = rng.uniform(low, high)
            pose = standing(x, y, 0.0, rng.uniform(-np.pi, np.pi))
            box = _bounds(thing.mesh, pose)
            around = _grown(box, _GAP_ON_FLOOR)
            taken = [*self._on_floor, *self._obstacles, *self._kept_free]
            if not _is_inside(around, self._plan) or _meets_any(around, taken):
                continue
            reach = self._reach(box)
            least = self._n_square_metres - 1.2 * _area(_grown(box, ROBOT_RADIUS))
            if reach > max(least, self._least_square_metres):
                self._n_square_metres = reach
                self._on_floor.append(box)
                self.things.append(replace(thing, T_room_thing=pose))
                return

    def _reach(self, box: Box | None) -> float:
        """Return how much floor a robot reaches, once something more stands on it.

        Where that falls by more than what the thing covers, it bars the way.
        """
        boxes = [*self._obstacles, *self._on_floor, *([] if box is None else [box])]
        return FreeSpace(self._plan.outline, [corners(other) for other in boxes]).area


def rearranged(
    things: Sequence[Thing], empty: Arrangement, kinds: Sequence[Kind], rng: np.random.Generator
) -> tuple[Thing, ...]:
    """Return other things in other places: some gone, some new, all the others moved.

    empty: the room's places, none taken.
    """
    stay = [thing for thing in things if rng.random() >= _LEFT_OUT]
    for number in rng.permutation(len(stay)):
        empty.put(stay[number], rng)
    for is_on_floor in (False, True):
        n_new = round(_ADDED * sum(thing.is_on_floor == is_on_floor for thing in things))
        place = "floor" if is_on_floor else "table"
        fitting = [kind for kind in kinds if place in kind.places]
        for kind in draw_kinds(fitting, n_new, rng):
            empty.put(Thing(kind, kind.draw(rng), is_on_floor, np.eye(4)), rng)
    return tuple(empty.things)


def draw_kinds(kinds: Sequence[Kind], n: int, rng: np.random.Generator) -> Iterator[Kind]:
    """Yield n kinds; none comes a second time before all have come."""
    order: list[int] = []
    for _ in range(n if kinds else 0):
        order = order or rng.permutation(len(kinds)).tolist()
        yield kinds[order.pop()]


def corners(box: Box) -> Polygon:
    """Return the (4, 2) corners of a box, counter-clockwise."""
    x_min, y_min, x_max, y_max = box
    return np.array([(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)])


def _bounds(mesh: Mesh, pose: Pose) -> Box:
    """Return the box around a mesh seen from above."""
    places = mesh.vertices[:, :2] @ pose[:2, :2].T + pose[:2, 3]
    return np.concatenate([places.min(0), places.max(0)])


def _box_around(polygon: Polygon) -> Box:
    return np.concatenate([polygon.min(0), polygon.max(0)])


def _area(box: Box) -> float:
    return float((box[2] - box[0]) * (box[3] - box[1]))


def _grown(box: Box, by: float) -> Box:
    return np.asarray(box + np.array([-by, -by, by, by]), np.float64)


def _meets_any(box: Box, others: Sequence[Box]) -> bool:
    if not others:
        return False
    all_others = np.asarray(others)
    apart = (all_others[:, :2] > box[2:]) | (all_others[:, 2:] < box[:2])
    return bool((~apart.any(1)).any())


def _is_inside(box: Box, plan: FloorPlan) -> bool:
    walls = [np.concatenate([wall.ends.min(0), wall.ends.max(0)]) for wall in plan.walls]
    return not _meets_any(box, walls) and bool(plan.contains((box[:2] + box[2:]) / 2))
