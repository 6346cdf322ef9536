"""Write the saliency of images: of a learned model or of a baseline."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.errors import DataError
from curiosight.experiments.components import heard, make_teacher, place
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame
from curiosight.learner.description import Saliency
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.observation import Teaches

# By the folder that they are written to: "" is that of the saliency maps.
MapsOf = Callable[[Frame], Mapping[str, npt.NDArray[Any]]]
SEEN, UNCERTAINTY, PROBABILITY = "seen", "uncertainty", "probability"
# Of decoded frames: the few that are decoded ahead.
FRAMES_MB = 8


class MapWriting:
    """Map every frame of a recording, frame by frame.

    maps_of: from a frame to (H, W) maps in [0, 1], by folder; a `ValueError` says why it cannot.
    n_seen, n_mapped: frames so far, and those that have a map.
    """

    def __init__(
        self,
        config: Config,
        maps_of: MapsOf,
        dataset: Dataset,
        out: OutputFolder,
    ) -> None:
        self.problems = Problems()
        self.n_seen = self.n_mapped = 0
        # Each frame is looked at once: what was is not kept.
        self._memory_mb = min(config.run.memory_mb, FRAMES_MB)
        self._maps_of = maps_of
        self._dataset = dataset
        self._out = out

    def __iter__(self) -> Iterator[tuple[Frame, Saliency | None]]:
        """Yield each frame with its saliency, None where there is none, once all is written.

        <id>.png and seen/<id>.png and so on are 8 bit, of the colour image's size: 255 is 1.
        """
        with Prefetch(self._dataset, memory_mb=self._memory_mb) as frames:
            for frame in frames.in_order(range(len(self._dataset))):
                maps, problem = _map(self._maps_of, frame)
                self.n_seen += 1
                if problem is not None:
                    self.problems.add(frame, problem)
                self.n_mapped += bool(maps)
                for folder, shown in maps.items():
                    grey = np.rint(255 * shown.astype(np.float32)).astype(np.uint8)
                    self._out.write_image(f"{folder}/{frame.id}.png".lstrip("/"), grey)
                yield frame, maps.get("")


def _map(maps_of: MapsOf, frame: Frame) -> tuple[Mapping[str, npt.NDArray[Any]], str | None]:
    """Return an image's maps, or none and why.

    What is wrong with a frame's depth or pose does not matter: its colour is not black then.
    """
    if frame.problem is not None and not frame.rgb.any():
        return {}, frame.problem
    try:
        return maps_of(frame), None
    except ValueError as error:  # too small an image, say
        return {}, str(error)


class LearnedMaps:
    """What a model says of a frame, as maps by folder.

    with_poses: tell the model from where a frame was taken.
    with_depth: use the depth at hand, too, which the learner's teacher reads; where a frame has
        none, or one that cannot be used, all is remembered. The maps "seen" tell which is which.
    folders: of `UNCERTAINTY` and `PROBABILITY`, which maps to make beside the saliency.
    """

    def __init__(
        self,
        learner: SaliencyLearner,
        *,
        with_poses: bool = True,
        with_depth: bool = False,
        folders: frozenset[str] = frozenset(),
    ) -> None:
        self._learner = learner
        self._with_poses, self._with_depth = with_poses, with_depth
        self._folders = folders

    def __call__(self, frame: Frame) -> Mapping[str, npt.NDArray[Any]]:
        pose = frame.T_world_camera if self._with_poses else None
        is_usable = self._with_depth and frame.problem is None
        depth, camera = (frame.depth, frame.camera) if is_usable else (None, None)
        if not (self._with_depth or self._folders):
            return {"": self._learner.saliency(frame.rgb, pose)}
        is_asked = UNCERTAINTY in self._folders
        maps = self._learner.maps(frame.rgb, pose, depth, camera, with_uncertainty=is_asked)
        made: dict[str, npt.NDArray[Any]] = {"": maps.saliency}
        if self._with_depth:
            made[SEEN] = maps.is_seen
        if PROBABILITY in self._folders:
            made[PROBABILITY] = maps.probability
        if maps.uncertainty is not None:
            made[UNCERTAINTY] = maps.uncertainty
        return made


def make_map_teacher(config: Config, dataset: Dataset) -> Teaches:
    """Return what reads the depth at hand of a recording; `DataError` where it has none.

    Where the settings say so, it remembers what the frames before have shown.
    """
    if config.teacher.is_depth and not dataset.has_depth:
        found = f"{dataset.name} has no depth to fuse with what was learned"
        raise DataError(place(dataset), found, "map it without --depth")
    return heard(config, make_teacher(config, dataset))
