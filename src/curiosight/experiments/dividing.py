"""Divide what can be looked at into regions, and say how long the ways between them are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset, GraphNode, Prefetch, RlIac
from curiosight.experiments.components import make_world
from curiosight.experiments.ways import ways_between
from curiosight.explorer import Regions, make_regions
from curiosight.explorer.from_above import seen_from_above
from curiosight.explorer.ground import Ground
from curiosight.explorer.grouping import MetresFrom
from curiosight.explorer.navigation import RegionWays, make_graph
from curiosight.explorer.regions import needs_places, needs_ways
from curiosight.frame import Pose, Viewpoint
from curiosight.learner.looks import look_of
from curiosight.learner.places import NOWHERE, Places
from curiosight.learner.sight import Sight
from curiosight.teacher import Survey
from curiosight.worlds.travel import travel_seconds

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def choose_regions(config: Config, dataset: Dataset, survey: Survey | None = None) -> Regions:
    """Divide a recording into regions as the settings ask, else as a table of its own says."""
    is_by_ways = needs_ways(config.explorer.regions or None)
    up = None if survey is None else survey.up_world
    return divide_views(
        config,
        dataset.poses,
        dataset.ids,
        metres=ways_between(dataset, range(len(dataset))) if is_by_ways else None,
        up=up,
        own=own_region_table(dataset),
        sights=_sights(dataset, up),
    )


def divide_views(
    config: Config,
    poses: Sequence[Pose | None],
    ids: Sequence[str],
    *,
    metres: MetresFrom | None,
    up: npt.ArrayLike | None,
    sights: Iterable[Sight | None],
    own: Path | None = None,
) -> Regions:
    """Divide views into regions as the settings ask; metres, up: see `make_regions`.

    sights: of each view, None = of none; read only where regions are the learner's places.
    own: the table that says it where the settings do not.
    """
    spec = config.explorer.regions or (None if own is None else str(own))
    return make_regions(
        spec,
        poses,
        ids,
        metres=metres,
        places=learner_places(config, sights) if needs_places(spec) else None,
        position_split=config.explorer.position_split,
        orientation_split=config.explorer.orientation_split,
        up=up,
    )


def learner_places(config: Config, sights: Iterable[Sight | None]) -> Ints:
    """Return the (n,) place that the learner tells each view to be of once it has seen all.

    sights: of the views; one of None is of place -1.
    """
    places = Places(config.learner.max_places) if config.learner.max_places else Places()
    spots = [NOWHERE if sight is None else places.add(sight) for sight in sights]
    places.tell_apart()
    return np.array([NOWHERE if spot < 0 else places.place_of_spot[spot] for spot in spots])


def _sights(dataset: Dataset, up: npt.NDArray[np.float64] | None) -> Iterator[Sight | None]:
    """Look from every view once; None of a bad frame."""
    with Prefetch(dataset) as frames:
        for frame in frames.in_order(range(len(dataset))):
            yield None if frame.problem else Sight.of(frame, look_of(frame.rgb), up)


def own_region_table(dataset: Dataset) -> Path | None:
    """Return the table that divides a recording, where it has one that does."""
    if isinstance(dataset, RlIac) and len(set(dataset.regions)) > 1:
        return dataset.region_table
    return None


def graph_ways(regions: Regions, poses: Sequence[Pose | None]) -> RegionWays | None:
    """Return the ways by a navigation graph, where there is one and no view has a pose."""
    if regions.seconds is None or any(pose is not None for pose in poses):
        return None
    return RegionWays(regions.seconds)


def region_graph(
    config: Config, dataset: Dataset, regions: Regions, up: npt.ArrayLike | None
) -> tuple[GraphNode, ...]:
    """Return the navigation graph of a recording's regions; empty for one, or without ways.

    By the ways between views where all that are in a region have poses, else by the graph that
    came with the regions.
    """
    inside = np.flatnonzero(regions.of_view >= 0).tolist()
    poses = [dataset.poses[view] for view in inside]
    known = all(pose is not None for pose in poses)
    if regions.n_regions < 2:
        return ()
    if not known and regions.seconds is not None:
        nowhere = np.zeros((regions.n_regions, 2))
        return make_graph(regions.seconds, regions.seconds.diagonal(), nowhere)
    if not known:
        return ()
    with make_world(config, dataset, regions, inside) as world:

        def seconds(start: Viewpoint, goals: Sequence[Viewpoint]) -> Floats:
            return travel_seconds(*world.ways(start, goals))

        ground = Ground(world.views, seconds)
        above = seen_from_above(poses, up)
        places = [above.positions[members].mean(axis=0) for members in ground.members]
        return make_graph(ground.between, ground.inside, np.array(places))
